# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The view of running processes: the node's states, beside the truth, on a page."""
import argparse
from contextlib import closing
import socket
import subprocess
import sys
import urllib.request

from geometry_msgs.msg import AccelStamped, TwistStamped
import numpy as np
import pytest
import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import String

pytest.importorskip('viser')

from screw_kinematics import models    # noqa: E402
from screw_kinematics.tools import stage    # noqa: E402
from screw_kinematics.tools.processes import Children    # noqa: E402
from screw_kinematics.tools.view.live import LiveRobots, look_around    # noqa: E402
from screw_kinematics.tools.view.motion import ShownMotion    # noqa: E402

LIMIT = 120.0    # s; the machine may be busy


def settled(snapshots):
    """Return those a second after the start, and after each time the machine stood still."""
    found, begin, last = [], None, -1.0
    for snapshot in snapshots:
        if begin is None or snapshot.time - last > 0.4:
            begin = snapshot.time
        last = snapshot.time
        if last - begin > 1.0:
            found.append(snapshot)
    return found


def test_states_of_the_node_are_near_the_truth(ros_domain):
    options = argparse.ArgumentParser()
    stage.add_options(options)
    played = stage.Stage(options.parse_args(['--motion', 'multisine', '--rate', '200',
                                             '--delay', '0.02']))
    motion = ShownMotion(played.name, played.robot)
    with Children() as children:
        played.run(children)
        with LiveRobots([motion], [['joint_states']], played.namespace, played.exact) as robots:
            for _ in range(int(LIMIT / 0.05)):
                robots.listen(0.05)
                children.check()
                if len(settled(motion.snapshots)) > 20:
                    break
    assert len(settled(motion.snapshots)) > 20 and not robots.silent()
    found = settled(motion.snapshots)
    for order, (kind, bound) in enumerate([('twist', 2e-3), ('accel', 0.1)]):
        errors = [np.abs(getattr(s, kind) - s.exact[order]).max() for s in found]
        # All but some, since a machine that has other work loses joint states.
        assert np.quantile(errors, 0.8) < bound, kind
    times = [snapshot.time for snapshot in motion.snapshots]
    assert times == sorted(set(times))


@pytest.mark.parametrize('prefix', ['', 'left_'])
@pytest.mark.parametrize('axes', ['base', 'tip'])
def test_vectors_are_drawn_in_axes_of_the_base(ros_domain, context, axes, prefix):
    """As each header says whose axes they are in."""
    robot = models.load('package://screw_kinematics/config/robots/puma560.yaml')
    q = np.array([0.3, -0.7, 0.4, 0.9, 0.6, -0.2])
    turn = robot.state(q).pose[:3, :3] if axes == 'tip' else np.eye(3)
    node = rclpy.create_node('cell', context=context)
    joints, twist, accel = JointState(name=robot.joint_names, position=q), TwistStamped(), \
        AccelStamped()
    twist.header.frame_id = accel.header.frame_id = prefix + (
        robot.tip_frame if axes == 'tip' else robot.base_frame)
    for vectors, first in ((twist.twist, 1.0), (accel.accel, -4.0)):
        for k, vector in enumerate((vectors.angular, vectors.linear)):
            vector.x, vector.y, vector.z = turn.T @ (first + 3 * k + np.arange(3))
    publishers = [(node.create_publisher(type(message), topic, 1), message) for topic, message in (
        ('joint_states', joints), ('arm/twist', twist), ('arm/accel', accel))]
    motion = ShownMotion('arm', robot)
    with LiveRobots([motion], [['joint_states']], '') as robots:
        for _ in range(int(LIMIT / 0.05)):
            for publisher, message in publishers:
                publisher.publish(message)
            robots.listen(0.05)
            if motion.snapshots:
                break
    np.testing.assert_allclose(motion.snapshots[0].twist, np.arange(1.0, 7.0), atol=1e-12)
    np.testing.assert_allclose(motion.snapshots[0].accel, np.arange(-4.0, 2.0), atol=1e-12)
    node.destroy_node()


def test_the_demo_offers_the_page(ros_domain):
    with closing(socket.socket()) as probe:
        probe.bind(('127.0.0.1', 0))
        port = probe.getsockname()[1]
    run = subprocess.Popen(
        [sys.executable, '-u', '-m', 'screw_kinematics', 'demo', '--view', '--port', str(port),
         '--duration', '2'], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    for line in run.stdout:
        if line.startswith(f'http://127.0.0.1:{port} shows puma560'):
            break
    page = urllib.request.urlopen(f'http://127.0.0.1:{port}', timeout=30).read()
    assert b'<html' in page.lower()
    _, error = run.communicate(timeout=LIMIT)
    assert run.returncode == 0, error


def test_robots_are_found_by_their_topics_and_descriptions(ros_domain, context):
    """What runs, without a file: names from the topics, the model from robot_description."""
    node = rclpy.create_node('cell', context=context)
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    description = node.create_publisher(String, '/cell/robot_description', latched)
    description.publish(String(data='<robot name="r"/>'))
    kept = [node.create_publisher(kind, f'/cell/{name}/{output}', 1)
            for name in ('left', 'right') for output, kind in (('twist', TwistStamped),
                                                               ('accel', AccelStamped))]
    kept.append(node.create_publisher(TwistStamped, '/cell/cart/twist', 1))
    names, texts = look_around('cell', {'/cell/robot_description'}, 20.0)
    assert names == ['left', 'right'] and len(kept) == 5
    assert texts == {'/cell/robot_description': '<robot name="r"/>'}
    node.destroy_node()
