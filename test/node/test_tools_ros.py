# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Tools against a real ROS: a running system is checked, and ROS reads what they write."""
import os
from pathlib import Path
import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip('rosbags')
rclpy = pytest.importorskip('rclpy')

from rosbags.rosbag2 import Reader, StoragePlugin, Writer    # noqa: E402
from rosbags.typesys import get_typestore, Stores    # noqa: E402
from screw_kinematics.pipeline.outputs import RECORDED    # noqa: E402
from screw_kinematics.node.publishers import message_type    # noqa: E402
from screw_kinematics.pipeline.outputs import KINDS    # noqa: E402
from screw_kinematics.tools.bag import main as bag    # noqa: E402
from screw_kinematics.tools.check import main as check    # noqa: E402
from sensor_msgs.msg import JointState    # noqa: E402

ROBOTS = Path(__file__).parents[2] / 'config' / 'robots'
RPR = str(ROBOTS / 'rpr.yaml')


@pytest.fixture
def source(context, wait_until):
    """Run a publisher of the planar arm's joint states."""
    run = subprocess.Popen(
        [sys.executable, '-m', 'screw_kinematics.tools.joint_state_source.main', '--robot', RPR,
         '--motion', 'multisine', '--namespace', '/lab'], env=dict(os.environ))
    node = rclpy.create_node('waiting', context=context)
    wait_until(lambda: node.count_publishers('/lab/joint_states'))
    node.destroy_node()
    yield run
    run.terminate()
    assert run.wait(60) == 0


def test_a_running_system_is_sound(source, capsys):
    assert check.main(['system', '--robot', RPR, '--namespace', 'lab', '--seconds', '8']) == 0
    out = capsys.readouterr().out
    assert '/lab/joint_states: published by joint_state_source' in out
    assert 'measured joints, which must be published: q1' in out
    assert 'kinematic_state_publisher runs: no' in out


def test_a_silent_system_is_a_problem(ros_domain, capsys):
    assert check.main(['system', '--robot', RPR, '--seconds', '0.5']) == 1
    assert '/joint_states: nobody publishes it' in capsys.readouterr().out


def test_ros_reads_the_messages_of_a_bag(tmp_path):
    from rclpy.serialization import deserialize_message, serialize_message
    kind = 'sensor_msgs/msg/JointState'
    types = get_typestore(Stores.ROS2_JAZZY)
    with Writer(tmp_path / 'run', version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection('/joint_states', kind, typestore=types)
        for k in range(100):
            message = JointState(name=['q3', 'q1', 'q2'], position=[0.1 * k * 0.01, 0.0, 0.2])
            message.header.stamp.sec, message.header.stamp.nanosec = 5, k * 10_000_000
            writer.write(connection, k, serialize_message(message))
    assert bag.main([str(tmp_path / 'run'), '--robot', RPR, '--outputs', ','.join(RECORDED),
                     '--output', str(tmp_path / 'out')]) == 0
    counts = dict.fromkeys(RECORDED, 0)
    with Reader(tmp_path / 'out') as reader:
        for connection, _, data in reader.messages():
            output = connection.topic.rpartition('/')[2]
            message = deserialize_message(data, message_type(KINDS[output].type_name))
            assert message.header.frame_id == 'base' and message.header.stamp.sec == 5
            if output == 'twist':
                angular = message.twist.angular
                np.testing.assert_allclose([angular.x, angular.y, angular.z], [0, 0, 0.1],
                                           atol=1e-6)
            counts[output] += 1
    assert set(counts.values()) == {100}
