# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The topics of one robot: what each needs computed, and how its messages are made."""
from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any, NamedTuple

from ..chains.covariance import through_jacobian
from ..messages.stamped import (
    AccelEncoder, PoseEncoder, TwistEncoder, TwistWithCovarianceEncoder, VelocityEncoder)
from ..screws.rotations import quaternion_from_row

Values = Sequence[float]
Slices = dict[str, slice]
Send = Callable[[int, Values], None]
Variances = Callable[[int], Sequence[float]]


class OutputKind(NamedTuple):
    """
    A kind of topic.

    Attributes
    ----------
    type_name : str
        Name of the ROS message type; recorded bags are read without ROS.
    needs : tuple of str
        Outputs of the compiled program it is made from.
    derivative : int
        Derivative of the joint positions whose variance it needs; 0: none.

    """

    type_name: str
    needs: tuple[str, ...]
    derivative: int = 0

    @property
    def message(self) -> Any:
        """Return the ROS message type."""
        package, folder, name = self.type_name.split('/')
        return getattr(import_module(f'{package}.{folder}'), name)


KINDS = {
    'pose': OutputKind('geometry_msgs/msg/PoseStamped', ('pose',)),
    'twist': OutputKind('geometry_msgs/msg/TwistStamped', ('twist',)),
    'accel': OutputKind('geometry_msgs/msg/AccelStamped', ('accel',)),
    'reduced_accel': OutputKind('geometry_msgs/msg/AccelStamped', ('reduced_accel',)),
    'jerk': OutputKind('geometry_msgs/msg/AccelStamped', ('jerk',)),
    'snap': OutputKind('geometry_msgs/msg/AccelStamped', ('snap',)),
    'velocity': OutputKind('geometry_msgs/msg/VelocityStamped', ('twist',)),
    'twist_with_covariance': OutputKind(
        'geometry_msgs/msg/TwistWithCovarianceStamped', ('twist', 'jacobian'), derivative=1),
    'accel_with_covariance': OutputKind(
        'geometry_msgs/msg/AccelWithCovarianceStamped', ('accel', 'jacobian'), derivative=2),
    'markers': OutputKind('visualization_msgs/msg/MarkerArray',
                          ('pose', 'twist', 'reduced_accel')),
    'passive_joint_states': OutputKind('sensor_msgs/msg/JointState',
                                       ('passive_position', 'passive_velocity')),
}


RECORDED = {name: 7 if name == 'pose' else 6 for name, kind in KINDS.items()
            if kind.derivative == 0 and name not in ('markers', 'passive_joint_states')}
"""Outputs that recordings hold too, and how many numbers a message of each ends with."""


class Frames(NamedTuple):
    """Frame names in messages: of the base, of the tip, and of the vectors' axes."""

    base: str
    tip: str
    axes: str


def make_send(output: str, publish: Callable[[bytes], None], slices: Slices, frames: Frames,
              variances: Variances) -> Send:
    """
    Return the function that publishes one output from the values of the program.

    Parameters
    ----------
    output : str
        Any of KINDS but markers and passive joint states.
    publish : callable
        Takes a serialized message.
    slices : dict from str to slice
        Where the program's outputs are among the values.
    frames : Frames
        Frame names for the messages.
    variances : callable
        From a derivative to the variance of each joint.

    Returns
    -------
    callable
        Takes the stamp [ns] and the values of the program.

    """
    kind = KINDS[output]
    at = slices[kind.needs[0]]
    if output == 'pose':
        return _send_pose(publish, at, PoseEncoder(frames.base).encode)
    if kind.derivative:
        return _send_with_covariance(
            publish, at, slices['jacobian'], kind.derivative, variances,
            TwistWithCovarianceEncoder(frames.axes).encode)
    if kind.type_name.endswith('/TwistStamped'):
        encode = TwistEncoder(frames.axes).encode
    elif kind.type_name.endswith('/AccelStamped'):
        encode = AccelEncoder(frames.axes).encode
    else:
        encode = VelocityEncoder(frames.axes, frames.tip, frames.base).encode

    def send(stamp_ns: int, values: Values) -> None:
        publish(encode(stamp_ns, values[at]))
    return send


def send_joint_states(publish: Callable[[Any], None], slices: Slices,
                      joint_names: Sequence[str]) -> Send:
    """Return the function that publishes the passive joints from the program's values."""
    position, velocity = (slices[need] for need in KINDS['passive_joint_states'].needs)
    message = KINDS['passive_joint_states'].message(name=list(joint_names))

    def send(stamp_ns: int, values: Values) -> None:
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 10**9)
        message.position = list(values[position])
        message.velocity = list(values[velocity])
        publish(message)
    return send


def _send_pose(publish: Callable[[bytes], None], at: slice,
               encode: Callable[[int, Values], bytes]) -> Send:
    def send(stamp_ns: int, values: Values) -> None:
        pose = values[at]
        publish(encode(stamp_ns, (*pose[:3], *quaternion_from_row(pose[3:]))))
    return send


def _send_with_covariance(publish: Callable[[bytes], None], at: slice, jacobian: slice,
                          derivative: int, variances: Variances,
                          encode: Callable[[int, Values], bytes]) -> Send:
    def send(stamp_ns: int, values: Values) -> None:
        covariance = through_jacobian(values[jacobian], variances(derivative))
        publish(encode(stamp_ns, (*values[at], *covariance)))
    return send
