# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Decoding of what tells how a base moves: `nav_msgs/Odometry`, `geometry_msgs/TwistStamped`."""
from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from .headed import read_headed

_COVARIANCE = 36

SixVector = tuple[float, float, float, float, float, float]


class BaseSample(NamedTuple):
    """
    What a message says of the motion of a base; not checked for NaN.

    The twist, angular, then linear [rad/s, m/s], is of the moving frame, about its origin, in its
    axes; its position [m] and quaternion (x, y, z, w) are in the world, if that is not None.
    """

    stamp_ns: int
    frame: str
    twist: SixVector
    world: str | None = None
    position: tuple[float, ...] = (0.0, 0.0, 0.0)
    quaternion: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0)


def read_odometry(data: bytes) -> BaseSample:
    """Return the sample in a serialized `nav_msgs/Odometry`, whose twist is in the child frame."""
    stamp_ns, (world, child), floats = read_headed('Odometry', data, 2, 13 + 2 * _COVARIANCE)
    first = 7 + _COVARIANCE
    return BaseSample(stamp_ns, child, _six_vector(floats[first:first + 6]), world,
                      floats[:3], floats[3:7])


def read_twist(data: bytes) -> BaseSample:
    """Return the sample in a serialized `geometry_msgs/TwistStamped`, in the axes of its frame."""
    stamp_ns, (frame,), floats = read_headed('TwistStamped', data, 1, 6)
    return BaseSample(stamp_ns, frame, _six_vector(floats))


READERS: dict[str, Callable[[bytes], BaseSample]] = {
    'nav_msgs/msg/Odometry': read_odometry, 'geometry_msgs/msg/TwistStamped': read_twist}
"""By the type of the message."""


def _six_vector(linear_first: tuple[float, ...]) -> SixVector:
    x, y, z, roll, pitch, yaw = linear_first
    return roll, pitch, yaw, x, y, z
