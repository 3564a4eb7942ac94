# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""From recorded joint samples to the states of a robot, without the node's lag."""
from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from .blocks import SmoothedBlock, Smoothing
from .joining import Joining
from .smoothed_blocks import SmoothedBlocks
from .stage_times import StageTimes
from ..pipeline.account import Account
from ..pipeline.joint_groups import JointGroup, JointGroups
from ..pipeline.outputs import KINDS
from ..pipeline.robot_model import continuous_joints
from ..pipeline.settings import RobotSettings
from ..screws.se3 import Array

LEFT_OUT = ('twist_with_covariance', 'accel_with_covariance', 'markers',
            'passive_joint_states')
"""Outputs of the node that are not made from recordings."""


class StateBlock(NamedTuple):
    """
    States of a robot at many instants.

    Attributes
    ----------
    stamps, received : array of int, shape (N,)
        What they describe, and when the joint sample came [ns].
    values : array, shape (N, size)
        All outputs of the program, one after the other.

    """

    stamps: Array
    received: Array
    values: Array


class RobotStates:
    """
    One robot's way from recorded joint samples to states.

    Parameters
    ----------
    settings : RobotSettings
        As the node has them.
    model : SerialChain
        Or any model with ``joint_names`` and ``compile``.
    smoothing : Smoothing
        Where joint samples are smoothed.
    stages : StageTimes
        Gets the time spent.

    """

    def __init__(self, settings: RobotSettings, model: Any, smoothing: Smoothing,
                 stages: StageTimes) -> None:
        self.settings = settings
        self.model = model
        self.outputs = tuple(name for name in settings.outputs if name not in LEFT_OUT)
        self.account = Account()
        needs = tuple(dict.fromkeys(n for o in self.outputs for n in KINDS[o].needs))
        self.program = model.compile(needs, axes=settings.expressed_in,
                                     pole=settings.reference_point)
        self._smoothing, self._stages = smoothing, stages
        self._continuous = continuous_joints(model)
        self._groups = JointGroups(model.joint_names)
        self._blocks: dict[JointGroup, SmoothedBlocks] = {}
        self._joining = Joining(len(model.joint_names), self.account.refused)

    def add(self, samples: Iterable[tuple[int, Any]]) -> Iterator[StateBlock]:
        """
        Take joint samples; yield states.

        Parameters
        ----------
        samples : iterable of (int, JointSample)
            When each was received [ns], and what it says.

        """
        account = self.account
        for received, sample in samples:
            account.received += 1
            layout = self._groups.find(sample.names)
            if isinstance(layout, str):
                account.refused[layout] += 1
                continue
            if len(sample.position) != layout.length:
                account.refused['position_of_wrong_length'] += 1
                continue
            blocks = self._blocks.get(layout.group) or self._new_blocks(layout.group)
            velocity = layout.pick(sample.velocity) if (
                len(sample.velocity) == layout.length) else None
            # A message without a stamp is taken to be of the moment it came, as the node does.
            for block in blocks.add(sample.stamp_ns or received, received,
                                    layout.pick(sample.position), velocity):
                yield from self._evaluate(layout.group, block)

    def finish(self) -> Iterator[StateBlock]:
        """Yield the rest."""
        for group, blocks in self._blocks.items():
            for block in blocks.finish():
                yield from self._evaluate(group, block)
            self.account.refused.update(blocks.refused)

    def _new_blocks(self, group: JointGroup) -> SmoothedBlocks:
        motion = self.settings.motion
        blocks = SmoothedBlocks(
            [self._continuous[c] for c in group.columns], self.program.order,
            motion.options['max_gap'], motion.velocity_source != 'estimated', self._smoothing,
            self._stages)
        self._blocks[group] = blocks
        return blocks

    def _evaluate(self, group: JointGroup, block: SmoothedBlock) -> Iterator[StateBlock]:
        for joined in self._joining.add(group, block, self._groups.groups):
            with self._stages.stage('evaluate'):
                results = self.program.batch(*joined.motion)
                values = np.concatenate([results[name] for name in self.program.slices], axis=1)
            finite = np.isfinite(values).all(axis=1)
            self.account.refused['state_not_finite'] += int((~finite).sum())
            self.account.outputs += int(finite.sum())
            if finite.any():
                yield StateBlock(joined.stamps[finite], joined.received[finite],
                                 values[finite])
