# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How uncertain the velocity and acceleration of a tip are, as ellipsoids in the base's axes."""
from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .kinematics import State
from .message_writers import JointColumns, Slices
from .settings import RobotSettings
from ..screws.rigid import pose_from_row
from ..screws.se3 import Array


class Ellipsoid(NamedTuple):
    """
    One standard deviation in all directions.

    Attributes
    ----------
    axes : array, shape (3, 3)
        A rotation: its columns are the principal axes.
    radii : array, shape (3,)
        Along these, in the quantity's unit.

    """

    axes: Array
    radii: Array


class TipEllipsoids:
    """
    Of a tip's angular and linear velocity, and angular and linear acceleration.

    Parameters
    ----------
    slices : mapping from str to slice
        Where pose, twist, reduced acceleration and Jacobian are among the values of a state.
    settings : RobotSettings
        Axes and reference point of the program.
    joints : JointColumns
        Where the tip's joints are among the measured ones.

    """

    def __init__(self, slices: Slices, settings: RobotSettings, joints: JointColumns) -> None:
        self._pose, self._jacobian = slices['pose'], slices['jacobian']
        self._twist, self._accel = slices['twist'], slices['reduced_accel']
        self._in_base = settings.expressed_in == 'base'
        self._at_base = settings.reference_point == 'base'
        self._joints = joints

    def of(self, state: State) -> list[Ellipsoid | None]:
        """Return the four, None where nothing is known of how uncertain it is."""
        values = state.values
        pose = pose_from_row(np.array(values[self._pose]))
        columns = np.column_stack([np.reshape(values[self._jacobian], (6, -1)),
                                   values[self._twist], values[self._accel]])
        turning, moving = columns[:3], columns[3:]
        if not self._in_base:
            turning, moving = pose[:3, :3] @ turning, pose[:3, :3] @ moving
        if self._at_base:       # from the point at the base's origin to the tip
            moving = moving + np.cross(turning, pose[:3, 3], axisa=0, axisc=0)
        jacobian = np.concatenate([turning, moving])[:, :-2].ravel().tolist()
        # The tip's angular and classical linear acceleration, which are its twist's rates.
        rates = [*turning[:, -1], *(moving[:, -1] + np.cross(turning[:, -2], moving[:, -2]))]
        found = []
        for order, known in ((1, rates), (2, [])):
            covariance = np.reshape(self._joints.covariance(state, order, jacobian, known), (6, 6))
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
