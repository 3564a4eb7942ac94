# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The launch files, included in one's own as users do, start what they say (needs launch_ros)."""
from contextlib import contextmanager
import importlib.util
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

import pytest

pytest.importorskip('launch_ros')
from geometry_msgs.msg import AccelStamped, TwistStamped    # noqa: E402, I100
from lifecycle_msgs.srv import GetState    # noqa: E402
from nav_msgs.msg import Odometry    # noqa: E402
import rclpy    # noqa: E402
from support.rig import joint_state, KEEP, LIMIT, PUMA, smooth_motion    # noqa: E402
from visualization_msgs.msg import MarkerArray    # noqa: E402

ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / 'launch').glob('*.launch.py'))
OWN = """
import sys
from launch import LaunchDescription, LaunchService
from launch.actions import IncludeLaunchDescription, SetLaunchConfiguration
service = LaunchService(noninteractive=True)     # no terminal sends Ctrl-C to all
service.include_launch_description(LaunchDescription([
    # Nothing is killed because the machine is busy.
    SetLaunchConfiguration('sigterm_timeout', '60'),
    SetLaunchConfiguration('sigkill_timeout', '60'),
    IncludeLaunchDescription(
        sys.argv[1], launch_arguments=[word.split(':=', 1) for word in sys.argv[2:]])]))
sys.exit(service.run())
"""


@pytest.fixture
def prefix(tmp_path, monkeypatch):
    """Lay this checkout out as colcon installs it, and let ROS find it."""
    share, lib = tmp_path / 'share/screw_kinematics', tmp_path / 'lib/screw_kinematics'
    marker = tmp_path / 'share/ament_index/resource_index/packages/screw_kinematics'
    for folder in (share, lib, marker.parent):
        folder.mkdir(parents=True)
    marker.touch()
    for name in ('config', 'launch'):
        (share / name).symlink_to(ROOT / name)
    for name, module in (('kinematic_state_publisher', 'node.main'),
                         ('joint_state_source', 'tools.joint_state_source.main')):
        (lib / name).write_text(
            f'#!/bin/sh\nexec {sys.executable} -m screw_kinematics.{module} "$@"\n')
        (lib / name).chmod(0o755)
    monkeypatch.setenv('AMENT_PREFIX_PATH', os.pathsep.join(
        [str(tmp_path), *filter(None, [os.environ.get('AMENT_PREFIX_PATH')])]))
    monkeypatch.setenv('PYTHONPATH', str(ROOT), prepend=os.pathsep)
    return tmp_path


@pytest.fixture
def launched(context, prefix):
    """Give a function that launches a file, and a node here that talks to what it starts."""
    node = rclpy.create_node('listener', context=context)

    @contextmanager
    def launch(name, *arguments):
        log = prefix / 'log.txt'
        with open(log, 'w') as file:
            process = subprocess.Popen(
                [sys.executable, '-c', OWN, str(ROOT / 'launch' / name), *arguments],
                stdout=file, stderr=subprocess.STDOUT)

        def wait(condition):
            deadline = time.monotonic() + LIMIT
            while not condition():
                assert process.poll() is None and time.monotonic() < deadline, log.read_text()
                executor.spin_once(0.05)

        executor = rclpy.executors.SingleThreadedExecutor(context=context)
        executor.add_node(node)
        try:
            yield node, wait
            process.send_signal(signal.SIGINT)
            assert process.wait(LIMIT) == 0
        finally:
            process.kill()
        text = log.read_text()
        assert 'Traceback' not in text and 'process has died' not in text, text
        assert text.count('process started') == text.count('process has finished cleanly') > 0
    yield launch
    node.destroy_node()


def listen(node, kind, topic):
    """Return the list of messages that will arrive."""
    messages = []
    node.create_subscription(kind, topic, messages.append, KEEP)
    return messages


def feed(node, topic, names, wait, until):
    """Publish a motion of joints until something has come."""
    publisher = node.create_publisher(type(joint_state(names, 0, [])), topic, KEEP)
    wait(lambda: publisher.get_subscription_count() > 0)

    def fed():
        now = node.get_clock().now().nanoseconds
        publisher.publish(joint_state(names, now, *smooth_motion(len(names), now * 1e-9 % 1000)))
        return until()
    wait(fed)


JOINTS = tuple(f'q{i}' for i in range(1, 7))


def test_the_demo_moves_and_is_measured(launched):
    with launched('demo.launch.py', 'rate:=200.0', 'rviz:=false') as (node, wait):
        accels = listen(node, AccelStamped, '/robot/accel')
        markers = listen(node, MarkerArray, '/robot/markers')
        wait(lambda: len(accels) > 20 and markers)
    assert accels[0].header.frame_id == 'base'


def test_a_robot_by_arguments(launched):
    with launched('kinematic_states.launch.py', f'description:={PUMA}', 'robot:=arm',
                  'outputs:=twist', 'namespace:=cell', 'frame_prefix:=left_', 'delay:=0.02',
                  'joint_states_topic:=measured,more') as (node, wait):
        twists = listen(node, TwistStamped, '/cell/arm/twist')
        feed(node, '/cell/measured', JOINTS, wait, lambda: twists)
    assert twists[0].header.frame_id == 'left_base'


def test_robots_by_a_file(launched):
    file = ROOT / 'config' / 'kinematic_states.yaml'
    with launched('kinematic_states.launch.py', f'params_file:={file}') as (node, wait):
        accels = listen(node, AccelStamped, '/puma/accel')
        feed(node, '/joint_states', JOINTS, wait, lambda: accels)


def test_a_manager_may_activate_the_node(launched):
    with launched('kinematic_states.launch.py', f'description:={PUMA}',
                  'autostart:=false') as (node, wait):
        client = node.create_client(GetState, '/kinematic_state_publisher/get_state')
        wait(client.service_is_ready)
        answer = client.call_async(GetState.Request())
        wait(answer.done)
    assert answer.result().current_state.label == 'unconfigured'


@pytest.mark.parametrize('file', FILES, ids=lambda file: file.name)
def test_arguments_are_described(file, prefix):
    spec = importlib.util.spec_from_file_location('launch_file', file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    arguments = module.generate_launch_description().get_launch_arguments()
    assert {'description', 'base_frame', 'tip_frame', 'namespace', 'rviz'} \
        <= {argument.name for argument in arguments}
    for argument in arguments:
        assert len(argument.description) > 10 and argument.default_value is not None


def test_a_word_that_is_neither_true_nor_false_is_refused(prefix):
    run = subprocess.run([sys.executable, '-c', OWN, str(FILES[-1]), 'use_sim_time:=maybe'],
                         capture_output=True, text=True)
    assert run.returncode == 1
    assert 'provided value "maybe" is not valid' in run.stdout + run.stderr


def test_a_base_that_drives_is_an_argument(launched):
    with launched('kinematic_states.launch.py', 'robot:=arm', f'description:={PUMA}',
                  'base_motion_topic:=odom') as (node, wait):
        twists = listen(node, TwistStamped, 'arm/twist')
        base = node.create_publisher(Odometry, 'odom', KEEP)

        def driven():
            message = Odometry(child_frame_id='base')
            message.header.frame_id = 'odom'
            message.header.stamp = node.get_clock().now().to_msg()
            message.pose.pose.orientation.w = 1.0
            message.twist.twist.linear.x = 0.5
            base.publish(message)
            return bool(twists)
        feed(node, 'joint_states', JOINTS, wait, driven)
        assert twists[-1].header.frame_id == 'odom'
