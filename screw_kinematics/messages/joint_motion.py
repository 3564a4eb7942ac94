# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Encoding of `sensor_msgs/JointState` and `trajectory_msgs/JointTrajectory`.

Both hold names and, for each derivative, an array of numbers. Everything but stamp and numbers
is laid out once, in little-endian CDR (see :mod:`.joint_state`).
"""
from __future__ import annotations

from collections.abc import Sequence
import struct

from .stamped import out_of_range, with_count, with_text

_SECOND = 1_000_000_000     # ns


class _ArraysEncoder:
    """
    The layout of a message with so many arrays, one number for each joint.

    Parameters
    ----------
    joint_names : sequence of str
    frame_id : str
    arrays : int
        Arrays with numbers; an empty one for efforts follows.
    points : bool
        Whether they are the only one of a sequence of points, each of which ends in a duration.

    """

    __slots__ = ('_pack', '_head', '_arrays', '_count')

    def __init__(self, joint_names: Sequence[str], frame_id: str, arrays: int,
                 points: bool) -> None:
        body = bytes(8)         # alignment counts from before the stamp
        body = with_text(body, frame_id)
        body = with_count(body, len(joint_names))
        for name in joint_names:
            body = with_text(body, name)
        if points:
            body = with_count(body, 1)
        self._head = body[8:]
        layout, at = f'<4siI{len(self._head)}s', len(body)
        for _ in range(arrays):
            before = -at % 4
            after = -(at + before + 4) % 8
            layout += f'{before}xI{after}x{len(joint_names)}d'
            at += before + 4 + after + 8 * len(joint_names)
        self._pack = struct.Struct(layout + ('I8x' if points else 'I')).pack
        self._arrays, self._count = arrays, len(joint_names)

    def encode(self, stamp_ns: int, values: Sequence[float]) -> bytes:
        """Return a message, as of .stamped; values: positions, velocities, ... [rad, m]."""
        n = self._count
        arrays = [x for k in range(self._arrays) for x in (n, *values[k * n:(k + 1) * n])]
        try:
            return self._pack(b'\0\1\0\0', stamp_ns // _SECOND, stamp_ns % _SECOND, self._head,
                              *arrays, 0)
        except struct.error:
            raise out_of_range(stamp_ns) from None


class JointStateEncoder(_ArraysEncoder):
    """
    Writes `JointState` with positions and velocities.

    Parameters
    ----------
    joint_names : sequence of str
        In the order of the values, at least one.

    """

    __slots__ = ()

    def __init__(self, joint_names: Sequence[str]) -> None:
        super().__init__(joint_names, '', 2, points=False)


class JointTrajectoryEncoder(_ArraysEncoder):
    """
    Writes `JointTrajectory` of one point, from start: positions, velocities, accelerations.

    Parameters
    ----------
    joint_names : sequence of str
        In the order of the values, at least one.

    """

    __slots__ = ()

    def __init__(self, joint_names: Sequence[str]) -> None:
        super().__init__(joint_names, '', 3, points=True)
