# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Reading the node's own messages out of a recording."""
from __future__ import annotations

from struct import Struct

import numpy as np

from ..errors import MalformedMessageError
from ..screws.se3 import Array

_STAMP = Struct('<4xiI').unpack_from
# Linear before angular in messages, angular first here.
_ANGULAR_FIRST = [3, 4, 5, 0, 1, 2]


def read_states(type_name: str, floats: int, messages: list[bytes]) -> tuple[Array, Array]:
    """
    Return stamps, of shape (N,) [ns], and values of messages of one topic of the node.

    As many numbers as each message ends with: 7 for a pose, position and quaternion, else 6,
    angular first.

    Raises
    ------
    MalformedMessageError
        A message is too short, or in another encoding.

    """
    size = 8 * floats
    for data in messages:
        if len(data) < 12 + size or data[:2] != b'\0\1':
            raise MalformedMessageError(type_name,
                                        f'{len(data)} bytes that begin with {data[:2].hex()}')
    heads = np.array([_STAMP(data) for data in messages], dtype=np.int64).reshape(-1, 2)
    # All of them end with their numbers, whatever the length of the frame names before.
    tails = np.frombuffer(b''.join(data[-size:] for data in messages), dtype='<f8')
    values = tails.reshape(-1, floats)
    return heads @ np.array([1_000_000_000, 1]), (
        values if floats == 7 else values[:, _ANGULAR_FIRST])
