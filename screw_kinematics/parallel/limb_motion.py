# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What limbs that share a platform do at a posture: rates, wrenches, points."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .closed_posture import ClosedPosture
from .limbs import Limbs
from .rates import joint_rates, platform_states
from ..chains.serial_chain import MAX_ORDER
from ..errors import InvalidValueError, ShapeError
from ..screws.se3 import Array


class LimbMotion:
    """The part of a parallel manipulator that needs a posture, however it was found."""

    _limbs: Limbs

    @property
    def dof(self) -> int:
        """Return the number of actuated (measured) joints."""
        return len(self._limbs.actuated)

    def rates(self, posture: ClosedPosture, *derivatives: Any) -> tuple[list[Array], list[Array]]:
        """
        Return the platform's states and the passive joints' rates.

        Parameters
        ----------
        posture : ClosedPosture
            Where the manipulator is.
        *derivatives : array, shape (dof,)
            First to at most fourth time derivatives of the actuated joints.

        Returns
        -------
        states : list of array, shape (6,)
            Reduced states of order 1, 2, ..., pole at the platform frame's origin, axes of
            the base.
        passive : list of array, shape (passive joints,)
            First, second, ... time derivatives.

        """
        self._check_order(derivatives)
        return platform_states(self._limbs, posture, [
            self._vector(f'derivative {n} of q', d) for n, d in enumerate(derivatives, 1)])

    def inverse_rates(self, posture: ClosedPosture, *states: Any,
                      ) -> tuple[list[Array], list[Array]]:
        """
        Return the rates of actuated and passive joints for given platform states.

        In closed form by reciprocal screws; where the actuators are redundant, the ones of
        least squares.

        Parameters
        ----------
        posture : ClosedPosture
            Where the manipulator is.
        *states : array, shape (6,)
            Reduced states of order 1 to at most 4, pole at the platform frame's origin,
            axes of the base.

        Returns
        -------
        actuated : list of array, shape (dof,)
            First, second, ... time derivatives.
        passive : list of array, shape (passive joints,)

        Raises
        ------
        SingularityError
            An actuator can move with the platform at rest.
        InvalidValueError
            The limbs do not allow such a motion; the message names one that does not.

        """
        self._check_order(states)
        return joint_rates(self._limbs, posture, [np.asarray(x, dtype=float) for x in states])

    def wrenches(self, posture: ClosedPosture) -> tuple[list[Array], list[Array]]:
        """
        Return the wrenches that each limb puts on the platform, as screws.

        Returns
        -------
        actuation : list of array, shape (n, 6)
            Per limb, ``(force; moment)`` about the platform frame's origin, base axes:
            what its locked actuators hold.
        constraint : list of array, shape (m, 6)
            Per limb, reciprocal to all its joints: what it holds without any actuator.

        """
        return posture.system.limb_wrenches()

    def points(self, posture: ClosedPosture) -> dict[str, Array]:
        """
        Return the points to draw each limb through, in base axes [m].

        Returns
        -------
        dict from limb name to array, shape (joints + 1, 3)
            A point on each joint's axis, then the platform frame's origin.

        """
        return dict(zip(self._limbs.names, self._limbs.points(posture.joints)))

    def _vector(self, name: str, value: Any) -> Array:
        vector = np.asarray(value, dtype=float)
        if vector.shape != (self.dof,):
            raise ShapeError(f'{name} of {self!r}', f'({self.dof},)', vector.shape)
        if not np.all(np.isfinite(vector)):
            raise InvalidValueError(f'{name} of {self!r} must be finite, got {value!r}')
        return vector

    @staticmethod
    def _check_order(derivatives: Sequence[Any]) -> None:
        if len(derivatives) > MAX_ORDER:
            raise InvalidValueError(
                f'derivatives up to order {MAX_ORDER} are supported, got {len(derivatives)}')
