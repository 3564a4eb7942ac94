# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The outputs of a robot: the one table of what can be published, and what each needs."""
from __future__ import annotations

from typing import Any, NamedTuple


class OutputKind(NamedTuple):
    """A kind of topic."""

    type_name: str              # of the ROS message; recorded bags are read without ROS
    order: int                  # highest derivative of the joint positions in it
    needs: tuple[str, ...]      # outputs of the program; none: it is made of the joints' motion
    size: int = 6               # how many numbers a message ends with; 0: it is not so simple
    covariance: bool = False    # whether it needs the variances of the joints' motion


def _geometry(name: str, order: int, *needs: str, **more: Any) -> OutputKind:
    return OutputKind(f'geometry_msgs/msg/{name}Stamped', order, needs, **more)


KINDS = {
    'pose': _geometry('Pose', 0, 'pose', size=7),
    'twist': _geometry('Twist', 1, 'twist'),
    'accel': _geometry('Accel', 2, 'accel'),
    'reduced_accel': _geometry('Accel', 2, 'reduced_accel'),
    'jerk': _geometry('Accel', 3, 'jerk'),
    'snap': _geometry('Accel', 4, 'snap'),
    'velocity': _geometry('Velocity', 1, 'twist'),
    'twist_with_covariance': _geometry('TwistWithCovariance', 1, 'twist', 'jacobian',
                                       'reduced_accel', size=0, covariance=True),
    'accel_with_covariance': _geometry('AccelWithCovariance', 2, 'accel', 'jacobian', size=0,
                                       covariance=True),
    'imu': OutputKind('sensor_msgs/msg/Imu', 2, ('pose', 'twist', 'accel', 'jacobian'), size=0,
                      covariance=True),
    'compensated_wrench': _geometry('Wrench', 2, 'pose', 'twist', 'accel', size=0),
    'joint_motion': OutputKind('trajectory_msgs/msg/JointTrajectory', 2, (), size=0),
    'joint_states': OutputKind('sensor_msgs/msg/JointState', 1, (), size=0),
    'markers': OutputKind('visualization_msgs/msg/MarkerArray', 2,
                          ('pose', 'twist', 'reduced_accel'), size=0),
    'passive_joint_states': OutputKind('sensor_msgs/msg/JointState', 1,
                                       ('passive_position', 'passive_velocity'), size=0),
}

UNCERTAIN_MARKERS = KINDS['markers']._replace(
    needs=(*KINDS['markers'].needs, 'jacobian'), covariance=True)
"""Markers with ellipsoids."""

OUTPUTS = tuple(KINDS)

RECORDED = {name: kind.size for name, kind in KINDS.items() if kind.size}
"""Outputs that recordings hold too, and how many numbers a message of each ends with."""
