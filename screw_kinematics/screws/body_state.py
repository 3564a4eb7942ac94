# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The kinematic state of a body: pose and reduced states, with their pole and axes.

States of bodies that move relative to each other combine: a moving base
(:meth:`BodyState.followed_by`), a moving observer (:meth:`BodyState.relative_to`), another
frame of the same body (:meth:`BodyState.with_tool`).
"""
from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .reference import check_axes, resolve_pole
from .rigid import checked_pose
from .se3 import Array, inverse, matvec, rotate, shift_pole
from .states import body_derivatives, classical_from_reduced, compose, relative
from .vectors import checked_array
from ..errors import InvalidValueError

__all__ = ['BodyState']

_ORDERS = ('velocity', 'acceleration', 'jerk', 'snap')


@dataclass(frozen=True, eq=False)
class BodyState:
    """
    Motion of the tip body relative to the base.

    Six-vectors are reduced states or classical derivatives: the names of attributes say
    which, and only of the velocity they are the same.

    Parameters
    ----------
    pose : array, shape (..., 4, 4)
        T_base_tool; always maps tool coordinates to base coordinates.
    reduced : tuple of array, shape (..., 6)
        Reduced states of order 1, 2, ... about ``pole_in_base``, in the axes ``axes``.
    pole_in_base : array, shape (..., 3)
        The pole in base coordinates [m].
    pole : str
        'tip', 'base' or 'point': which point the states refer to.
    axes : {'base', 'tip'}
        Whose axes the components are in.
    base_frame, tip_frame : str
        Frame names.

    Raises
    ------
    ShapeError, InvalidValueError
        The pose is no rigid displacement within 1e-6, or a state no six-vector.

    """

    pose: Array
    reduced: tuple[Array, ...]
    pole_in_base: Array
    pole: str = 'tip'
    axes: str = 'base'
    base_frame: str = 'base'
    tip_frame: str = 'tool'

    def __post_init__(self) -> None:
        checked_pose('pose', self.pose)
        for n, state in enumerate(self.reduced, start=1):
            checked_array(f'reduced state of order {n}', state, (..., 6))

    @property
    def velocity(self) -> Array:
        """Velocity state (twist) V = (w ; v), shape (..., 6) [rad/s, m/s]."""
        return self._order(1)

    @property
    def classical_acceleration(self) -> Array:
        """Acceleration [alpha ; a] of the body point at the pole, shape (..., 6)."""
        return self.classical(2)

    @property
    def reduced_acceleration(self) -> Array:
        """Reduced acceleration A = (alpha ; a - w x v), shape (..., 6)."""
        return self._order(2)

    @property
    def classical_jerk(self) -> Array:
        """Jerk [rho ; j] of the body point at the pole, shape (..., 6)."""
        return self.classical(3)

    @property
    def reduced_jerk(self) -> Array:
        """Reduced jerk J = (rho ; j - 2 alpha x v - w x a), shape (..., 6)."""
        return self._order(3)

    @property
    def classical_snap(self) -> Array:
        """Snap (jounce) [sigma ; s] of the body point at the pole, shape (..., 6)."""
        return self.classical(4)

    @property
    def reduced_snap(self) -> Array:
        """Reduced snap (jounce) S, the state of order four, shape (..., 6)."""
        return self._order(4)

    def _order(self, n: int) -> Array:
        if n < 1:
            raise InvalidValueError(f'order {n} of a state; allowed: 1 (the velocity) or more')
        if n > len(self.reduced):
            name = _ORDERS[n - 1] if n <= 4 else f'order {n}'
            raise InvalidValueError(
                f'{name} needs the joint derivatives of order 1 to {n}; '
                f'this state was computed with {len(self.reduced)}')
        return self.reduced[n - 1]

    def classical(self, n: int) -> Array:
        """
        Return the n-th derivative of orientation and position of the point at the pole.

        n = 1 is the twist ``[w; v]``, 2 ``[alpha; a]``, 3 ``[rho; j]``, 4 ``[sigma; s]``,
        with v, a, j, s of the body's material point now at the pole.

        Parameters
        ----------
        n : int
            From 1 to the order of this state.

        Returns
        -------
        array, shape (..., 6)
            About the pole, in the axes of this state.

        Raises
        ------
        InvalidValueError
            The state was computed with fewer derivatives.

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

        Returns
        -------
        BodyState
            Of the same body, in the same axes.

        Raises
        ------
        UnknownNameError, ShapeError
            There is no such pole, or the point has not three coordinates.

        """
        name, target = resolve_pole(pole, self.pose)
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
        change of axes. For derivatives of tip components see :meth:`body_derivatives`.

        Parameters
        ----------
        axes : {'base', 'tip'}
            Whose axes.

        Returns
        -------
        BodyState
            About the same pole.

        Raises
        ------
        UnknownNameError
            There are no such axes.

        """
        check_axes(axes)
        if axes == self.axes:
            return self
        tip_from_base = self._tip_from_base()
        rotation = tip_from_base if axes == 'tip' else np.swapaxes(tip_from_base, -1, -2)
        turned = tuple(rotate(rotation, x) for x in self.reduced)
        return replace(self, reduced=turned, axes=axes)

    def body_derivatives(self) -> list[Array]:
        """
        Return the twist of the tip in tip axes and the derivatives of its components.

        What differentiating a tool-frame twist gives: the second is the reduced
        acceleration in tip axes, but the third is not the jerk.

        Returns
        -------
        list of array, shape (..., 6)
            As many as the state has orders; pole and axes: tip.

        """
        return body_derivatives(self.about('tip').expressed_in('tip').reduced)

    @classmethod
    def at_rest(cls, pose: Array, order: int, base_frame: str = 'base',
                tip_frame: str = 'tool') -> BodyState:
        """
        Return the state of a body that stays at a pose.

        Parameters
        ----------
        pose : array, shape (..., 4, 4)
            T_base_tool.
        order : int
            How many (zero) states to hold.
        base_frame, tip_frame : str
            Frame names.

        Returns
        -------
        BodyState

        Raises
        ------
        ShapeError, InvalidValueError
            The pose is no rigid displacement within 1e-6.

        """
        pose = checked_pose('pose', pose)
        position = pose[..., :3, 3]
        zero = np.concatenate([0 * position, 0 * position], axis=-1)
        return cls(pose, (zero,) * order, position,
                   base_frame=base_frame, tip_frame=tip_frame)

    def with_tool(self, T_tip_tool: Array,    # noqa: N803
                  tip_frame: str = 'tool') -> BodyState:
        """
        Return the state of another frame of the same body, about its origin.

        Parameters
        ----------
        T_tip_tool : array, shape (..., 4, 4)
            Pose of the other frame in the present tip frame [m].
        tip_frame : str
            Name of the other frame.

        Returns
        -------
        BodyState
            Pole at the new tip, axes of the base.

        Raises
        ------
        ShapeError, InvalidValueError
            T_tip_tool is no rigid displacement within 1e-6.

        """
        T_tip_tool = checked_pose('T_tip_tool', T_tip_tool)    # noqa: N806
        fixed = BodyState.at_rest(T_tip_tool, len(self.reduced), tip_frame=tip_frame)
        return self.followed_by(fixed)

    def followed_by(self, inner: BodyState) -> BodyState:
        """
        Return the motion of a body that moves relative to this one (composition).

        Parameters
        ----------
        inner : BodyState
            Motion of the other body relative to this body's tip frame, which is its base.

        Returns
        -------
        BodyState
            Motion of the other body relative to this body's base, to the lower order of
            the two; pole at its tip, axes of the base.

        References
        ----------
        The paper, section 2.4.2.

        Examples
        --------
        >>> turning = np.array([0, 0, 1, 0, 0, 0])
        >>> table = BodyState(np.eye(4), (turning,), np.zeros(3))
        >>> T = np.array([[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
        >>> table.followed_by(BodyState.at_rest(T, 1)).velocity
        array([0., 0., 1., 0., 2., 0.])

        """
        pose = self.pose @ inner.pose
        tip = pose[..., :3, 3]
        order = min(len(self.reduced), len(inner.reduced))
        outer = self.expressed_in('base').about(tip).reduced[:order]
        seen = inner.expressed_in('base').about('tip').reduced[:order]
        turned = [rotate(self.pose[..., :3, :3], x) for x in seen]
        return BodyState(pose, tuple(compose(outer, turned)), tip,
                         base_frame=self.base_frame, tip_frame=inner.tip_frame)

    def relative_to(self, observer: BodyState) -> BodyState:
        """
        Return this body's motion as observed from another moving body.

        Parameters
        ----------
        observer : BodyState
            Motion of the observing body relative to the same base.

        Returns
        -------
        BodyState
            Its base is the observer's tip frame; to the lower order of the two; pole at
            this body's tip, axes of the observer's tip frame.

        Examples
        --------
        >>> turning = np.array([0, 0, 1, 0, 0, 0])
        >>> table = BodyState(np.eye(4), (turning,), np.zeros(3))
        >>> BodyState.at_rest(np.eye(4), 1).relative_to(table).velocity
        array([ 0.,  0., -1.,  0.,  0.,  0.])

        """
        tip = self.pose[..., :3, 3]
        order = min(len(self.reduced), len(observer.reduced))
        mine = self.expressed_in('base').about(tip).reduced[:order]
        watching = observer.expressed_in('base').about(tip).reduced[:order]
        back = inverse(observer.pose)
        seen = tuple(rotate(back[..., :3, :3], x) for x in relative(mine, watching))
        pose = back @ self.pose
        return BodyState(pose, seen, pose[..., :3, 3],
                         base_frame=observer.tip_frame, tip_frame=self.tip_frame)

    def _tip_from_base(self) -> Array:
        return np.swapaxes(self.pose[..., :3, :3], -1, -2)
