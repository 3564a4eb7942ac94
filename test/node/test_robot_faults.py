# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A defect met in one robot is counted and told, and does not reach the others."""
import rclpy
from screw_kinematics.errors import Reason
from screw_kinematics.messages.joint_state import JointSample
from screw_kinematics.node.parameters import NodeParameters
from screw_kinematics.node.robot import Robot
from screw_kinematics.node.worker import Worker
from screw_kinematics.pipeline.kinematics import Kinematics
from support.rig import PUMA


class Defective:
    """A program with a defect."""

    order, dof, moving_base, standing_base = 0, 6, False, True

    @staticmethod
    def evaluate(values):
        raise TypeError('a defect')


def test_a_defect_is_a_counted_refusal(context):
    node = rclpy.create_node('faults', context=context)
    parameters = NodeParameters(node)
    parameters.declare_robot('arm')
    robot = Robot(node, parameters.robot_settings('arm', {'arm.description': PUMA}),
                  Worker())
    robot.load_from_parameter()
    robot.pipeline.activate(Kinematics(Defective()))
    for k in range(20):
        robot.take(JointSample(
            10**9 + k * 10**7, robot.pipeline.joint_names, (0.1,) * 6, ()))
    account = robot.account
    assert account.refused[Reason.INTERNAL_ERROR] > 0
    assert account.received == account.used + account.refused.total() == 20
    assert 'a defect' in account.details[Reason.INTERNAL_ERROR]
    node.destroy_node()
