# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Recorded robots as they are shown: smoothed states, some tens of them a second."""
from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from .motion import ShownMotion, Snapshot, tip_covariance
from ...errors import ToolError
from ...pipeline.settings import RobotSettings
from ...recordings.joint_table import JointTable, TableFormat
from ...recordings.recording import Recording
from ...recordings.sources import find_sources, opened
from ...recordings.states import recorded_robot, RecordedRobot
from ...screws.se3 import Array

RATE = 60.0
"""States shown per second of a short recording [Hz]."""
MOST = 12_000
"""States shown of a long one."""


def recorded_motions(path: str, robots: Sequence[RobotSettings], namespace: str,
                     ) -> list[ShownMotion]:
    """
    Return what is shown of the robots of a recording.

    Parameters
    ----------
    path : str
        A bag, a table of joint states, or the URL of one.
    robots : sequence of RobotSettings
        As the node has them.
    namespace : str
        Of the node.

    Raises
    ------
    ToolError
        There is no recording, or no state of any robot in it.

    """
    source = find_sources([path])[0]
    motions = []
    for settings in robots:
        with opened(source.place, TableFormat()) as recording:
            motions.append(_motion(recording, recorded_robot(recording, settings, namespace, 2)))
    shown = [motion for motion in motions if motion.snapshots]
    if not shown:
        reasons = '; '.join(doubt for motion in motions for doubt in motion.doubts)
        raise ToolError(f'{path}: no state of {", ".join(m.name for m in motions)}: {reasons}')
    return shown


def _motion(recording: Recording | JointTable, robot: RecordedRobot) -> ShownMotion:
    blocks = list(robot.states(recording))
    motion = ShownMotion(robot.settings.name, robot.model,
                         description=robot.settings.description)
    motion.doubts = list(_doubts(recording, robot))
    if not blocks:
        return motion
    stamps = np.concatenate([block.stamps for block in blocks])
    time = (stamps - stamps[0]) * 1e-9
    kept = _thinned(time)
    q, qd, qdd = np.concatenate([block.motion[:3] for block in blocks], axis=1)[:, kept]
    variance = np.concatenate([block.variances[2] for block in blocks])[kept]
    state = robot.model.state(q, qd, qdd)
    lines = robot.model.skeleton(q)
    covariance = tip_covariance(robot.model, q, variance)
    twist, accel = state.classical(1), state.classical(2)
    motion.snapshots = [
        Snapshot(time[k], q[i], tuple(line[i] for line in lines), state.pose[i], twist[i],
                 accel[i], covariance[i] if np.isfinite(variance[i]).all() else None)
        for i, k in enumerate(kept)]
    return motion


def _thinned(time: Array) -> Array:
    """Return which of many instants are shown, evenly in time."""
    rate = min(RATE, MOST / max(float(time[-1] - time[0]), 1e-9))
    ticks = np.floor((time - time[0]) * rate)
    return np.flatnonzero(np.concatenate([[True], np.diff(ticks) > 0]))


def _doubts(recording: Recording | JointTable, robot: RecordedRobot) -> Iterator[str]:
    yield from robot.model.warnings
    yield from robot.findings
    yield from getattr(recording, 'damage', ())
    missing = robot.groups.missing()
    if missing:
        yield f'nobody publishes {", ".join(missing)}'
    for reason, count in robot.account.refused.items():
        if count:
            yield f'{count} of {robot.account.received} samples not used: {reason}'
