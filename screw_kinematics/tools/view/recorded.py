# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Recorded robots as they are shown: smoothed states, some tens of them a second."""
from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from .motion import moved, ShownMotion, Snapshot, tip_covariance
from ...errors import ParameterError, ToolError
from ...pipeline.settings import RobotSettings
from ...recordings.joint_table import JointTable, TableFormat
from ...recordings.recording import Recording
from ...recordings.sources import find_sources, opened
from ...recordings.states import recorded_robot, RecordedRobot, StateBlock
from ...screws.rigid import pose_from_row
from ...screws.se3 import Array

RATE = 60.0
"""States shown per second of a short recording [Hz]."""
MOST = 12_000
"""States shown of a long one."""


def recorded_motions(path: str, robots: Sequence[RobotSettings], namespace: str,
                     ) -> list[ShownMotion]:
    """Return what is shown of the robots of a recording: a bag, a table, or the URL of one."""
    source, *others = find_sources([path])
    if others:
        raise ParameterError('recording', path, f'one recording, and not a folder of '
                             f'{1 + len(others)}, such as {source.place}')
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
    motion.world = '' if robot.base is None else robot.base.world
    tip = robot.at_tip('pose', 'twist', 'accel', 'jacobian')
    found = [tip(block) for block in blocks]
    poses, twists, accels, jacobians = (
        np.concatenate([each[name] for each in found])[kept]
        for name in ('pose', 'twist', 'accel', 'jacobian'))
    poses = pose_from_row(poses)
    q = np.concatenate([block.motion[0] for block in blocks])[kept]
    variances = np.concatenate([_variances(block) for block in blocks])[kept]
    covariances = tip_covariance(jacobians.reshape(len(kept), 6, -1), variances)
    bases = np.concatenate([_bases(block) for block in blocks])[kept]
    lines = moved(robot.model.skeleton(q), bases)
    motion.snapshots = [
        Snapshot(time[k], q[i], tuple(line[i] for line in lines), poses[i], twists[i],
                 accels[i], covariances[i] if np.isfinite(variances[i]).all() else None,
                 base=bases[i])
        for i, k in enumerate(kept)]
    return motion


def _variances(block: StateBlock) -> Array:
    """Return those of the accelerations of all that moves, as columns of the Jacobian have it."""
    joints = block.variances[2]
    return joints if block.base_variances is None else np.concatenate(
        [joints, block.base_variances[:, 6:12]], axis=1)


def _bases(block: StateBlock) -> Array:
    """Return the poses of the base, shape (N, 4, 4)."""
    if block.base is None:
        return np.broadcast_to(np.eye(4), (len(block.stamps), 4, 4))
    return pose_from_row(block.base[:, :12])


def _thinned(time: Array) -> Array:
    """Return which of many instants are shown, evenly in time."""
    rate = min(RATE, MOST / max(float(time[-1] - time[0]), 1e-9))
    ticks = np.floor((time - time[0]) * rate)
    return np.flatnonzero(np.concatenate([[True], np.diff(ticks) > 0]))


def _doubts(recording: Recording | JointTable, robot: RecordedRobot) -> Iterator[str]:
    yield from robot.model.warnings
    yield from robot.findings
    yield from getattr(recording, 'damage', ())
    missing = robot.groups.describe_missing()
    if missing:
        yield missing
    for reason, count in robot.account.refused.items():
        if count:
            yield f'{count} of {robot.account.received} samples not used: {reason}'
