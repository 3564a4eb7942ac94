# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The kinematic state of a body: pose and reduced states, with their pole and axes."""
from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .errors import InvalidValueError, ShapeError, UnknownNameError
from .se3 import Array, matvec, rotate, shift_pole
from .states import classical_from_reduced

_ORDERS = ('velocity', 'acceleration', 'jerk', 'jounce')
_FRAMES = ('base', 'tip')


@dataclass(frozen=True, eq=False)
class BodyState:
    """
    Motion of the tip body relative to the base.

    Parameters
    ----------
    pose : array, shape (..., 4, 4)
        T_base_tool; always maps tool coordinates to base coordinates.
    reduced : tuple of array, shape (..., 6)
        Reduced states of order 1, 2, ... about ``pole_in_base``, in the axes ``axes``.
    pole : str
        'tip', 'base' or 'point': which point the states refer to.
    axes : {'base', 'tip'}
        Whose axes the components are in.
    pole_in_base : array, shape (..., 3)
        The pole in base coordinates [m].
    base_frame, tip_frame : str
        Frame names.

    """

    pose: Array
    reduced: tuple[Array, ...]
    pole_in_base: Array
    pole: str = 'tip'
    axes: str = 'base'
    base_frame: str = 'base'
    tip_frame: str = 'tool'

    @property
    def velocity(self) -> Array:
        """Velocity state (twist) V = (w ; v), shape (..., 6) [rad/s, m/s]."""
        return self._order(1)

    @property
    def acceleration(self) -> Array:
        """Reduced acceleration A = (alpha ; a - w x v), shape (..., 6)."""
        return self._order(2)

    @property
    def jerk(self) -> Array:
        """Reduced jerk J = (rho ; j - 2 alpha x v - w x a), shape (..., 6)."""
        return self._order(3)

    @property
    def jounce(self) -> Array:
        """Return the reduced snap S, the state of order four, shape (..., 6)."""
        return self._order(4)

    @property
    def snap(self) -> Array:
        """Another name of :attr:`jounce`."""
        return self.jounce

    def _order(self, n: int) -> Array:
        if not 1 <= n <= len(self.reduced):
            name = _ORDERS[n - 1] if 1 <= n <= 4 else f'order {n}'
            raise InvalidValueError(
                f'{name} needs the joint derivatives of order 1 to {n}; '
                f'this state was computed with {len(self.reduced)}')
        return self.reduced[n - 1]

    def classical(self, n: int) -> Array:
        """
        Return the n-th derivative of orientation and position of the point at the pole.

        n = 1 is the twist ``[w; v]``, 2 ``[alpha; a]``, 3 ``[rho; j]``, 4 ``[sigma; s]``,
        with v, a, j, s of the body's material point now at the pole.

        Returns
        -------
        array, shape (..., 6)

        """
        self._order(n)
        return classical_from_reduced(self.reduced[:n])[n - 1]

    def about(self, pole: str | Array) -> BodyState:
        """
        Return the same state about another pole.

        Parameters
        ----------
        pole : 'base', 'tip' or array, shape (..., 3)
            Origin of the base, origin of the tip frame, or a point in base
            coordinates [m].

        """
        if isinstance(pole, str):
            if pole not in _FRAMES:
                raise UnknownNameError('pole', pole, _FRAMES)
            tip = self.pose[..., :3, 3]
            name, target = pole, tip if pole == 'tip' else 0 * tip
        else:
            name, target = 'point', np.asarray(pole)
            if target.shape[-1:] != (3,):
                raise ShapeError('pole', '(..., 3)', target.shape)
        displacement = target - self.pole_in_base
        if self.axes == 'tip':
            displacement = matvec(self._tip_from_base(), displacement)
        moved = tuple(shift_pole(x, displacement) for x in self.reduced)
        return replace(self, reduced=moved, pole=name, pole_in_base=target)

    def expressed_in(self, axes: str) -> BodyState:
        """
        Return the same state with components in other axes, 'base' or 'tip'.

        The pole stays. In tip axes the components of the jerk are not the second time
        derivative of the components of the twist: differentiation comes before the
        change of axes.
        """
        if axes not in _FRAMES:
            raise UnknownNameError('axes', axes, _FRAMES)
        if axes == self.axes:
            return self
        tip_from_base = self._tip_from_base()
        rotation = tip_from_base if axes == 'tip' else np.swapaxes(tip_from_base, -1, -2)
        turned = tuple(rotate(rotation, x) for x in self.reduced)
        return replace(self, reduced=turned, axes=axes)

    def _tip_from_base(self) -> Array:
        return np.swapaxes(self.pose[..., :3, :3], -1, -2)
