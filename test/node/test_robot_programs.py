# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Another set of listeners means another program, which goes on where the last one was."""
from geometry_msgs.msg import PoseStamped, TwistStamped
import numpy as np
import pytest
import rclpy
from screw_kinematics import models
from screw_kinematics.messages.joint_state import JointSample
from screw_kinematics.node.parameters import NodeParameters
from screw_kinematics.node.robot import Robot
from screw_kinematics.node.worker import Worker
from screw_kinematics.pipeline.outputs import KINDS

PLANAR = 'package://screw_kinematics/config/robots/planar_3rrr.yaml'


def beyond_a_singularity():
    """Return a posture in the assembly mode that is not the home's, 0.5 rad away from it."""
    planar = models.load(PLANAR)
    posture = planar.home
    for yaw in np.linspace(0, -1, 11):
        pose = np.eye(4)
        pose[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
        posture = planar.posture_at(pose, posture)
    return posture


@pytest.fixture
def planar(context):
    """Give a node and its planar robot, both driven by hand."""
    node = rclpy.create_node('programs', context=context)
    parameters = NodeParameters(node)
    parameters.declare_robot('planar')
    worker = Worker()
    robot = Robot(node, parameters.robot_settings('planar', {
        'planar.description': PLANAR, 'planar.outputs': ['pose', 'twist'],
        'planar.velocity_source': 'measured'}), worker)
    robot.load_from_parameter()
    yield node, robot, worker
    worker.close()
    robot.close()
    node.destroy_node()


def test_far_from_home_in_another_assembly_mode(planar, wait_until):
    node, robot, worker = planar
    start = beyond_a_singularity()
    samples = enumerate(np.linspace(0.001, 0.02, 4), start=1000)

    def check_next_sample():
        k, shift = next(samples)
        q = start.actuated + shift
        robot.take(JointSample(k * 10**7, robot.model.joint_names, q.tolist(), (0.0,) * 3))
        assert robot.account.refused.total() == 0
        found = robot._program.program.posture.pose
        np.testing.assert_allclose(found, robot.model.posture(q, start).pose, atol=1e-12)
        assert np.abs(found - robot.model.posture(q).pose).max() > 0.1

    def wait_for(*wanted):
        def there():
            robot.update_demand(0.0)
            worker.collect()
            return tuple(robot.publishers.wanted_names) == wanted and worker.pending == 0
        wait_until(there)

    def listen(kind, topic):
        return node.create_subscription(kind, topic, lambda message: None, 10)

    subscriptions = [listen(PoseStamped, 'planar/pose')]
    wait_for('pose')
    robot._program.program.posture = start
    check_next_sample()
    subscriptions += [listen(TwistStamped, 'planar/twist')]
    wait_for(*[name for name in KINDS if name in ('pose', 'twist')])
    check_next_sample()
    node.destroy_subscription(subscriptions.pop())
    wait_for('pose')
    check_next_sample()
    node.destroy_subscription(subscriptions.pop())
    wait_for()
    listen(TwistStamped, 'planar/twist')
    wait_for('twist')
    check_next_sample()
