# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The quantities that formulas are derived for: names, components, meaning, units."""
from __future__ import annotations

from typing import NamedTuple

from ..errors import UnknownNameError


class Quantity(NamedTuple):
    """
    A quantity.

    Attributes
    ----------
    name : str
        As the outputs of compiled chains are called.
    order : int
        Highest derivative of the joint positions in it.
    meaning : str
    parts : tuple of (str, str, str)
        For the angular and the linear part: symbol, symbol in LaTeX, unit.

    """

    name: str
    order: int
    meaning: str
    parts: tuple[tuple[str, str, str], ...]

    def components(self) -> list[str]:
        """Return the names of the six components: w_x, ..."""
        return [f'{symbol}_{axis}' for symbol, _, _ in self.parts for axis in 'xyz']

    def described(self) -> str:
        """Return its meaning and its units."""
        return f'{self.meaning} ({", ".join(f"{s} in {unit}" for s, _, unit in self.parts)})'

    def latex_components(self) -> list[str]:
        """Return the LaTeX symbols of the six components."""
        return [f'{symbol}_{{{axis}}}' for _, symbol, _ in self.parts for axis in 'xyz']


_ALPHA = ('alpha', r'\alpha', 'rad/s^2')
_RHO = ('rho', r'\rho', 'rad/s^3')
_SIGMA = ('sigma', r'\sigma', 'rad/s^4')

POSE = Quantity('pose', 0, 'position p, then rotation matrix R of the tip frame, row by row',
                (('p', 'p', 'm'), ('R', 'R', '1')))
SIX_VECTORS = (
    Quantity('twist', 1, 'angular velocity w and linear velocity v',
             (('w', r'\omega', 'rad/s'), ('v', 'v', 'm/s'))),
    Quantity('accel', 2, 'angular acceleration alpha and classical linear acceleration a',
             (_ALPHA, ('a', 'a', 'm/s^2'))),
    Quantity('reduced_accel', 2, 'reduced acceleration state: alpha, and A = a - w x v',
             (_ALPHA, ('A', 'A', 'm/s^2'))),
    Quantity('jerk', 3, 'angular jerk rho and classical linear jerk j',
             (_RHO, ('j', 'j', 'm/s^3'))),
    Quantity('reduced_jerk', 3, 'reduced jerk state: rho, and J = j - 2 alpha x v - w x a',
             (_RHO, ('J', 'J', 'm/s^3'))),
    Quantity('snap', 4, 'angular snap sigma and classical linear snap s',
             (_SIGMA, ('s', 's', 'm/s^4'))),
    Quantity('reduced_snap', 4,
             'reduced snap state: sigma, and S = s - 3 rho x v - 3 alpha x a - w x j',
             (_SIGMA, ('S', 'S', 'm/s^4'))),
)
NAMES = tuple(quantity.name for quantity in (POSE, *SIX_VECTORS))
_LONG = {'velocity': 'twist', 'acceleration': 'accel',
         'reduced_acceleration': 'reduced_accel', 'jounce': 'snap', 'reduced_jounce':
         'reduced_snap'}


def find_quantity(name: str) -> Quantity:
    """
    Return a quantity by its name, short or long.

    Raises
    ------
    UnknownNameError
        There is none of that name.

    Examples
    --------
    >>> find_quantity('acceleration').name
    'accel'

    """
    short = _LONG.get(name, name)
    for quantity in (POSE, *SIX_VECTORS):
        if quantity.name == short:
            return quantity
    raise UnknownNameError('quantity', name, (*NAMES, *_LONG))
