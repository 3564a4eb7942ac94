# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Encoding of the stamped geometry messages into the bytes that travel on the wire.

All of them are a stamp, one or more frame names, and a fixed number of floats. Everything
but stamp and floats is laid out once, in little-endian CDR (see :mod:`.joint_state`); the core
fills in the rest. Six-vectors are angular first here and linear first in messages; the
swap is made here and nowhere else.
"""
from __future__ import annotations

from collections.abc import Sequence

from ..core.cdr import StampedMessage
from ..errors import InvalidValueError

_ANGULAR_LAST = (3, 4, 5, 0, 1, 2)
_CDR = b'\0\1\0\0'      # plain, little-endian; alignment counts from its end

UNSTAMPED = bytes(8)
"""The body of a message up to its frame: room for the stamp."""


class StampedEncoder:
    """
    The layout of messages that differ in stamp and numbers only.

    The body is one of them, from its stamp on; for each number there is its place in it, and which
    of the values it is.
    """

    __slots__ = ('_message',)

    def __init__(self, body: bytes, places: Sequence[int], order: Sequence[int]) -> None:
        self._message = StampedMessage(
            _CDR + body, [len(_CDR) + place for place in places], list(order))

    def encode(self, stamp_ns: int, values: Sequence[float]) -> bytes:
        """
        Return the serialized message, of values in the order that the class says.

        Raises
        ------
        InvalidValueError
            The stamp does not fit a message.

        """
        try:
            message = self._message.write(stamp_ns, values)
        except OverflowError:
            message = None
        if message is None:
            raise InvalidValueError(f'stamp {stamp_ns} ns does not fit a message, which holds '
                                    'seconds as int32')
        return message


class _FramesEncoder(StampedEncoder):
    """The layout of a message type with fixed frame names, between the stamp and the floats."""

    __slots__ = ()

    def __init__(self, frames: Sequence[str], order: Sequence[int]) -> None:
        body = UNSTAMPED
        for frame in frames:
            body = with_text(body, frame)
        body, places = with_floats(body, len(order))
        super().__init__(body, places, order)


class TwistEncoder(_FramesEncoder):
    """Writes `TwistStamped` and `AccelStamped`, alike on the wire: six values from a first on."""

    __slots__ = ()

    def __init__(self, frame_id: str, first: int = 0) -> None:
        super().__init__([frame_id], [first + i for i in _ANGULAR_LAST])


class VelocityEncoder(_FramesEncoder):
    """Writes `VelocityStamped`: a twist, in axes of a frame, that names both bodies."""

    __slots__ = ()

    def __init__(self, frame_id: str, body_frame_id: str, reference_frame_id: str,
                 first: int = 0) -> None:
        super().__init__([frame_id, body_frame_id, reference_frame_id],
                         [first + i for i in _ANGULAR_LAST])


class PoseEncoder(_FramesEncoder):
    """Writes `PoseStamped` from position (x, y, z) in m and unit quaternion (x, y, z, w)."""

    __slots__ = ()

    def __init__(self, frame_id: str) -> None:
        super().__init__([frame_id], range(7))


class WrenchEncoder(_FramesEncoder):
    """Writes `WrenchStamped` from force [N] and torque [N m]."""

    __slots__ = ()

    def __init__(self, frame_id: str) -> None:
        super().__init__([frame_id], range(6))


class TwistWithCovarianceEncoder(_FramesEncoder):
    """
    Writes `TwistWithCovarianceStamped` and `AccelWithCovarianceStamped`.

    Takes 42 values: a six-vector and its covariance (6, 6) row by row, angular first both.
    """

    __slots__ = ()

    def __init__(self, frame_id: str) -> None:
        super().__init__([frame_id], [*_ANGULAR_LAST, *(
            6 + 6 * row + column for row in _ANGULAR_LAST for column in _ANGULAR_LAST)])


class ImuEncoder(_FramesEncoder):
    """
    Writes `Imu`, from 37 values in the order of the message.

    Orientation (x, y, z, w) and its covariance (3, 3) row by row, angular velocity and its
    covariance, specific force and its covariance.
    """

    __slots__ = ()

    def __init__(self, frame_id: str) -> None:
        super().__init__([frame_id], range(37))


def with_count(body: bytes, count: int) -> bytes:
    """Return the bytes of a message with a number of elements behind them."""
    return body + bytes(-len(body) % 4) + count.to_bytes(4, 'little')


def with_floats(body: bytes, count: int) -> tuple[bytes, range]:
    """Return the bytes of a message with room for floats behind them, and where these are."""
    body += bytes(-len(body) % 8)
    return body + bytes(8 * count), range(len(body), len(body) + 8 * count, 8)


def with_text(body: bytes, text: str) -> bytes:
    """Return the bytes of a message with a name behind them."""
    if '\0' in text:
        raise InvalidValueError(f'name {text!r} contains a NUL character')
    raw = text.encode() + b'\0'
    return with_count(body, len(raw)) + raw
