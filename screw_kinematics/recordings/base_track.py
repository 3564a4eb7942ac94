# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The motion of a base over a whole recording, smoothed with past and future in view."""
from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .blocks import cut
from .joint_table import JointTable
from .recording import full_name, Recording, Sample
from .side_topic import samples_on
from .smoothing import Smoother
from ..errors import MalformedMessageError, Reason, ToolError
from ..messages.base_motion import READERS
from ..messages.joint_state import JointSample
from ..pipeline.account import Account
from ..pipeline.joint_groups import JointGroups
from ..pipeline.moving_base import BaseFrames, COMPONENTS, MAX_ACCELERATION
from ..pipeline.odometry_watch import OdometryWatch
from ..pipeline.settings import MotionSettings, RobotSettings
from ..programs.moving_base import AT_REST, carry_batch
from ..screws.se3 import Array


class BaseTrack(NamedTuple):
    """Motion of a base: its poses, and its twist and the derivatives in its own axes."""

    world: str             # that it is relative to; without poses the base frame
    posed: bool            # whether there are poses
    pose_stamps: Array     # (N,) [ns]
    poses: Array           # (N, 12), position and rotation by rows
    stamps: Array          # (M,) [ns]
    components: Array      # (M, 24), twist to snap
    variances: Array       # (M, 24)
    account: Account       # of the messages
    findings: list[str]    # what is odd about them

    def at(self, instants: Array, timeout: float) -> tuple[Array, Array, Array]:
        """
        Return the motion at instants [ns], carried there from the nearest one.

        Which instants, of shape (N,), have one within the timeout [s]; of these K the motion, of
        shape (K, BASE_INPUTS), and the variances, of shape (K, 24).
        """
        places, twists = _nearest(self.pose_stamps, instants), _nearest(self.stamps, instants)
        away = np.stack([instants - self.pose_stamps[places], instants - self.stamps[twists]],
                        axis=1)
        known = (np.abs(away) <= timeout * 1e9).all(axis=1)
        places, twists = places[known], twists[known]
        motion = carry_batch(np.concatenate(
            [self.poses[places], self.components[twists], away[known] * 1e-9], axis=1))
        if not self.posed:
            motion[:, :12] = AT_REST[:12]
        return known, motion, self.variances[twists]


def recorded_base(recording: Recording | JointTable, settings: RobotSettings, model: Any,
                  namespace: str) -> BaseTrack:
    """Return the motion of a robot's base in a recording."""
    topic = full_name(namespace, settings.base_motion_topic)
    account, watch = Account(), OdometryWatch()
    frames = BaseFrames.of(model, settings.frame_prefix)
    twists: list[Sample] = []
    poses: list[tuple[int, Any]] = []
    world = ''
    for received, sample in samples_on(recording, topic, READERS, 'motion of a base'):
        if isinstance(sample, MalformedMessageError):
            account.close(Reason.MALFORMED, str(sample))
            continue
        refused = frames.refusal(sample)
        if refused is not None:
            account.close(*refused)
            continue
        stamp = sample.stamp_ns
        world = world or frames.world_of(sample)
        if frames.world_of(sample) != world:
            account.close(Reason.BASE_FRAME, f'frame_id is {sample.world!r}; allowed: {world!r}')
            continue
        if poses and stamp <= poses[-1][0]:
            account.close(Reason.STAMP_NOT_INCREASING)
            continue
        if sample.world is not None:
            watch.update(sample)
        poses.append((stamp, frames.pose_row(sample)))
        twists.append((topic, received, JointSample(
            stamp, COMPONENTS, tuple(frames.twist(sample).tolist()), ())))
    blocks = list(map(_smoother(settings.motion), cut(twists, JointGroups(COMPONENTS), account)))
    blocks = [block for block in blocks if len(block.stamps)]
    if not blocks:
        said = account.details.values() or [f'{len(twists)} messages, too few or too far apart']
        raise ToolError(f'{recording.path}: {topic}: the motion of the base is not known: '
                        f'{list(said)[-1]}')
    account.outputs = sum(len(block.stamps) for block in blocks)
    return BaseTrack(
        world, world != frames.base, np.array([stamp for stamp, _ in poses]),
        np.array([row for _, row in poses]),
        np.concatenate([block.stamps for block in blocks]),
        np.concatenate([_rows(block.motion) for block in blocks]),
        np.concatenate([_rows(block.variances) for block in blocks]), account,
        [*watch.findings(), *(
            f'{count} messages of the base refused: {account.told(reason)}'
            for reason, count in account.refused.items() if count)])


def _smoother(settings: MotionSettings) -> Smoother:
    """Return what smooths the six components of the twist, as positions of joints."""
    return Smoother(MotionSettings('estimated', options={'max_gap': settings.options['max_gap']}),
                    (False,) * 6, (MAX_ACCELERATION,) * 6, 3, COMPONENTS)


def _rows(derivatives: Array) -> Array:
    """Return arrays of shape (4, N, 6) as rows, shape (N, 24)."""
    return np.moveaxis(derivatives, 0, 1).reshape(derivatives.shape[1], -1)


def _nearest(stamps: Array, instants: Array) -> Array:
    """Return the index of the nearest stamp."""
    after = np.clip(np.searchsorted(stamps, instants), 1, max(len(stamps) - 1, 1))
    nearer = instants - stamps[after - 1] < stamps[np.minimum(after, len(stamps) - 1)] - instants
    return np.where(nearer, after - 1, np.minimum(after, len(stamps) - 1))
