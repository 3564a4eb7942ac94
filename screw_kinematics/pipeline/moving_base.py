# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The motion of the base a robot stands on: from odometry to the motion at any instant."""
from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import hypot, nan
from typing import Any, NamedTuple, TypeVar

import numpy as np

from .account import Account
from .odometry_watch import OdometryWatch
from .robot_model import tips_of
from .settings import MotionSettings
from ..errors import Reason
from ..messages.base_motion import BaseSample
from ..motion import MotionEstimator
from ..motion.joint_motion import JointMotion
from ..programs.moving_base import AT_REST, carry
from ..screws.rigid import row_of_pose
from ..screws.rotations import pose, rotation_from_quaternion
from ..screws.se3 import adjoint, Array, inverse

MAX_ACCELERATION = 100.0
"""A base that seems to gather speed faster is refused as implausible [rad/s^2, m/s^2]."""

MAX_STEP = 1.0
"""Twice the noise that a measured twist may have [rad/s, m/s]."""

LARGEST = 1e9
"""Beyond this [m, rad/s, m/s] a number is no motion of a base."""

COMPONENTS = ('angular x', 'angular y', 'angular z', 'linear x', 'linear y', 'linear z')

UNIT = 1e-2
"""How far the length of a quaternion may be from 1, as tf2 has it."""

KEPT = 64
"""Motions that are kept, so that instants before the latest one can be served."""


Known = TypeVar('Known', 'BaseMotion', '_Pose')


@dataclass(slots=True)
class BaseMotion:
    """
    Motion of the base at one instant.

    Values are the pose in the world, twist, and its derivatives, as :mod:`..programs.moving_base`
    takes them; variances of the last four, six numbers each, unless they are those of an estimate
    since whose instant so much time [s] has passed.
    """

    stamp_ns: int
    values: Sequence[float]
    known_variances: Sequence[float] = (nan,) * 24
    estimate: JointMotion | None = None
    since: float = 0.0

    def variances(self, derivative: int) -> Sequence[float]:
        """Return those of the pose (0), the twist (1), its rate (2), ...; NaN if not known."""
        if derivative == 0:
            return (nan,) * 6
        if self.estimate is not None:
            return self.estimate.variances_after(self.since, derivative - 1)
        return self.known_variances[6 * (derivative - 1):6 * derivative]


class _Pose(NamedTuple):
    """Of the base at an instant: position, then rotation by rows."""

    stamp_ns: int
    row: Sequence[float]


class BaseFrames:
    """
    The frames whose motion tells that of the base: it, and those fixed to it, by their poses.

    Examples
    --------
    >>> lifted = pose(translation=(0, 0, 0.5))
    >>> frames = BaseFrames('arm', {'arm': np.eye(4), 'wheels': inverse(lifted)}, 'r1/')
    >>> rolling = BaseSample(0, 'r1/wheels', (0.0, 1.0, 0.0, 0.0, 0.0, 0.0))
    >>> frames.twist(rolling).tolist()
    [0.0, 1.0, 0.0, 0.5, 0.0, 0.0]
    >>> frames.allowed
    "'r1/arm', 'r1/wheels'"

    """

    def __init__(self, base_frame: str, fixed: Mapping[str, Array], prefix: str = '') -> None:
        self.base = prefix + base_frame
        self._moved = {prefix + name: adjoint(T) for name, T in fixed.items()}
        self._back = {prefix + name: inverse(T) for name, T in fixed.items()}
        self.allowed = ', '.join(map(repr, self._moved))

    @classmethod
    def of(cls, model: Any, prefix: str) -> BaseFrames:
        """Return those of a model, or of the first of several tips."""
        tips, _ = tips_of(model)
        return cls(tips[0].base_frame, tips[0].fixed_to_base, prefix)

    def world_of(self, sample: BaseSample) -> str:
        """Return the frame that its motion is relative to: without a pose the base frame."""
        return self.base if sample.world is None else sample.world

    def refusal(self, sample: BaseSample) -> tuple[Reason, str] | None:
        """Return why a sample is of no use, if it is not, and what is to be said of it."""
        if sample.frame not in self._moved:
            return Reason.BASE_FRAME, (f'the moving frame is {sample.frame!r}; allowed: '
                                       f'{self.allowed}')
        if not self.world_of(sample):
            return Reason.BASE_FRAME, "frame_id is ''; allowed: the name of a frame"
        if not hypot(*sample.twist, *sample.position, *sample.quaternion) < LARGEST:
            return Reason.VALUES_NOT_FINITE, f'twist {sample.twist}, position {sample.position}'
        length = hypot(*sample.quaternion)
        if abs(length - 1) > UNIT:
            return Reason.BASE_ORIENTATION, f'a quaternion of length {length:.3g}; allowed: 1'
        return None

    def twist(self, sample: BaseSample) -> Array:
        """Return the twist of the base in its own axes, about its origin, shape (6,)."""
        return self._moved[sample.frame] @ np.array(sample.twist)

    def pose_row(self, sample: BaseSample) -> Sequence[float]:
        """Return the pose of the base in the world: position, then rotation by rows."""
        if sample.world is None:
            return AT_REST[:12]
        rotation = rotation_from_quaternion(np.array(sample.quaternion))
        row: list[float] = row_of_pose(
            pose(rotation, sample.position) @ self._back[sample.frame]).tolist()
        return row


class MovingBase:
    """
    What is known of a base's motion; it is carried on for a timeout [s] at most.

    The components of its twist in its own axes are to the estimator what the positions of six
    joints are; their derivatives lead to its acceleration, jerk and snap by Lie products. The
    world is the frame of the poses; without poses the base frame as it is at each instant; empty
    as long as nothing came.
    """

    def __init__(self, frames: BaseFrames, settings: MotionSettings,
                 timeout: float = 0.5) -> None:
        self.account = Account()
        self.world = ''
        self._frames = frames
        self._timeout_ns = round(timeout * 1e9)
        # The clock of odometry is its stamps': joints tell it by moving on, a twist need not.
        self._estimator = MotionEstimator(
            6, settings.delay, 'position-only', regularise=False,
            max_gap=float(settings.options.get('max_gap', 0.25)),
            max_velocity=MAX_ACCELERATION, max_jump=MAX_STEP)
        self._poses: deque[_Pose] = deque(maxlen=KEPT)
        self._motions: deque[BaseMotion] = deque(maxlen=KEPT)
        self._watch = OdometryWatch()

    def take(self, sample: BaseSample) -> BaseMotion | Reason:
        """Take a sample; return the motion it leads to, or why there is none."""
        refused = self._frames.refusal(sample) or self._strange(sample)
        if refused is not None:
            return self.account.close(*refused)
        stamp = sample.stamp_ns
        estimate = self._estimator.step(stamp, self._frames.twist(sample).tolist())
        if isinstance(estimate, Reason) and estimate is not Reason.SETTLING:
            return self.account.close(estimate, f'at {stamp * 1e-9:.3f} s')
        self.world = self._frames.world_of(sample)
        row = self._frames.pose_row(sample)
        if sample.world is not None:
            self._watch.update(sample)
        if isinstance(estimate, Reason):        # a new run
            self._motions.clear()
            if self._poses and stamp <= self._poses[-1].stamp_ns:
                self._poses.clear()
        self._poses.append(_Pose(stamp, row))
        if isinstance(estimate, Reason):
            return self.account.close(estimate)
        motion = BaseMotion(estimate.stamp_ns, [*row, *estimate.values], estimate=estimate)
        self._motions.append(motion)
        return self.account.close(motion)

    def at(self, stamp_ns: int) -> BaseMotion | Reason:
        """Return the motion at an instant [ns], or why it is not known."""
        if not self._poses:
            return Reason.BASE_MISSING
        place = _nearest(self._poses, stamp_ns)
        if abs(stamp_ns - place.stamp_ns) > self._timeout_ns:
            return Reason.BASE_TOO_OLD
        if not self._motions:
            return Reason.SETTLING
        motion = _nearest(self._motions, stamp_ns)
        since = (stamp_ns - motion.stamp_ns) * 1e-9
        values: Sequence[float] = carry((
            *place.row, *motion.values[12:], (stamp_ns - place.stamp_ns) * 1e-9, since))
        if self.world == self._frames.base:     # there are no poses
            values = (*AT_REST[:12], *values[12:])
        return BaseMotion(stamp_ns, values, estimate=motion.estimate, since=since)

    def reset(self) -> None:
        """Forget all samples, as after a jump of the clock; counts stay."""
        self._estimator.reset()
        self._poses.clear()
        self._motions.clear()

    def problem(self) -> str:
        """Return what the base's messages lack, in words."""
        account = self.account
        if not account.received:
            return 'no message of the base came'
        if not account.refused:
            return f'{account.received} messages of the base came'
        return (f'{account.refused.total()} of {account.received} messages of the base were '
                f'refused, the latest as {account.latest}')

    def doubts(self) -> list[str]:
        """Return what the estimator finds odd about the samples, in sentences."""
        return [f'base: {doubt}' for doubt in self._estimator.doubts(COMPONENTS)]

    def faults(self) -> list[str]:
        """Return what is wrong with the messages, in sentences."""
        return self._watch.findings()

    def _strange(self, sample: BaseSample) -> tuple[Reason, str] | None:
        """Return a refusal if it is relative to another frame than those that still come."""
        world = self._frames.world_of(sample)
        if not self._poses or world == self.world or (
                abs(sample.stamp_ns - self._poses[-1].stamp_ns) >= self._timeout_ns):
            return None
        return Reason.BASE_FRAME, (f'frame_id is {world!r}; allowed: {self.world!r}, while '
                                   'messages in that come')


def _nearest(known: Sequence[Known], stamp_ns: int) -> Known:
    """Return what is known of the nearest instant; mostly it is the latest."""
    nearest = known[-1]
    for one in reversed(known):
        if abs(one.stamp_ns - stamp_ns) > abs(nearest.stamp_ns - stamp_ns):
            break
        nearest = one
    return nearest
