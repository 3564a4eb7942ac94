# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Decoding of `geometry_msgs/WrenchStamped` from the bytes that travel on the wire."""
from __future__ import annotations

from collections.abc import Callable
from struct import Struct
from typing import NamedTuple

from ..errors import MalformedMessageError

TYPE = 'geometry_msgs/msg/WrenchStamped'

_LONGEST_FRAME = 4096
_ORIGIN = 4         # alignment counts from here, see .joint_state
_SLACK = 4          # serialisers may pad the end
_HEAD = Struct('<4xiII')
_SIX = Struct('<6d')


class WrenchSample(NamedTuple):
    """
    The content of a message.

    Attributes
    ----------
    stamp_ns : int
        Time of the measurement [ns].
    frame_id : str
        In whose axes and about whose origin it is.
    values : tuple of float
        Force [N] and torque [N m], not checked for NaN.

    """

    stamp_ns: int
    frame_id: str
    values: tuple[float, ...]


def read_wrench(data: bytes, foreign: Callable[[bytes], WrenchSample] | None = None,
                ) -> WrenchSample:
    """
    Return what a serialized message says.

    Parameters
    ----------
    data : bytes
        Plain little-endian CDR, or anything else that ``foreign`` reads.
    foreign : callable, optional
        Reads other encapsulations; raises MalformedMessageError.

    Raises
    ------
    MalformedMessageError
        The bytes are no such message.

    """
    if data[:2] != b'\0\1' and foreign is not None:
        return foreign(data)
    if data[:2] != b'\0\1' or len(data) < _HEAD.size:
        raise _malformed(f'it has {len(data)} bytes that begin with {data[:2].hex()}')
    seconds, nanoseconds, length = _HEAD.unpack_from(data)
    end = _HEAD.size + length
    at = end + (_ORIGIN - end) % 8
    if length > _LONGEST_FRAME or not at + _SIX.size <= len(data) <= at + _SIX.size + _SLACK:
        raise _malformed(f'it has {len(data)} bytes, and a frame name of {length}')
    if nanoseconds >= 1_000_000_000:
        raise _malformed('its stamp has 1e9 nanoseconds or more')
    try:
        frame = data[_HEAD.size:end].rstrip(b'\0').decode()
    except UnicodeDecodeError:
        raise _malformed('its frame name is not UTF-8') from None
    return WrenchSample(seconds * 1_000_000_000 + nanoseconds, frame, _SIX.unpack_from(data, at))


def _malformed(problem: str) -> MalformedMessageError:
    return MalformedMessageError('WrenchStamped', problem)
