# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The quantities of a tip's motion: the one table of names, orders, sizes, words, units, symbols.

Compiled programs, formulas, source text, tables and figures name them alike.
"""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ..errors import InvalidValueError, UnknownNameError
from ..screws.body_state import BodyState
from ..screws.reference import check_axes, FRAMES
from ..screws.se3 import Array

PER_SECOND = ('', '/s', '/s^2', '/s^3', '/s^4')


class Part(NamedTuple):
    """The angular or the linear part of a quantity."""

    symbol: str    # in formulas
    latex: str
    unit: str      # in SI
    title: str     # over a figure


@dataclass(frozen=True)
class Quantity:
    """A quantity."""

    name: str                       # as the outputs of compiled chains are called
    order: int                      # highest derivative of the joint positions in it
    meaning: str                    # in words
    parts: tuple[Part, ...] = ()    # angular or first, linear or second; none of what is of joints
    reduced: bool = False           # the reduced state of its order, not the classical motion
    per: str = ''                   # 'joint', 'measured joint', 'passive joint': one for each

    def size(self, dof: int, joints: int = 0, passive: int = 0) -> int:
        """Return how many numbers it has, by the numbers of measured, all, and passive joints."""
        if self.name == 'pose':
            return 12
        each = 1 if self.per == 'passive joint' else 6
        return each * {'': 1, 'joint': joints, 'measured joint': dof,
                       'passive joint': passive}[self.per]

    def of(self, state: BodyState) -> Array:
        """Return the quantity of a state, about the state's pole and in its axes."""
        if self.name == 'pose':
            return state.pose
        return state.reduced[self.order - 1] if self.reduced else state.classical(self.order)

    def components(self) -> list[str]:
        """Return the names of the components: w_x, ..."""
        if self.name == 'pose':
            return [f'p_{a}' for a in 'xyz'] + [f'R_{i}{j}' for i in '123' for j in '123']
        return [f'{part.symbol}_{axis}' for part in self.parts for axis in 'xyz']

    def latex_components(self) -> list[str]:
        """Return the LaTeX symbols of the components."""
        if self.name == 'pose':
            return [f'p_{{{a}}}' for a in 'xyz'] + [
                f'R_{{{i}{j}}}' for i in '123' for j in '123']
        return [f'{part.latex}_{{{axis}}}' for part in self.parts for axis in 'xyz']

    def described(self) -> str:
        """Return its meaning and its units."""
        if not self.parts:
            return self.meaning
        units = ', '.join(f'{part.symbol} in {part.unit}' for part in self.parts)
        return f'{self.meaning} ({units})'


def _pair(order: int, angular: tuple[str, str, str], linear: tuple[str, str]) -> tuple[Part, ...]:
    unit = PER_SECOND[order]
    symbol, latex, title = angular
    return (Part(symbol, latex, f'rad{unit}', title),
            Part(linear[0], linear[0], f'm{unit}', linear[1]))


_W = ('w', r'\omega', 'angular velocity w')
_ALPHA = ('alpha', r'\alpha', 'angular acceleration')
_RHO = ('rho', r'\rho', 'angular jerk')
_SIGMA = ('sigma', r'\sigma', 'angular snap')

ALL = (
    Quantity('pose', 0, 'position p, then rotation matrix R of the tip frame, row by row', (
        Part('p', 'p', 'm', 'position p'),
        Part('R', 'R', '1', 'orientation (x: roll, y: pitch, z: yaw)'))),
    Quantity('twist', 1, 'angular velocity w and linear velocity v',
             _pair(1, _W, ('v', 'linear velocity v'))),
    Quantity('accel', 2, 'angular acceleration alpha and classical linear acceleration a',
             _pair(2, _ALPHA, ('a', 'acceleration a'))),
    Quantity('reduced_accel', 2, 'reduced acceleration state: alpha, and A = a - w x v',
             _pair(2, _ALPHA, ('A', 'reduced acceleration a - w x v')), reduced=True),
    Quantity('jerk', 3, 'angular jerk rho and classical linear jerk j',
             _pair(3, _RHO, ('j', 'jerk j'))),
    Quantity('reduced_jerk', 3, 'reduced jerk state: rho, and J = j - 2 alpha x v - w x a',
             _pair(3, _RHO, ('J', 'reduced jerk, dual part')), reduced=True),
    Quantity('snap', 4, 'angular snap sigma and classical linear snap s',
             _pair(4, _SIGMA, ('s', 'snap s'))),
    Quantity('reduced_snap', 4,
             'reduced snap state: sigma, and S = s - 3 rho x v - 3 alpha x a - w x j',
             _pair(4, _SIGMA, ('S', 'reduced snap, dual part')), reduced=True),
    Quantity('screws', 0, 'unit screws [w; v] of the joints, from base to tip', per='joint'),
    Quantity('jacobian', 0, 'twist [w; v] of the unit rate of each measured joint',
             per='measured joint'),
    Quantity('coriolis_lie', 1, 'Coriolis-Lie term: reduced acceleration at zero joint '
             'accelerations', (Part('alpha_L', r'\alpha^{L}', 'rad/s^2', 'Coriolis-Lie term'),
                               Part('A_L', 'A^{L}', 'm/s^2', 'Coriolis-Lie term')),
             reduced=True),
    Quantity('passive_position', 0, 'positions of the passive joints [rad, m]',
             per='passive joint'),
    Quantity('passive_velocity', 1, 'velocities of the passive joints [rad/s, m/s]',
             per='passive joint'),
)
"""Every quantity."""
SIX_VECTORS = tuple(quantity for quantity in ALL if quantity.order and quantity.parts
                    and quantity.name != 'coriolis_lie')
"""Those that are six-vectors of a body's state."""
NAMES = tuple(quantity.name for quantity in ALL if quantity.per != 'passive joint')
"""Names of what an open chain has."""
WITHOUT_SCREWS = tuple(quantity.name for quantity in ALL
                       if quantity.name not in ('screws', 'coriolis_lie'))
"""All but the joints' screws and their products: of parallel robots, and on a moving base."""
_BY_NAME = {quantity.name: quantity for quantity in ALL}
_LONG = {'velocity': 'twist', 'acceleration': 'accel',
         'reduced_acceleration': 'reduced_accel', 'jounce': 'snap', 'reduced_jounce':
         'reduced_snap'}


def find_quantity(name: str, known: Iterable[str] = NAMES) -> Quantity:
    """
    Return a quantity by its name, short or long; raise UnknownNameError if there is none.

    Examples
    --------
    >>> find_quantity('acceleration').name
    'accel'

    """
    known = tuple(known)
    short = _LONG.get(name, name)
    if short not in known:
        raise UnknownNameError(
            'quantity', name, (*known, *(a for a, b in _LONG.items() if b in known)))
    return _BY_NAME[short]


def checked_outputs(outputs: Iterable[str], axes: str, pole: str,
                    known: Iterable[str] = NAMES) -> tuple[str, ...]:
    """
    Return the names of a program's outputs, after checking them, axes and pole.

    Raises
    ------
    UnknownNameError, InvalidValueError
        An output, the axes or the pole are unknown, or an output is asked for twice.

    Examples
    --------
    >>> checked_outputs('twist', 'base', 'tip')
    ('twist',)

    """
    known = tuple(known)
    outputs = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    if not outputs:
        raise InvalidValueError(f'no outputs asked for; known: {", ".join(known)}')
    for output in outputs:
        if output not in known:
            raise UnknownNameError('output', output, known)
        if outputs.count(output) > 1:
            raise InvalidValueError(f'output {output!r} is asked for more than once')
    check_axes(axes)
    if pole not in FRAMES:
        raise UnknownNameError('pole', pole, FRAMES)
    return outputs


def order_of(outputs: Sequence[str]) -> int:
    """
    Return the highest derivative of the joint positions that some outputs need.

    Examples
    --------
    >>> order_of(['pose', 'jerk'])
    3

    """
    return max((_BY_NAME[output].order for output in outputs), default=0)
