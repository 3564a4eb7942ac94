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
from std_msgs.msg import String

pytest.importorskip('viser')

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


def test_the_demo_offers_the_page(ros_domain):
    with closing(socket.socket()) as probe:
        probe.bind(('127.0.0.1', 0))
        port = probe.getsockname()[1]
    run = subprocess.Popen(
        [sys.executable, '-u', '-m', 'screw_kinematics.tools.demo.main', '--view', '--port',
         str(port), '--duration', '5'], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
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
