# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Other streams that saw a robot move, and how they depend on its motion."""
from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from .clock_offset import Channels
from .link_motion import LinkMotion
from .recording import Recording
from .storage import jazzy_types
from ..errors import ToolError
from ..screws.se3 import Array
from ..screws.vectors import skew

GRAVITY = 9.80665    # m/s^2


class Stream(NamedTuple):
    """Measured quantities: stamps [ns], and values, shape (N, k)."""

    kind: str
    stamps: Array
    values: Array


def _xyz(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]


def _imu(message: Any) -> list[float]:
    return [*_xyz(message.angular_velocity), *_xyz(message.linear_acceleration)]


def _odometry(message: Any) -> list[float]:
    return [*_xyz(message.twist.twist.angular), *_xyz(message.twist.twist.linear)]


READERS: dict[str, Callable[[Any], list[float]]] = {
    'sensor_msgs/msg/Imu': _imu,
    'geometry_msgs/msg/WrenchStamped': lambda message: _xyz(message.wrench.force),
    'geometry_msgs/msg/PoseStamped': lambda message: _xyz(message.pose.position),
    'nav_msgs/msg/Odometry': _odometry,
}
"""What is taken of each type of message."""


def read_stream(recording: Recording, topic: str) -> Stream:
    """
    Return what was recorded on a topic, but for messages that are broken or not of finite numbers.

    Those with stamp zero are taken to be of the moment they arrived.
    """
    kinds = {c.kind for c in recording.connections if c.topic == topic}
    known = kinds & READERS.keys()
    if not known:
        raise ToolError(f'{recording.path}: {topic} has messages of type '
                        f'{", ".join(sorted(kinds)) or "none"}; allowed: '
                        f'{", ".join(READERS)}')
    kind = known.pop()
    deserialize = jazzy_types('reading messages').deserialize_cdr
    stamps, values, refused = [], [], 0
    for message in recording.messages({kind}, {topic}):
        try:
            content = deserialize(message.data, kind)
        except Exception:       # of broken bytes the library raises whatever they lead to
            refused += 1
            continue
        row, stamp = READERS[kind](content), content.header.stamp
        if not np.isfinite(row).all():
            refused += 1
            continue
        stamps.append(stamp.sec * 10**9 + stamp.nanosec or message.received)
        values.append(row)
    if refused and not values:
        raise ToolError(f'{recording.path}: {topic}: none of its {refused} messages can be read, '
                        'or is of finite numbers')
    in_order, first = np.unique(np.array(stamps, dtype=np.int64), return_index=True)
    return Stream(kind, in_order, np.array(values)[first])


def channels(stream: Stream, link: LinkMotion) -> list[Channels]:
    """
    Return what a stream that is fixed to a link measures of it.

    Mounting, lever arm, scale and bias may be any; the z axis of the base points up.
    """
    turn = link.in_link(link.angular_velocity)
    flat = link.rotation.reshape(len(link.stamps), 9)
    if stream.kind == 'geometry_msgs/msg/PoseStamped':
        return [Channels(stream.values, np.concatenate([link.position, flat], axis=1))]
    if stream.kind == 'nav_msgs/msg/Odometry':
        return [Channels(stream.values[:, :3], turn),
                Channels(stream.values[:, 3:], np.concatenate(
                    [link.in_link(link.velocity), turn], axis=1))]
    force = specific_force_features(link)
    if stream.kind == 'sensor_msgs/msg/Imu':
        return [Channels(stream.values[:, :3], turn), Channels(stream.values[:, 3:], force)]
    return [Channels(stream.values, force)]


def specific_force_features(link: LinkMotion) -> Array:
    """
    Return what the specific force at any point of a link is linear in, shape (N, 12).

    That at its origin, in its own axes, where the base's z axis points up; and what a lever arm
    adds, by the arm's components.
    """
    omega = skew(link.in_link(link.angular_velocity))
    lever = skew(link.in_link(link.angular_acceleration)) + omega @ omega
    return np.concatenate([link.in_link(link.acceleration + [0.0, 0.0, GRAVITY]),
                           lever.reshape(-1, 9)], axis=1)
