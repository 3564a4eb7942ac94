# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Decoding of `sensor_msgs/JointState` from the bytes that travel on the wire.

ROS messages travel as CDR (OMG Common Data Representation, version 1): a header of four
bytes, then the fields in order, each aligned to its own size counted from the end of that
header. What one driver sends differs from message to message only in the stamp and the
numbers, so the layout found in its first message serves all later ones, which the core reads: one
comparison, and the numbers from their places. The bytes between fields have no defined value and
are left out of the comparison. Every count and the length are checked again in every message.
"""
from __future__ import annotations

from collections.abc import Callable
from struct import unpack_from
from typing import NamedTuple

from ..core.cdr import JointStateLayout
from ..errors import MalformedMessageError

MAX_BYTES = 1 << 18
"""Longest message that is read; some 2,000 joints with names of 100 letters."""

MAX_LAYOUTS = 32
"""Layouts remembered at a time, for topics on which several drivers publish."""

_ORIGIN = 4                # alignment counts from here: the end of the CDR header
_NAMES = _ORIGIN + 8       # end of the stamp, start of frame_id
_LITTLE_ENDIAN = 0x0100    # the first two bytes of a plain little-endian message
_SLACK = 12                # serialisers may reserve the alignment of three empty arrays

_new_tuple = tuple.__new__


class JointSample(NamedTuple):
    """
    The content of a joint state message that matters here.

    Names are the same object as long as they stay the same, so that what was worked out for them
    can be kept under its identity. Positions [rad, m] and velocities are as long as they were in
    the message, shorter or longer than the names, and not checked for NaN.
    """

    stamp_ns: int
    names: tuple[str, ...]
    position: tuple[float, ...]
    velocity: tuple[float, ...]


class JointStateDecoder:
    """
    Reads serialized joint state messages.

    What is not plain little-endian CDR is read by ``foreign``, which raises MalformedMessageError.
    """

    def __init__(self, foreign: Callable[[bytes], JointSample] | None = None) -> None:
        self._foreign = foreign
        self._layouts: list[_Layout] = []
        self._foreign_names: tuple[str, ...] = ()

    def decode(self, data: bytes) -> JointSample:
        """
        Return the sample in a serialized message.

        Raises
        ------
        MalformedMessageError
            The bytes are not a joint state message, or a longer one than ``MAX_BYTES``.

        """
        for layout in self._layouts:
            sample = layout.read(data)
            if sample is not None:
                if layout is not self._layouts[0]:
                    self._put_first(layout)
                return sample
        if len(data) > MAX_BYTES:
            raise MalformedMessageError(
                'JointState', f'it has {len(data)} bytes, more than {MAX_BYTES}')
        if data[:2] != _LITTLE_ENDIAN.to_bytes(2, 'little'):
            return self._decode_foreign(data)
        layout = _Layout(data, [known.names for known in self._layouts])
        self._put_first(layout)
        sample = layout.read(data)
        if sample is None:
            raise MalformedMessageError('JointState', 'its stamp has 1e9 nanoseconds or more')
        return sample

    def _decode_foreign(self, data: bytes) -> JointSample:
        """Return the sample in another encapsulation, such as big-endian CDR."""
        if self._foreign is None:
            raise MalformedMessageError(
                'JointState', f'its encapsulation is {data[:2].hex()}; without ROS only plain '
                'little-endian CDR is read (0001)')
        sample = self._foreign(data)
        if sample.names == self._foreign_names:
            sample = sample._replace(names=self._foreign_names)
        self._foreign_names = sample.names
        return sample

    def _put_first(self, layout: _Layout) -> None:
        """Move a layout to the front, and forget the one that was not used for longest."""
        others = [known for known in self._layouts if known is not layout]
        self._layouts = [layout, *others[:MAX_LAYOUTS - 1]]


class _Layout:
    """
    Where things are in one message, and in all that differ only in stamp and numbers.

    Names that equal some met before are represented by the same object.
    """

    __slots__ = ('names', '_numbers')

    def __init__(self, data: bytes, known_names: list[tuple[str, ...]]) -> None:
        mask = bytearray(len(data))
        at = _skip_string(data, _NAMES, mask)
        count, at = _read_count(data, at, 4, mask)
        parts = []
        for _ in range(count):
            start = at
            at = _skip_string(data, start, mask)
            parts.append(_text(data, start, at))
        names = tuple(parts)
        self.names = next((known for known in known_names if known == names), names)
        positions, position_at = _read_count(data, at, 8, mask)
        velocity_count_at = position_at + 8 * positions
        velocities, velocity_at = _read_count(data, velocity_count_at, 8, mask)
        effort_count_at = velocity_at + 8 * velocities
        efforts, efforts_at = _read_count(data, effort_count_at, 8, mask)
        if len(data) - efforts_at - 8 * efforts > _SLACK:
            raise MalformedMessageError(
                'JointState', f'it ends after {efforts_at + 8 * efforts} bytes '
                f'and has {len(data)}')
        self._numbers = JointStateLayout(
            data, bytes(mask), -(-at // 4) * 4 + 4, position_at, positions, velocity_count_at,
            velocity_at, velocities, effort_count_at)

    def read(self, data: bytes) -> JointSample | None:
        """Return the sample in a message, or None if it is not of this layout."""
        found = self._numbers.read(data)
        if found is None:
            return None
        stamp_ns, position, velocity = found
        return _new_tuple(JointSample, (stamp_ns, self.names, position, velocity))


def _read_count(data: bytes, at: int, item: int, mask: bytearray) -> tuple[int, int]:
    """Return the count of a sequence of items of that size, and where its items start."""
    at = -(-at // 4) * 4
    if at + 4 > len(data):
        raise MalformedMessageError('JointState', f'it is cut off after {len(data)} bytes')
    count, = unpack_from('<I', data, at)
    mask[at:at + 4] = b'\xff' * 4
    at += 4
    if count == 0:
        return 0, at
    if item == 8:
        at += (_ORIGIN - at) % 8
    # A string takes at least its own count; so this bounds the work before any is done.
    if count * item > len(data) - at:
        raise MalformedMessageError(
            'JointState', f'it announces {count} items where {len(data) - at} bytes remain')
    return count, at


def _skip_string(data: bytes, at: int, mask: bytearray) -> int:
    """Return the end of the string whose count is next."""
    count, at = _read_count(data, at, 1, mask)
    mask[at:at + count] = b'\xff' * count
    return at + count


def _text(data: bytes, start: int, end: int) -> str:
    """Return the string between its (aligned) count and its end, without the final NUL."""
    raw = data[-(-start // 4) * 4 + 4:end]
    if raw and raw[-1] != 0 or 0 in raw[:-1]:
        raise MalformedMessageError('JointState', f'joint name {raw!r} does not end in NUL')
    try:
        return raw[:-1].decode()
    except UnicodeDecodeError:
        raise MalformedMessageError('JointState', f'joint name {raw!r} is not UTF-8') from None
