# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Inverse velocity and acceleration, and manipulability, of anything with a Jacobian."""
from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np

from .inverse import InverseSolution, InverseSolver, Manipulability, manipulability
from ..errors import UnknownNameError
from ..screws.body_state import BodyState
from ..screws.se3 import Array


class Mobility(ABC):
    """
    What joint motion a wanted tip motion needs, and how well a posture can move.

    A subclass brings the forward problem, its Jacobian and its states; everything here
    follows from them.
    """

    @property
    @abstractmethod
    def prismatic(self) -> Array:
        """Return which measured joints are in m rather than rad, shape (dof,)."""

    @abstractmethod
    def jacobian(self, q: Any, pole: str | Array = 'tip', axes: str = 'base') -> Array:
        """Return the columns of unit rates of the measured joints, shape (..., 6, dof)."""

    @abstractmethod
    def state(self, q: Any, *derivatives: Any) -> BodyState:
        """Return pose and reduced states of the tip."""

    def inverse_velocity(self, q: Any, twist: Any, pole: str | Array = 'tip',
                         axes: str = 'base', secondary: Any = None,
                         solver: InverseSolver = InverseSolver()) -> InverseSolution:
        """
        Return the rates of the measured joints that give the tip a twist.

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions of the measured joints [rad, m].
        twist : array, shape (..., 6)
            Wanted twist of the tip [rad/s, m/s] about ``pole`` in ``axes``.
        pole, axes
            As for :meth:`jacobian`.
        secondary : array, shape (..., dof), optional
            Rates wished for as far as the twist allows (null-space motion).
        solver : InverseSolver
            Exact or damped, and the characteristic length.

        Returns
        -------
        InverseSolution

        Raises
        ------
        SingularityError
            The solver is exact and the twist impossible; the reciprocal screw is named.

        References
        ----------
        The paper, equation 78.

        """
        jacobian = self.jacobian(q, pole, axes)
        return solver.solve(jacobian, twist, self.prismatic, secondary)

    def inverse_acceleration(self, q: Any, qd: Any, acceleration: Any,
                             kind: str = 'classical', pole: str | Array = 'tip',
                             axes: str = 'base', secondary: Any = None,
                             solver: InverseSolver = InverseSolver()) -> InverseSolution:
        """
        Return the joint accelerations that give the tip an acceleration.

        Parameters
        ----------
        q, qd : array, shape (..., dof)
            Positions and rates of the measured joints.
        acceleration : array, shape (..., 6)
            Wanted acceleration of the tip [rad/s^2, m/s^2] about ``pole`` in ``axes``.
        kind : {'classical', 'reduced'}
            ``[alpha; a]`` of the point at the pole, or ``(alpha ; a - w x v)``.
        pole, axes, secondary, solver
            As for :meth:`inverse_velocity`; ``secondary`` are accelerations.

        Returns
        -------
        InverseSolution

        Raises
        ------
        UnknownNameError
            There is no such kind.
        SingularityError
            The solver is exact and the acceleration impossible.

        References
        ----------
        The paper, equation 80: what the joint rates contribute (the Coriolis-Lie term) is
        taken off first.

        """
        if kind not in ('classical', 'reduced'):
            raise UnknownNameError('kind', kind, ('classical', 'reduced'))
        coasting = self.state(q, qd, 0 * np.asarray(qd)).about(pole).expressed_in(axes)
        known = coasting.classical(2) if kind == 'classical' else coasting.reduced_acceleration
        wanted = np.asarray(acceleration) - known
        return solver.solve(self.jacobian(q, pole, axes), wanted, self.prismatic,
                            secondary)

    def manipulability(self, q: Any, length: float = 1.0) -> Manipulability:
        """
        Return how well the tip can move at a posture, pole at the tip, axes of the base.

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions of the measured joints [rad, m].
        length : float
            Characteristic length [m/rad].

        Returns
        -------
        Manipulability

        """
        return manipulability(self.jacobian(q), self.prismatic, length)
