# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Encoding of `sensor_msgs/JointState` and `trajectory_msgs/JointTrajectory`.

Both hold names and, for each derivative, an array of numbers. Everything but stamp and numbers
is laid out once, in little-endian CDR (see :mod:`.joint_state`).
"""
from __future__ import annotations

from collections.abc import Sequence

from .stamped import StampedEncoder, UNSTAMPED, with_count, with_floats, with_text


class _ArraysEncoder(StampedEncoder):
    """
    The layout of a message with so many arrays, one number for each joint; efforts are empty.

    The arrays may be the only one of a sequence of points, each of which ends in a duration.
    """

    __slots__ = ()

    def __init__(self, joint_names: Sequence[str], frame_id: str, arrays: int,
                 points: bool) -> None:
        n = len(joint_names)
        body = with_count(with_text(UNSTAMPED, frame_id), n)
        for name in joint_names:
            body = with_text(body, name)
        if points:
            body = with_count(body, 1)
        places: list[int] = []
        for _ in range(arrays):
            body, more = with_floats(with_count(body, n), n)
            places += more
        body = with_count(body, 0)
        super().__init__(body + bytes(8) if points else body, places, range(arrays * n))


class JointStateEncoder(_ArraysEncoder):
    """Writes `JointState` with positions and velocities."""

    __slots__ = ()

    def __init__(self, joint_names: Sequence[str]) -> None:
        super().__init__(joint_names, '', 2, points=False)


class JointTrajectoryEncoder(_ArraysEncoder):
    """Writes `JointTrajectory` of one point, from start: positions, velocities, accelerations."""

    __slots__ = ()

    def __init__(self, joint_names: Sequence[str]) -> None:
        super().__init__(joint_names, '', 3, points=True)
