# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""From recorded joint samples to the states of a robot, without the node's lag."""
from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from .base_track import BaseTrack, recorded_base
from .blocks import Block, cut
from .joint_table import JointTable
from .recording import description_in, full_name, Recording, Sample
from .smoothing import MotionBlock, Smoother
from .wrenches import recorded_sensor
from ..errors import Reason, ToolError
from ..messages.joint_state import JointSample
from ..pipeline.account import Account
from ..pipeline.joint_groups import JointGroups
from ..pipeline.outputs import KINDS
from ..pipeline.robot_model import build_model, continuous_joints, plausible_velocities
from ..pipeline.robot_program import compile_tip
from ..pipeline.settings import RobotSettings
from ..pipeline.wrench_sensor import WrenchSensor
from ..screws.se3 import Array

LEFT_OUT = ('markers', 'passive_joint_states')
"""Outputs of the node that are not made from recordings."""

Run = Callable[[Callable[[Block], MotionBlock], Iterable[Block]], Iterable[MotionBlock]]
"""What calls a function on blocks and gives the results in their order, as ``map`` does."""


class StateBlock(NamedTuple):
    """States of a robot at many instants."""

    stamps: Array                          # (N,), what they describe [ns]
    received: Array                        # (N,), when the joint sample came [ns]
    motion: Array                          # (order + 1, N, n), of the joints
    values: Array                          # (N, size), all outputs of the program
    variances: Array                       # (4, N, n), of the joints' positions to jerks
    base: Array | None = None              # (N, BASE_INPUTS), in the world
    base_variances: Array | None = None    # (N, 24), of its twist and the derivatives


class RecordedRobot:
    """
    A robot in a recording, and what is made of its joint samples.

    The order is the joints' highest derivative that is wanted, beside what the outputs need.
    """

    def __init__(self, settings: RobotSettings, model: Any, namespace: str = '',
                 order: int = 0) -> None:
        self.settings = settings
        self.model = model
        self._namespace = namespace
        self.topics = tuple(full_name(namespace, topic) for topic in settings.joint_states_topic)
        self.outputs = tuple(name for name in settings.outputs if name not in LEFT_OUT)
        self.account = Account()
        self.period = float('nan')
        self.findings: list[str] = []
        self.sensor: WrenchSensor | None = None
        self.groups = JointGroups(model.joint_names)
        needs = tuple(dict.fromkeys(
            need for output in self.outputs for need in KINDS[output].needs)) or ('pose',)
        self.program = compile_tip(model, needs, settings)
        self.base: BaseTrack | None = None
        self.order = max(order, self.program.order, *(KINDS[name].order for name in self.outputs))

    def states(self, recording: Recording | JointTable, run: Run = map) -> Iterator[StateBlock]:
        """Yield the states in a recording, block by block."""
        if 'compensated_wrench' in self.outputs:
            topic = full_name(self._namespace, self.settings.wrench_topic)
            self.sensor = recorded_sensor(recording, self.settings, self.model, topic)
        if self.settings.relative_to == 'world':
            self.base = recorded_base(recording, self.settings, self.model, self._namespace)
            self.findings = list(self.base.findings)
        asked = self.settings.motion
        smoother = Smoother(asked, continuous_joints(self.model),
                            plausible_velocities(asked, self.model), self.order,
                            self.model.joint_names)
        for motion in run(smoother, cut(self._samples(recording), self.groups, self.account)):
            self.account.refused.update(motion.refused)
            self.period = motion.period
            self.findings = self.findings or list(motion.findings)
            states = self._evaluate(motion)
            if len(states.stamps):
                yield states

    def at_tip(self, *outputs: str) -> Callable[[StateBlock], dict[str, Array]]:
        """
        Return what computes these outputs of the states in a block.

        About the tip, in axes of what the states are relative to, whatever the settings say.
        """
        program = compile_tip(self.model, outputs, replace(
            self.settings, expressed_in='base', reference_point='tip'))
        return lambda block: _batch(program, block.motion, block.base)

    def _samples(self, recording: Recording | JointTable) -> Iterator[Sample]:
        offset = self.settings.motion.stamp_offset_ns
        for topic, received, sample in self._recorded(recording):
            if offset and isinstance(sample, JointSample):
                sample = sample._replace(stamp_ns=sample.stamp_ns + offset)
            yield topic, received, sample

    def _recorded(self, recording: Recording | JointTable) -> Iterator[Sample]:
        if isinstance(recording, JointTable):
            return recording.samples(dict(zip(self.model.joint_names, self.model.joint_kinds)))
        recording.require_joint_states(set(self.topics))
        return recording.samples(set(self.topics))

    def _evaluate(self, block: MotionBlock) -> StateBlock:
        base, unsure = None, None
        if self.base is not None:
            known, base, unsure = self.base.at(block.stamps, self.settings.stale_timeout)
            self.account.refused[Reason.BASE_TOO_OLD] += int((~known).sum())
            block = block._replace(
                stamps=block.stamps[known], received=block.received[known],
                motion=block.motion[:, known], variances=block.variances[:, known])
        results = _batch(self.program, block.motion, base)
        values = np.concatenate([results[name] for name in self.program.slices], axis=1)
        finite = np.isfinite(values).all(axis=1)
        self.account.refused[Reason.STATE_NOT_FINITE] += int((~finite).sum())
        self.account.outputs += int(finite.sum())
        return StateBlock(
            block.stamps[finite], block.received[finite], block.motion[:, finite],
            values[finite], block.variances[:, finite],
            *(None if each is None else each[finite] for each in (base, unsure)))


def _batch(program: Any, motion: Array, base: Array | None) -> dict[str, Array]:
    of_base = {} if base is None else {'base': base}
    results: dict[str, Array] = program.batch(*motion[:program.order + 1], **of_base)
    return results


def recorded_robot(recording: Recording | JointTable, settings: RobotSettings, namespace: str,
                   order: int = 0) -> RecordedRobot:
    """Return a robot with its model, which may be in the recording."""
    text = None
    if not settings.description:
        topic = full_name(namespace, settings.description_topic)
        text = description_in(recording, topic) if isinstance(recording, Recording) else None
        if text is None:
            raise ToolError(f'{recording.path}: no robot description on {topic}; name the '
                            "model in the parameter 'description'")
    return RecordedRobot(settings, build_model(settings, text), namespace, order)
