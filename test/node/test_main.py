# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The process starts, ends cleanly on signals, and says in one line why it cannot start."""
import os
import random
import signal
import subprocess
import sys
import time

from geometry_msgs.msg import TwistStamped
import pytest
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from screw_kinematics.node.main import main
from sensor_msgs.msg import JointState

ARM = ('--ros-args', '-p', 'robots:=[arm]', '-p',
       'arm.description:=package://screw_kinematics/config/robots/rpr.yaml')
JOINTS = ['q1', 'q2', 'q3']


def start(*args):
    code = 'import sys; from screw_kinematics.node.main import main; sys.exit(main())'
    return subprocess.Popen(
        [sys.executable, '-c', code, *args], env=os.environ.copy(), text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE)


@pytest.mark.parametrize('kind', ['events', 'single_threaded'])
@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_signals_under_load_end_the_process_cleanly(context, wait_until, kind, number):
    """Input at some 1 kHz; the signal comes at a random moment."""
    node = Node('driver', context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    publisher = node.create_publisher(JointState, 'joint_states', QoSProfile(depth=10))
    outputs = []
    node.create_subscription(TwistStamped, 'arm/twist', outputs.append, 10)
    process = start(*ARM, '-p', f'executor:={kind}')

    def feed():
        message = JointState(name=JOINTS, position=[0.1, 0.2, 0.3])
        message.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(message)
        executor.spin_once(0.001)

    try:
        wait_until(lambda: len(outputs) > 20 or process.poll() is not None, poll=feed)
        for _ in range(random.Random(f'{kind} {number}').randrange(20)):
            feed()
        process.send_signal(number)
        wait_until(lambda: process.poll() is not None, poll=feed)
        _, errors = process.communicate(timeout=60)
    finally:
        process.kill()
    assert (process.returncode, 'Traceback' in errors) == (0, False), errors


@pytest.mark.parametrize('delay', [0.0, 0.1, 0.2, 0.4])
def test_signals_while_starting_end_the_process_cleanly(ros_domain, delay):
    # The first line tells that Python is up and the signals are taken.
    code = ('import sys\n'
            'from screw_kinematics.node import main, stop_request\n'
            'take = stop_request.StopRequest.take_signals\n'
            'def taken(self):\n'
            '    take(self); print("taken", flush=True)\n'
            'stop_request.StopRequest.take_signals = taken\n'
            'sys.exit(main.main())\n')
    with subprocess.Popen([sys.executable, '-c', code, *ARM], text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout.readline() == 'taken\n'
        time.sleep(delay)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    assert (process.returncode, 'Traceback' in errors) == (0, False), errors


@pytest.mark.parametrize('args, problem', [
    (['--ros-args', '-p', 'arm'], "override rule: '-p arm'"),
    (['--ros-args', '--params-file', 'missing.yaml'], 'missing.yaml'),
    (['--ros-args', '--wrong'], '--wrong'),
    (['--ros-args', '-p', 'use_sim_time:=often'], 'use_sim_time'),
    (['--ros-args', '-p', 'executor:=fast'],
     "parameter 'executor' is 'fast'; allowed: one of events, single_threaded"),
    (['--ros-args', '-p', 'robots:=[arm]', '-p', 'arm.description:=missing.urdf'],
     'missing.urdf'),
    ([*ARM, '-p', 'qos_overrides./arm/twist.publisher.reliability:=bad'],
     "parameter 'qos_overrides./arm/twist.publisher.reliability' is 'bad'; allowed: reliable"),
    ([*ARM, '-p', 'qos_overrides./arm/twist.publisher.depth:=-1'],
     'is -1; allowed: a whole number from 1'),
    ([*ARM, '-p', 'qos_overrides./joint_states.subscription.depth:=0'],
     'is 0; allowed: a whole number from 1'),
])
def test_what_keeps_it_from_starting_is_said_in_one_line(ros_domain, capfd, args, problem):
    assert main(['kinematic_state_publisher', *args]) == 1
    said = [line for line in capfd.readouterr().err.splitlines() if ' [rcl]: ' not in line]
    assert len(said) == 1 and said[0].startswith('kinematic_state_publisher: ')
    assert problem in said[0]


def test_help_tells_every_parameter(capsys):
    with pytest.raises(SystemExit) as ended:
        main(['kinematic_state_publisher', '--help'])
    assert ended.value.code == 0
    text = capsys.readouterr().out
    assert '\n  robots: ' in text and '\n  <robot>.estimator.delay: ' in text


def test_other_arguments_are_refused(capsys):
    with pytest.raises(SystemExit) as ended:
        main(['kinematic_state_publisher', 'arm.yaml'])
    assert ended.value.code == 2
    assert 'arm.yaml' in capsys.readouterr().err
