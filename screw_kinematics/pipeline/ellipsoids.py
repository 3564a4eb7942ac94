# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How uncertain the velocity and acceleration of a tip are, as ellipsoids in the base's axes."""
from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .kinematics import State
from .message_writers import JointColumns, Slices
from .settings import RobotSettings
from ..screws.body_state import BodyState
from ..screws.se3 import Array


class Ellipsoid(NamedTuple):
    """One standard deviation in all directions."""

    axes: Array     # (3, 3), a rotation: its columns are the principal axes
    radii: Array    # (3,), along these, in the quantity's unit


class TipEllipsoids:
    """Of a tip's angular and linear velocity, and angular and linear acceleration."""

    def __init__(self, slices: Slices, settings: RobotSettings, joints: JointColumns) -> None:
        self._jacobian = slices['jacobian']
        self._axes, self._pole = settings.expressed_in, settings.reference_point
        self._joints = joints

    def of(self, state: State, tip: BodyState) -> list[Ellipsoid | None]:
        """
        Return the four, None where nothing is known of how uncertain it is.

        The tip's motion is about the tip, in base axes.
        """
        # Columns are twists per unit rate: they go to other poles and axes as states do.
        columns = np.reshape(state.values[self._jacobian], (6, -1)).T
        pole = tip.pole_in_base if self._pole == 'tip' else np.zeros(3)
        seen = BodyState(tip.pose, (columns,), pole, self._pole, self._axes)
        jacobian = seen.about('tip').expressed_in('base').velocity.T.ravel().tolist()
        found = []
        # The tip's classical acceleration is its twist's rate.
        for order, rates in ((1, tip.classical(2).tolist()), (2, [])):
            covariance = np.reshape(self._joints.covariance(state, order, jacobian, rates), (6, 6))
            found += [ellipsoid(covariance[:3, :3]), ellipsoid(covariance[3:, 3:])]
        return found


def ellipsoid(covariance: Array) -> Ellipsoid | None:
    """
    Return the ellipsoid of a covariance, shape (3, 3); None for zero, which means not known.

    Examples
    --------
    >>> ellipsoid(np.diag([4.0, 1.0, 9.0])).radii
    array([1., 2., 3.])

    """
    if not covariance.any():
        return None
    squares, axes = np.linalg.eigh(covariance)
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] *= -1.0
    return Ellipsoid(axes, np.sqrt(np.maximum(squares, 0.0)))
