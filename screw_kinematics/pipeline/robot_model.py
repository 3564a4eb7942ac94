# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""From the settings of a robot to its model."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from .settings import MotionSettings, RobotSettings
from .. import models
from ..errors import ModelError, ParameterError
from ..screws.rotations import pose, rotation_rpy

MARGIN = 1.5
"""Joints that seem to move faster than so many times their limit are refused as implausible."""


class TipsModel:
    """
    Several ends of one robot, from one base frame; joints that they share have the same names.

    Columns are for each tip, in its order, which of the measured joints of all are its own.
    """

    def __init__(self, tips: Sequence[Any]) -> None:
        self.tips = tuple(tips)
        self.joint_names = tuple(dict.fromkeys(name for tip in tips for name in tip.joint_names))
        place = {name: k for k, name in enumerate(self.joint_names)}
        self.columns = [tuple(place[name] for name in tip.joint_names) for tip in tips]
        kinds = {name: kind for tip in tips
                 for name, kind in zip(tip.joint_names, tip.joint_kinds)}
        self.joint_kinds = tuple(kinds[name] for name in self.joint_names)
        limits = np.full(len(self.joint_names), np.inf)
        for tip, columns in zip(tips, self.columns):
            limits[list(columns)] = np.minimum(limits[list(columns)], tip.velocity_limits)
        self.velocity_limits = limits
        self.warnings = tuple(dict.fromkeys(text for tip in tips for text in tip.warnings))

    def __repr__(self) -> str:
        ends = ', '.join(tip.tip_frame for tip in self.tips)
        return (f'{self.tips[0].name}: {len(self.joint_names)} joints, '
                f'{self.tips[0].base_frame} -> {ends}')


def tips_of(model: Any) -> tuple[Sequence[Any], Sequence[Sequence[int]]]:
    """Return the chains of a model, and for each which of the measured joints are its own."""
    if isinstance(model, TipsModel):
        return model.tips, model.columns
    return (model,), (range(len(model.joint_names)),)


def build_model(settings: RobotSettings, text: str | None = None) -> Any:
    """
    Return the model of a robot, with its tool; or with all its tips and their tools.

    The text is URDF from the description topic; by default the ``description`` is followed.
    """
    if settings.tips:
        return TipsModel([build_model(tip, text) for tip in settings.parts])
    frames = settings.base_frame or None, settings.tip_frame or None
    given = settings.description
    model: Any
    if text is not None:
        model = models.load_urdf(text, *frames, source=f'topic {settings.description_topic!r}')
    elif given.lstrip().startswith('<'):
        model = models.load_urdf(given, *frames,
                                 source=f"parameter '{settings.name}.description'")
    else:
        model = models.load(given, *frames)
    if not model.joint_names:
        raise ModelError(
            model.name, 'no joint moves between the frames '
            f'{model.base_frame!r} and {model.tip_frame!r}')
    check_outputs(settings, model)
    if settings.has_tool:
        offset = settings.tool_offset
        model = model.with_tool(
            pose(rotation_rpy(*offset[3:]), offset[:3]), f'{model.tip_frame}_tool')
    return model


def check_outputs(settings: RobotSettings, model: Any) -> None:
    """Raise ParameterError if the model cannot give the outputs asked for."""
    if isinstance(model, TipsModel):
        for part, tip in zip(settings.parts, model.tips):
            check_outputs(part, tip)
        return
    if 'passive_joint_states' in settings.outputs and not hasattr(model, 'passive_joint_names'):
        raise ParameterError(
            f'{settings.name}.outputs', list(settings.outputs),
            f'passive_joint_states for parallel robots only, which {model!r} is not')
    if settings.wrench_frame and settings.wrench_frame not in model.fixed_frames:
        raise ParameterError(
            f'{settings.name}.wrench_frame', settings.wrench_frame,
            f'a link that is fixed to the tip frame {model.tip_frame!r}: '
            f'{", ".join(model.fixed_frames)} (for a sensor elsewhere name its link in tips)')


def plausible_velocities(motion: MotionSettings, model: Any) -> tuple[float, ...]:
    """
    Return for each measured joint of a model how fast it may seem to move [rad/s, m/s].

    That is ``estimator.max_velocity``, or :data:`MARGIN` times the limit in the description
    where that is less.
    """
    return tuple(min(motion.max_velocity, MARGIN * limit)
                 for limit in model.velocity_limits.tolist())


def continuous_joints(model: Any) -> tuple[bool, ...]:
    """Return for each measured joint of a model whether its position may wrap at 2 pi."""
    return tuple(kind == 'continuous' for kind in model.joint_kinds)


class MovingJoint(NamedTuple):
    """A joint of a model that follows a measured one, or is one: multiplier 1, offset 0."""

    column: int
    multiplier: float
    offset: float

    def of(self, value: float, derivative: int) -> float:
        """Return the joint's position (0) or rate, from that of the measured one."""
        return self.multiplier * value + (self.offset if derivative == 0 else 0.0)


def moving_joints(model: Any) -> tuple[list[str], Sequence[MovingJoint]]:
    """Return names of all joints whose motion the measured ones tell, in the model's order."""
    column = {name: k for k, name in enumerate(model.joint_names)}
    joints = [joint for joint in getattr(model, 'joints', ()) if joint.source in column]
    if not joints:
        return list(model.joint_names), [MovingJoint(k, 1.0, 0.0) for k in column.values()]
    # A measured joint may not be on the way from base to tip, while its followers are.
    mimics = [joint.mimic for joint in joints]
    moving = [MovingJoint(column[joint.source], *(
        (1.0, 0.0) if mimic is None else (float(mimic.multiplier), float(mimic.offset))))
        for joint, mimic in zip(joints, mimics)]
    return [joint.name for joint in joints], moving
