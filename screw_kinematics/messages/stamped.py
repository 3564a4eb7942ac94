# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Encoding of the stamped geometry messages into the bytes that travel on the wire.

All of them are a stamp, one or more frame names, and a fixed number of floats. Everything
but stamp and floats is laid out once, in little-endian CDR (see :mod:`.cdr`), so a message
costs one packing. Six-vectors are angular first here and linear first in messages; the
swap is made here and nowhere else.
"""
from __future__ import annotations

from collections.abc import Sequence
from operator import itemgetter
import struct

from ..errors import InvalidValueError

_HEADER = b'\0\1\0\0'      # plain little-endian CDR
_SECOND = 1_000_000_000    # ns


class _Encoder:
    """
    The layout of one message type with fixed frame names.

    Parameters
    ----------
    frames : sequence of str
        The strings between stamp and floats.
    floats : int
        Number of floats.

    """

    __slots__ = ('_pack', '_frames')

    def __init__(self, frames: Sequence[str], floats: int) -> None:
        # Alignment counts from the end of the header; the stamp takes the first 8 bytes.
        body = b''
        for frame in frames:
            if '\0' in frame:
                raise InvalidValueError(f'frame name {frame!r} contains a NUL character')
            text = frame.encode() + b'\0'
            body += bytes(-len(body) % 4) + len(text).to_bytes(4, 'little') + text
        self._frames = body + bytes(-len(body) % 8)
        self._pack = struct.Struct(f'<4siI{len(self._frames)}s{floats}d').pack

    def _out_of_range(self, stamp_ns: int) -> InvalidValueError:
        return InvalidValueError(
            f'stamp {stamp_ns} ns does not fit a message, which holds seconds as int32')


class TwistEncoder(_Encoder):
    """
    Writes `TwistStamped` and `AccelStamped`, which are alike on the wire.

    Parameters
    ----------
    frame_id : str
        Frame whose axes the vectors are expressed in.

    """

    __slots__ = ()

    def __init__(self, frame_id: str) -> None:
        super().__init__([frame_id], 6)

    def encode(self, stamp_ns: int, values: Sequence[float]) -> bytes:
        """
        Return the serialized message.

        Parameters
        ----------
        stamp_ns : int
            Time in ns.
        values : sequence of 6 floats
            Six-vector, angular first, in rad and m.

        Raises
        ------
        InvalidValueError
            The stamp does not fit a message.

        """
        # Spelled out, since this runs for every sample and is twice as fast as a permutation.
        wx, wy, wz, vx, vy, vz = values
        try:
            return self._pack(_HEADER, stamp_ns // _SECOND, stamp_ns % _SECOND, self._frames,
                              vx, vy, vz, wx, wy, wz)
        except struct.error:
            raise self._out_of_range(stamp_ns) from None


AccelEncoder = TwistEncoder


class VelocityEncoder(TwistEncoder):
    """
    Writes `VelocityStamped`: a twist that names both bodies.

    Parameters
    ----------
    frame_id : str
        Frame whose axes the vectors are expressed in.
    body_frame_id, reference_frame_id : str
        The body that moves, and the one it is seen from.

    """

    __slots__ = ()

    def __init__(self, frame_id: str, body_frame_id: str, reference_frame_id: str) -> None:
        _Encoder.__init__(self, [frame_id, body_frame_id, reference_frame_id], 6)


class _PermutingEncoder(_Encoder):
    """A message whose floats are a permutation of the values."""

    __slots__ = ('_order',)

    def __init__(self, frame_id: str, order: Sequence[int]) -> None:
        super().__init__([frame_id], len(order))
        self._order = itemgetter(*order)

    def encode(self, stamp_ns: int, values: Sequence[float]) -> bytes:
        """Return the serialized message; see the class for the order of the values."""
        try:
            return self._pack(_HEADER, stamp_ns // _SECOND, stamp_ns % _SECOND, self._frames,
                              *self._order(values))
        except struct.error:
            raise self._out_of_range(stamp_ns) from None


class PoseEncoder(_PermutingEncoder):
    """
    Writes `PoseStamped` from position (x, y, z) in m and unit quaternion (x, y, z, w).

    Parameters
    ----------
    frame_id : str
        Frame in which the pose is given.

    """

    __slots__ = ()

    def __init__(self, frame_id: str) -> None:
        super().__init__(frame_id, range(7))


class TwistWithCovarianceEncoder(_PermutingEncoder):
    """
    Writes `TwistWithCovarianceStamped` and `AccelWithCovarianceStamped`.

    Takes 42 values: a six-vector and its covariance (6, 6) row by row, angular first both.

    Parameters
    ----------
    frame_id : str
        Frame whose axes the vectors are expressed in.

    """

    __slots__ = ()

    def __init__(self, frame_id: str) -> None:
        swapped = (3, 4, 5, 0, 1, 2)
        super().__init__(
            frame_id, [*swapped, *(6 + 6 * row + column for row in swapped for column in swapped)])


AccelWithCovarianceEncoder = TwistWithCovarianceEncoder
