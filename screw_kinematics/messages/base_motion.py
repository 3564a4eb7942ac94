# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Decoding of what tells how a base moves: `nav_msgs/Odometry`, `geometry_msgs/TwistStamped`.

A stamp, one or two frame names, and a fixed number of floats, in plain little-endian CDR (see
:mod:`.joint_state`).
"""
from __future__ import annotations

from collections.abc import Callable
from struct import error, unpack_from
from typing import NamedTuple

from ..errors import MalformedMessageError

_PLAIN = b'\0\1'
_ORIGIN = 4         # alignment counts from the end of the CDR header
_COVARIANCE = 36

SixVector = tuple[float, float, float, float, float, float]


class BaseSample(NamedTuple):
    """
    What a message says of the motion of a base; not checked for NaN.

    Attributes
    ----------
    stamp_ns : int
        Time of the measurement [ns].
    frame : str
        The moving frame: the twist is of it, about its origin, in its axes.
    twist : tuple of 6 float
        Angular, then linear [rad/s, m/s].
    world : str or None
        Frame that the pose is given in; None: there is no pose.
    position : tuple of 3 float
        Of the moving frame in it [m].
    quaternion : tuple of 4 float
        x, y, z, w.

    """

    stamp_ns: int
    frame: str
    twist: SixVector
    world: str | None = None
    position: tuple[float, ...] = (0.0, 0.0, 0.0)
    quaternion: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0)


def read_odometry(data: bytes) -> BaseSample:
    """
    Return the sample in a serialized `nav_msgs/Odometry`, whose twist is in the child frame.

    Raises
    ------
    MalformedMessageError
        The bytes are no such message.

    """
    stamp_ns, (world, child), floats = _read('Odometry', data, 2, 13 + 2 * _COVARIANCE)
    first = 7 + _COVARIANCE
    return BaseSample(stamp_ns, child, _six_vector(floats[first:first + 6]), world,
                      floats[:3], floats[3:7])


def read_twist(data: bytes) -> BaseSample:
    """
    Return the sample in a serialized `geometry_msgs/TwistStamped`, in the axes of its frame.

    Raises
    ------
    MalformedMessageError
        The bytes are no such message.

    """
    stamp_ns, (frame,), floats = _read('TwistStamped', data, 1, 6)
    return BaseSample(stamp_ns, frame, _six_vector(floats))


READERS: dict[str, Callable[[bytes], BaseSample]] = {
    'nav_msgs/msg/Odometry': read_odometry, 'geometry_msgs/msg/TwistStamped': read_twist}
"""By the type of the message."""


def _read(kind: str, data: bytes, names: int, count: int,
          ) -> tuple[int, list[str], tuple[float, ...]]:
    """Return stamp [ns], frame names, and numbers."""
    if data[:2] != _PLAIN:
        raise MalformedMessageError(kind, f'its encapsulation is {data[:2].hex()}; without ROS '
                                          'only plain little-endian CDR is read (0001)')
    try:
        seconds, nanoseconds = unpack_from('<iI', data, _ORIGIN)
        texts, at = [], _ORIGIN + 8
        for _ in range(names):
            at += -at % 4
            length, = unpack_from('<I', data, at)
            raw = data[at + 4:at + 4 + length]
            if len(raw) < length:
                raise MalformedMessageError(kind, f'it is cut off after {len(data)} bytes')
            texts.append(raw.removesuffix(b'\0').decode())
            at += 4 + length
        at += (_ORIGIN - at) % 8
        floats = unpack_from(f'<{count}d', data, at)
    except error:
        raise MalformedMessageError(kind, f'it is cut off after {len(data)} bytes') from None
    except UnicodeDecodeError:
        raise MalformedMessageError(kind, 'a frame name is not UTF-8') from None
    if nanoseconds >= 1_000_000_000:
        raise MalformedMessageError(kind, 'its stamp has 1e9 nanoseconds or more')
    return seconds * 1_000_000_000 + nanoseconds, texts, floats


def _six_vector(linear_first: tuple[float, ...]) -> SixVector:
    x, y, z, roll, pitch, yaw = linear_first
    return roll, pitch, yaw, x, y, z
