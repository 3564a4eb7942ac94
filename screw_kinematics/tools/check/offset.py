# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A recorded robot against another stream that saw it move: clocks, mounting, what is left."""
from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from .findings import FACT, Finding, PROBLEM, REMARK
from .offset_picture import draw_offset
from ...pipeline.settings import RobotSettings
from ...recordings.clock_offset import ClockOffset, find_offset, UNRELATED, VAGUE
from ...recordings.link_motion import link_motion
from ...recordings.motion_streams import channels, read_stream, Stream
from ...recordings.recording import full_name, Recording
from ...screws.rotations import roll_pitch_yaw
from ...screws.se3 import Array

_IMU = 'sensor_msgs/msg/Imu'
_MEASURED = {
    _IMU: ('angular velocity', 'specific force'),
    'geometry_msgs/msg/WrenchStamped': ('force',),
    'geometry_msgs/msg/PoseStamped': ('position',),
    'nav_msgs/msg/Odometry': ('angular velocity', 'velocity')}


def compare_clocks(recording: Recording, settings: RobotSettings, namespace: str, topic: str,
                   picture: Path | None = None) -> Iterator[Finding]:
    """Yield how far the joint states' clock is from that of a stream fixed to the robot's tip."""
    topic = full_name(namespace, topic)
    stream = read_stream(recording, topic)
    link = link_motion(recording, settings, namespace)
    groups = channels(stream, link)
    found = find_offset(link.stamps, stream.stamps, groups)
    if picture is not None:
        draw_offset(picture, topic, stream, groups, _MEASURED[stream.kind], link, found)
    yield from _report_clocks(topic, settings, stream, found)
    if stream.kind == _IMU:
        yield from _report_mounting(topic, settings.tip_frame or 'the tip', found)


def _report_clocks(topic: str, settings: RobotSettings, stream: Stream, found: ClockOffset,
                   ) -> Iterator[Finding]:
    yield Finding(
        FACT, f'{topic}: {found.told()}',
        '' if found.deviation > VAGUE else
        f'set {settings.name}.stamp_offset: {settings.motion.stamp_offset - found.offset:.6f}, or '
        f'add {found.offset:+.6f} s to its stamps')
    if abs(found.drift) > 3 * found.drift_deviation and abs(found.drift) > 1e-5:
        yield Finding(REMARK, f'{topic}: the offset grows by {1e6 * found.drift:.0f} us a second',
                      'the clocks run at different rates: synchronise them (chrony, PTP)')
    if found.deviation > VAGUE:
        yield Finding(REMARK, f'{topic}: the motion tells the offset to '
                      f'{1e3 * found.deviation:.1f} ms only', 'move faster, and to and fro')
    for what, share, left in zip(_MEASURED[stream.kind], found.shares, found.residuals):
        level = PROBLEM if share < UNRELATED else FACT
        yield Finding(
            level, f'{topic}: {100 * share:.2f} % of the variance of its {what} is the motion of '
            f'the joints; left are {_listed(left)}',
            'is it fixed to this link? does it measure this robot?' if level == PROBLEM else '')


def _report_mounting(topic: str, frame: str, found: ClockOffset) -> Iterator[Finding]:
    """Yield how an IMU is mounted, by the angular velocities, and its biases."""
    matrix, bias = found.coefficients[0][:3].T, found.coefficients[0][3]
    left, sizes, right = np.linalg.svd(matrix)
    rotation = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
    roll, pitch, yaw = np.degrees(roll_pitch_yaw(rotation.T))
    yield Finding(FACT, f'{topic}: turned against {frame} by roll {roll:.2f}, pitch {pitch:.2f}, '
                        f'yaw {yaw:.2f} degrees; bias of the gyroscope {_listed(bias)} rad/s')
    if np.abs(sizes - 1).max() > 0.05:
        yield Finding(REMARK, f'{topic}: angular velocities are {sizes.mean():.3f} times those of '
                      f'{frame}', 'another unit, another link, or too little motion about an axis')


def _listed(values: Array) -> str:
    return ', '.join(f'{value:.3g}' for value in values)
