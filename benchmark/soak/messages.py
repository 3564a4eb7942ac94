# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages of drivers as bytes: how they begin, those with something wrong in them; commands."""
from collections import deque
from collections.abc import Sequence
import json
import math
from random import Random
import struct
import sys
import threading
from typing import Any

from ..node.robot import message_body

MALFORMED = ('nan', 'infinite', 'short', 'long', 'truncated', 'noise', 'empty', 'unknown',
             'twice', 'unstamped', 'negative', 'partial')
"""What may be wrong with a message."""

_stamp = struct.Struct('<iI').pack
_HEAD = b'\0\1\0\0'


def beginning(stamp_ns: int) -> bytes:
    """Return what is in front of the body of a message."""
    return _HEAD + _stamp(*divmod(stamp_ns, 1_000_000_000))


def spoilt(kind: str, stamp_ns: int, names: Sequence[str], body: bytes, random: Random) -> bytes:
    """Return a message with one of the faults of `MALFORMED`, made from a right one's parts."""
    names, position = list(names), [0.5] * len(names)
    if kind == 'negative':
        return beginning(-5_000_000_000) + body
    if kind == 'unstamped':
        return beginning(0) + body
    if kind == 'noise':
        return _HEAD + random.randbytes(random.randrange(4, 600))
    if kind == 'empty':
        return _HEAD + bytes(24)
    if kind in ('nan', 'infinite'):
        position[random.randrange(len(names))] = math.nan if kind == 'nan' else -math.inf
    elif kind == 'short':
        position.pop()
    elif kind == 'long':
        position.append(0.5)
    elif kind == 'unknown':
        names = [f'unknown{random.randrange(10**6)}' for _ in names]
    elif kind == 'twice':
        names[0] = names[-1]
    elif kind == 'partial':
        names, position = names[:-1], position[:-1]
    data = beginning(stamp_ns) + message_body(names, position, [])
    # Less would be a whole message: the middleware fills up to four bytes.
    return data[:random.randrange(4, len(data) - 12)] if kind == 'truncated' else data


def commands() -> deque[list[Any]]:
    """
    Return the commands that come on standard input, as they come.

    Each is a line of JSON: a list of the name of a method, and its arguments. The last is 'stop'.
    """
    found: deque[list[Any]] = deque()

    def read() -> None:
        found.extend(map(json.loads, sys.stdin))
        found.append(['stop'])

    threading.Thread(target=read, daemon=True).start()
    return found
