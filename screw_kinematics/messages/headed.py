# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Decoding of messages that are a stamp, frame names, and a fixed number of floats."""
from __future__ import annotations

from struct import error, unpack_from

from ..errors import MalformedMessageError

_PLAIN = b'\0\1'
_ORIGIN = 4         # alignment counts from the end of the CDR header, see .joint_state
_SLACK = 4          # serialisers may pad the end


def read_headed(kind: str, data: bytes, names: int, count: int,
                ) -> tuple[int, list[str], tuple[float, ...]]:
    """
    Return stamp [ns], frame names, and numbers of a message in plain little-endian CDR.

    Raises
    ------
    MalformedMessageError
        The bytes are no message with so many names, and so many numbers behind them.

    """
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
    if len(data) > at + 8 * count + _SLACK:
        raise MalformedMessageError(kind, f'it has {len(data)} bytes, of which {at + 8 * count} '
                                          'are the message')
    return seconds * 1_000_000_000 + nanoseconds, texts, floats
