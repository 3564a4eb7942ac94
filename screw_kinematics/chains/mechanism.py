# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
What every manipulator brings: forward problem, states and Jacobian by its measured joints.

What a method of a class of mechanisms does beyond this is said there; where it does not, it has no
docstring of its own.
"""
from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..errors import InvalidValueError, ShapeError
from ..screws.body_state import BodyState
from ..screws.se3 import Array

__all__ = ['MAX_ORDER', 'Mechanism']

MAX_ORDER = 4
"""Highest time derivative of the joints' positions."""


class Mechanism(ABC):
    """A mechanism that moves a tip frame relative to a base frame by measured joints."""

    joint_names: tuple[str, ...]
    """Of the measured joints, in the order of q; those that mimic others are none."""
    dof: int
    """Number of measured joints."""
    joint_kinds: tuple[str, ...]
    """Of the measured joints: 'revolute', 'continuous' or another."""
    prismatic: Array
    """Which measured joints are in m rather than rad, shape (dof,)."""
    velocity_limits: Array
    """Their largest speeds [rad/s, m/s], infinite if unknown; shape (dof,)."""
    base_frame: str
    tip_frame: str
    warnings: tuple[str, ...] = ()
    """What its description has that the robot has not."""
    fixed_frames: Mapping[str, Array]
    """Poses in the tip frame of the frames that are fixed to it, itself among them [m]."""
    fixed_to_base: Mapping[str, Array]
    """The same of the base frame."""

    @abstractmethod
    def with_tool(self, T_tip_tool: Any,    # noqa: N803
                  tip_frame: str | None = None) -> Mechanism:
        """
        Return the manipulator with a tool mounted on its tip.

        Parameters
        ----------
        T_tip_tool : array, shape (4, 4)
            Pose of the tool in the present tip frame [m].
        tip_frame : str, optional
            Name of the new tip frame.

        Returns
        -------
        same class
            With the tool's frame as its tip.

        Raises
        ------
        ShapeError, InvalidValueError
            The pose is no rigid displacement.

        """

    @abstractmethod
    def jacobian(self, q: Any, pole: str | Array = 'tip', axes: str = 'base') -> Array:
        """
        Return the Jacobian: its columns are the tip's twists of unit rates of the joints.

        Of a serial chain they are the unit screws of the measured joints; a joint that others
        mimic has the sum of all their screws, times the multipliers.

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions of the measured joints [rad, m].
        pole : 'tip', 'base' or array, shape (..., 3)
            The point the moments refer to; an array is in base coordinates [m].
        axes : {'base', 'tip'}
            Whose axes the components are in.

        Returns
        -------
        array, shape (..., 6, dof)
            ``jacobian @ qd`` is the twist.

        Raises
        ------
        ShapeError, InvalidValueError, UnknownNameError
            Joint values of a wrong shape, or no such pole or axes.

        References
        ----------
        The paper, section 2.4.1.

        """

    @abstractmethod
    def state(self, q: Any, *derivatives: Any) -> BodyState:
        """
        Return pose and reduced states of the tip.

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions of the measured joints [rad, m].
        *derivatives : array, shape (..., dof)
            Their first to at most fourth time derivatives.

        Returns
        -------
        BodyState
            Pole at the tip, axes of the base.

        Raises
        ------
        ShapeError, InvalidValueError
            Joint values of a wrong shape, or more than four derivatives.

        References
        ----------
        The paper, sections 2.4.1 and 2.4.2 (Theorems 3 and 4) for order 1 and 2 of a chain.

        """

    def pose(self, q: Any) -> Array:
        """
        Return T_base_tool at the joint positions q.

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions of the measured joints [rad, m].

        Returns
        -------
        array, shape (..., 4, 4)
            T_base_tool [m].

        """
        return self.state(q).pose

    @abstractmethod
    def skeleton(self, q: Any) -> tuple[Array, ...]:
        """
        Return lines of points to draw the links through, in base axes.

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions of the measured joints [rad, m].

        Returns
        -------
        tuple of array, shape (..., points, 3)
            From base to tip [m].

        """

    @abstractmethod
    def compile(    # noqa: A003
            self, outputs: Iterable[str] = ('pose', 'twist', 'accel'),
            axes: str = 'base', pole: str = 'tip') -> Any:
        """
        Return a straight-line program of this manipulator, which is much faster.

        Parameters
        ----------
        outputs : iterable of str
            Any of 'pose' (position, then rotation by rows), 'twist', 'accel', 'jerk',
            'snap' (classical), 'reduced_accel', 'reduced_jerk', 'reduced_snap' and
            'jacobian' (6 x dof by rows).
        axes, pole : {'base', 'tip'}
            Whose axes all but the pose are in, and the point they refer to.

        Returns
        -------
        Program or ParallelProgram
            Call it with q, qd, ..., or let it run over a batch. That of a parallel manipulator
            keeps its last posture, from which the next one is found.

        Raises
        ------
        UnknownNameError, InvalidValueError
            An argument is none of the allowed ones.

        """

    def _check_motion(self, q: Array, derivatives: tuple[Any, ...]) -> None:
        """Refuse too many derivatives, and such as do not belong to as many samples."""
        if len(derivatives) > MAX_ORDER:
            raise InvalidValueError(
                f'derivatives up to order {MAX_ORDER} are supported, got {len(derivatives)}')
        for n, given in enumerate(derivatives, start=1):
            samples = np.shape(given)[:-1]
            try:
                np.broadcast_shapes(np.shape(q)[:-1], samples)
            except ValueError:
                expected = (*np.shape(q)[:-1], self.dof)
                raise ShapeError(f'derivative {n} of q of {self!r}', f'{expected}, as q',
                                 np.shape(given)) from None
