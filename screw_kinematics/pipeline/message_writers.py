# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
How a state becomes the bytes of a message.

Each class here writes one kind of message; all have the same ``encode``.
"""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from .kinematics import State
from .outputs import KINDS
from .own_motion import Felt, OwnMotion, Slices
from .payload import cross
from .robot_model import moving_joints, MovingJoint
from .settings import RobotSettings
from ..chains.covariance import through_jacobian
from ..messages.joint_motion import JointStateEncoder, JointTrajectoryEncoder
from ..messages.stamped import (
    ImuEncoder, PoseEncoder, TwistEncoder, TwistWithCovarianceEncoder, VelocityEncoder)
from ..motion.clock_error import Order
from ..screws.rotations import quaternion_from_row
from ..screws.se3 import Array, rotate, shift_pole


@dataclass(frozen=True)
class Frames:
    """Frame names in messages: of the base, of the tip, and of the vectors' axes."""

    base: str
    tip: str
    axes: str

    @classmethod
    def of(cls, model: Any, prefix: str, expressed_in: str, world: str = '') -> Frames:
        """Return the names for a model, with a prefix, and axes of the 'base' or 'tip'."""
        base, tip = world or prefix + model.base_frame, prefix + model.tip_frame
        return cls(base, tip, tip if expressed_in == 'tip' else base)


class JointColumns:
    """
    Where the joints of one tip are in a row of all measured joints' positions, velocities, ...

    Examples
    --------
    >>> JointColumns([2, 0], 3).select([0.1, 0.2, 0.3, 1.1, 1.2, 1.3], 1)
    [1.3, 1.1]

    """

    def __init__(self, columns: Sequence[int], count: int, moving_base: bool = False) -> None:
        self._moving_base = moving_base
        self.all = list(columns) == list(range(count))
        self._columns = columns
        self._count = count

    def select(self, row: Sequence[float], derivative: Order) -> Sequence[float]:
        """Return the tip's joints' positions (0), velocities (1), ..."""
        start = derivative * self._count
        if self.all:
            return row[start:start + self._count]
        return [row[start + column] for column in self._columns]

    def covariance(self, state: State, derivative: Order, jacobian: Sequence[float] | Array,
                   rates: Sequence[float] = ()) -> list[float]:
        """
        Return the covariance of what a Jacobian makes of a derivative of the joints' positions.

        Rates say by how much that changes in a second, the change of the Jacobian in it; used
        where the clock of the joints is not exact and the base does not move.
        """
        motion = state.motion
        variances = self.select(motion.variances, derivative)
        error = motion.clock_error
        together: list[list[float]] = []
        made: list[float] = []
        if error:
            onward = self.select(motion.values, derivative + 1) if state.order > derivative else ()
            late, fast = error.deviations(
                derivative, self.select(motion.values, derivative), onward)
            together = [late, fast] if late else [fast]
            if late and not self._moving_base:
                made = [error.time * rate for rate in rates]
        if self._moving_base:
            assert state.base is not None
            variances = [*variances, *state.base.variances(derivative)]
            together = [[*row, *(0.0,) * 6] for row in together]
        return through_jacobian(jacobian, variances, together, made)


class TwistRate:
    """By how much a twist's numbers change in a second, in its axes and about its point."""

    def __init__(self, slices: Slices, settings: RobotSettings) -> None:
        self._twist, self._accel = slices['twist'], slices['reduced_accel']
        # The reduced acceleration is the rate where axes and point are of one frame.
        self._swept = (settings.expressed_in == 'base') - (settings.reference_point == 'base')

    def of(self, values: Sequence[float]) -> list[float]:
        """Return the rates [rad/s^2, m/s^2]."""
        rates = [*values[self._accel]]
        if self._swept:
            twist = values[self._twist]
            for i, x in enumerate(cross(twist[:3], twist[3:])):
                rates[3 + i] += self._swept * x
        return rates


class MessageWriter(Protocol):
    """Writes states as messages of one output."""

    def encode(self, state: State) -> bytes:
        """Return the serialized message."""


def message_writer(output: str, slices: Slices, model: Any, settings: RobotSettings,
                   joints: JointColumns | None = None, world: str = '') -> MessageWriter:
    """
    Return what writes the messages of an output, any of KINDS but markers.

    Joints are needed if the robot has others than the model. The world, if given, takes the place
    of the base frame, as the motion is relative to it.
    """
    if joints is None:
        joints = JointColumns(range(len(model.joint_names)), len(model.joint_names),
                              settings.relative_to == 'world')
    kind = KINDS[output]
    frames = Frames.of(model, settings.frame_prefix, settings.expressed_in, world)
    if output == 'pose':
        return PoseWriter(slices['pose'], frames)
    if output == 'imu':
        return ImuWriter(slices, frames, settings, joints)
    if output in ('joint_motion', 'joint_states'):
        names, moving = moving_joints(model)
        encoder = JointTrajectoryEncoder if output == 'joint_motion' else JointStateEncoder
        return JointWriter(encoder(names), moving, joints, kind.order + 1)
    if output == 'passive_joint_states':
        return PassiveJointWriter(slices, JointStateEncoder(model.passive_joint_names))
    if kind.covariance:
        return CovarianceWriter(slices[kind.needs[0]], slices['jacobian'], kind.order, frames,
                                joints, TwistRate(slices, settings) if kind.order == 1 else None)
    if output == 'velocity':
        return SixVectorWriter(VelocityEncoder(
            frames.axes, frames.tip, frames.base, slices[kind.needs[0]].start))
    return SixVectorWriter(TwistEncoder(frames.axes, slices[kind.needs[0]].start))


class SixVectorWriter:
    """Twist, acceleration, jerk, ...: one six-vector."""

    def __init__(self, encoder: TwistEncoder | VelocityEncoder) -> None:
        self._encoder = encoder

    def encode(self, state: State) -> bytes:
        """Return the serialized message."""
        return self._encoder.encode(state.stamp_ns, state.values)


class PoseWriter:
    """The pose, whose rotation becomes a quaternion."""

    def __init__(self, at: slice, frames: Frames) -> None:
        self._at = at
        self._encoder = PoseEncoder(frames.base)

    def encode(self, state: State) -> bytes:
        """Return the serialized message."""
        pose = state.values[self._at]
        return self._encoder.encode(
            state.stamp_ns, (*pose[:3], *quaternion_from_row(pose[3:])))


class CovarianceWriter:
    """A six-vector and its covariance, from the joints' variances through the Jacobian."""

    def __init__(self, at: slice, jacobian: slice, order: int, frames: Frames,
                 joints: JointColumns, rate: TwistRate | None) -> None:
        self._at = at
        self._jacobian = jacobian
        self._order, self._joints, self._rate = order, joints, rate
        self._encoder = TwistWithCovarianceEncoder(frames.axes)

    def encode(self, state: State) -> bytes:
        """Return the serialized message."""
        rates = self._rate.of(state.values) if self._rate is not None else ()
        covariance = self._joints.covariance(
            state, self._order, state.values[self._jacobian], rates)
        return self._encoder.encode(state.stamp_ns, (*state.values[self._at], *covariance))


class JointWriter:
    """The joints' motion; those that mimic others follow them."""

    def __init__(self, encoder: JointStateEncoder | JointTrajectoryEncoder,
                 moving: Sequence[MovingJoint], joints: JointColumns, arrays: int) -> None:
        self._encoder = encoder
        self._moving = moving
        self._joints = joints
        self._arrays = arrays
        self._plain = joints.all and all(
            joint == MovingJoint(k, 1.0, 0.0) for k, joint in enumerate(moving))

    def encode(self, state: State) -> bytes:
        """Return the serialized message."""
        values = state.motion.values
        if not self._plain:
            own = [self._joints.select(values, k) for k in range(self._arrays)]
            values = [joint.of(own[k][joint.column], k)
                      for k in range(self._arrays) for joint in self._moving]
        return self._encoder.encode(state.stamp_ns, values)


class PassiveJointWriter:
    """Positions and velocities of the joints of a parallel robot that are not measured."""

    def __init__(self, slices: Slices, encoder: JointStateEncoder) -> None:
        self._position, self._velocity = (
            slices[need] for need in KINDS['passive_joint_states'].needs)
        self._encoder = encoder

    def encode(self, state: State) -> bytes:
        """Return the serialized message."""
        return self._encoder.encode(state.stamp_ns, (
            *state.values[self._position], *state.values[self._velocity]))


class ImuWriter:
    """What an inertial measurement unit at the tip would say, in the tip's axes."""

    def __init__(self, slices: Slices, frames: Frames, settings: RobotSettings,
                 joints: JointColumns) -> None:
        self._joints, self._settings = joints, settings
        self._pose, self._jacobian = slices['pose'], slices['jacobian']
        self._motion = OwnMotion(slices, settings, self._felt,
                                 self._jacobian.stop - self._jacobian.start)
        self._encoder = ImuEncoder(frames.tip)

    def encode(self, state: State) -> bytes:
        """Return the serialized message."""
        values, joints = state.values, self._joints
        felt = self._motion.of(values, values[self._jacobian])
        omega, alpha, force = felt[:3], felt[3:6], felt[6:9]
        middle = (9 + len(felt)) // 2
        turning, moving = felt[9:middle], felt[middle:]
        return self._encoder.encode(state.stamp_ns, [
            *quaternion_from_row(values[self._pose][3:]), *joints.covariance(state, 0, turning),
            *omega, *joints.covariance(state, 1, turning, alpha),
            *force, *joints.covariance(state, 2, moving)])

    def _felt(self, felt: Felt, jacobian: Array) -> list[Any]:
        """Return both angular rates, the specific force, and the Jacobian's rows as felt."""
        columns = jacobian.reshape(6, -1).T
        if self._settings.expressed_in == 'base':
            columns = rotate(felt.to_base.T, columns)
        if self._settings.reference_point == 'base':
            columns = shift_pole(columns, felt.place)
        return [*felt.omega, *felt.alpha, *felt.specific_force(self._settings.gravity),
                *columns.T.ravel()]
