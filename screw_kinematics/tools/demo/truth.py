# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Measured states out of the node's messages, each beside the exact one at its stamp."""
from __future__ import annotations

from typing import Any

import numpy as np

from .view import Row
from ..listener import rotation_of, six_vector, xyz
from ...screws.body_state import BodyState
from ...screws.rotations import roll_pitch_yaw
from ...screws.screw import screw_of_twist
from ...screws.se3 import Array


def rows(exact: BodyState, pose: Any, twist: Any, accel: Any) -> tuple[Row, ...]:
    """Return the rows of a view from messages of the node with one stamp."""
    velocity, exact_velocity = six_vector(twist), exact.classical(1)
    acceleration, exact_acceleration = six_vector(accel), exact.classical(2)
    position, exact_position = xyz(pose.position), exact.pose[:3, 3]
    rotation = rotation_of(pose.orientation)
    exact_angles = _degrees(exact.pose[:3, :3])
    screw, exact_screw = screw_of_twist(velocity), screw_of_twist(exact_velocity)
    return (
        Row('position', 'p', 'm', position, exact_position),
        Row('roll, pitch, yaw', 'rpy', 'deg', _nearest(_degrees(rotation), exact_angles),
            exact_angles),
        Row('angular velocity', 'w', 'rad/s', velocity[:3], exact_velocity[:3]),
        Row('linear velocity', 'v', 'm/s', velocity[3:], exact_velocity[3:]),
        Row('angular acceleration', 'alpha', 'rad/s2', acceleration[:3],
            exact_acceleration[:3]),
        Row('linear acceleration', 'a', 'm/s2', acceleration[3:],
            exact_acceleration[3:]),
        Row('screw axis direction', 's', '', screw.axis, exact_screw.axis),
        Row('screw axis point', 'c', 'm', position + screw.point,
            exact_position + exact_screw.point),
        Row('pitch', 'h', 'm/rad', screw.pitch[None], exact_screw.pitch[None]),
    )


def _degrees(rotation: Array) -> Array:
    return np.degrees(roll_pitch_yaw(rotation))


def _nearest(angles: Array, others: Array) -> Array:
    """Return the angles with whole turns added, to be nearest others [deg]."""
    return others + np.mod(angles - others + 180.0, 360.0) - 180.0
