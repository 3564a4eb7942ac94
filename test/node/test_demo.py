# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The demo as a user runs it: real node, real joint states, nothing left behind."""
import os
from pathlib import Path
import re
import signal
import subprocess
import sys

import pytest

from screw_kinematics.tools.joint_state_source import main as joint_state_source
from screw_kinematics.tools.demo import main as demo

ROBOTS = Path(__file__).parents[2] / 'config' / 'robots'
LIMIT = 120.0    # s; the machine may be busy


@pytest.fixture
def namespace(ros_domain):
    """Return a ROS namespace by which the demo's processes can be recognised."""
    return f'demo_{os.getpid()}_{ros_domain}'


def processes(namespace):
    """Return the ids of the node and the joint state publisher of a demo."""
    found = []
    for entry in Path('/proc').iterdir():
        try:
            command = (entry / 'cmdline').read_text() if entry.name.isdigit() else ''
            if f'/{namespace}' in command:
                found.append(int(entry.name))
        except OSError:    # ended meanwhile
            pass
    return found


def start(namespace, *arguments):
    """Start a demo whose output is read by the test."""
    return subprocess.Popen(
        [sys.executable, '-u', '-m', 'screw_kinematics', 'demo', '--namespace', namespace,
         *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def numbers(text, quantity, name):
    """Return the values in one line of ``--once``."""
    block = text[text.index(f'\n{quantity}'):]
    line = re.search(rf'^ +{name} +(.*)$', block, re.MULTILINE)
    return [float(word) for word in line[1].split()]


def assert_near_the_exact_state(out):
    """Compare what ``--once`` prints with the exact state beside it."""
    assert 'axes of' in out and 'reference point: origin of' in out
    for quantity, bound in (('position p [m]', 1e-5), ('linear velocity v [m/s]', 1e-3),
                            ('linear acceleration a [m/s2]', 0.05)):
        assert max(map(abs, numbers(out, quantity, 'error'))) < bound
        assert any(numbers(out, quantity, 'exact'))


@pytest.mark.parametrize('options', [
    ['--robot', str(ROBOTS / 'panda.yaml'), '--motion', 'multisine', '--rate', '500',
     '--delay', '0.02'],
    ['--robot', str(ROBOTS / 'stewart_6ups.yaml')],
])
def test_once_prints_a_state_near_the_exact_one(namespace, options):
    run = start(namespace, '--once', *options)
    out, error = run.communicate(timeout=LIMIT)
    assert run.returncode == 0, error
    assert_near_the_exact_state(out)
    assert not processes(namespace)


def test_two_demos_without_options_do_not_mix(ros_domain):
    arguments = [sys.executable, '-m', 'screw_kinematics', 'demo', '--once']
    runs = [subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    for run in runs:
        out, _ = run.communicate(timeout=2 * LIMIT)
        assert run.returncode == 0
        assert_near_the_exact_state(out)


def test_plain_lines_into_a_pipe_and_ctrl_c(namespace):
    run = start(namespace)
    first, second = run.stdout.readline(), run.stdout.readline()
    assert first.startswith('t = ') and 'alpha = (' in first and 'rad/s2' in first
    assert '\x1b' not in first + second    # no control sequences outside a terminal
    assert len(processes(namespace)) == 2
    run.send_signal(signal.SIGINT)
    _, error = run.communicate(timeout=LIMIT)
    assert run.returncode == 0 and error == ''
    assert not processes(namespace)


def test_nothing_is_left_when_the_demo_is_killed(namespace, wait_until):
    run = start(namespace)
    assert run.stdout.readline()
    assert len(processes(namespace)) == 2
    run.kill()
    run.communicate()
    wait_until(lambda: not processes(namespace), timeout=LIMIT)


def test_the_demo_ends_if_its_node_does(namespace):
    run = start(namespace)
    assert run.stdout.readline()
    node, = (pid for pid in processes(namespace)
             if 'screw_kinematics.node.main' in Path(f'/proc/{pid}/cmdline').read_text())
    os.kill(node, signal.SIGKILL)
    _, error = run.communicate(timeout=LIMIT)
    assert run.returncode == 2
    assert error == 'screw-kinematics demo: the node ended with exit code -9: no output\n'
    assert not processes(namespace)


@pytest.mark.parametrize('options, message', [
    (['--robot', 'no_such.yaml'], 'no_such.yaml'),
    (['--rate', '0'], "'rate' is 0.0; allowed: more than 0"),
    (['--delay', '-1'], "'delay' is -1.0; allowed: 0 to 1 s"),
    (['--seconds', '-1'], "'seconds' is -1.0; allowed: more than 0"),
    (['--duration', 'nan'], "'seconds' is nan; allowed: more than 0"),
    (['--namespace', '1 2'], "'namespace' is '1 2'; allowed: letters, digits"),
])
def test_wrong_options_are_one_line(capsys, options, message):
    assert demo.main(options) == 2
    error = capsys.readouterr().err
    assert error.count('\n') == 1 and message in error


@pytest.mark.parametrize('options, message', [
    (['--topic', 'a b'], "'topic' is 'a b'; allowed: letters, digits"),
    (['--start', str(10**20)], "'start' is 100000000000000000000; allowed: 0 to 2.14748e+18 ns"),
    (['--namespace', '1 2'], "'namespace' is '1 2'; allowed: letters, digits"),
])
def test_wrong_names_of_the_source_are_one_line(capsys, options, message):
    assert joint_state_source.main(options) == 2
    error = capsys.readouterr().err
    assert error.count('\n') == 1 and message in error


@pytest.mark.parametrize('words, message', [
    (['-p', 'use_sim_time:=abc'], "Trying to set parameter 'use_sim_time' to 'abc'"),
    (['-r', 'bad'], "Couldn't parse remap rule: '-r bad'"),
])
def test_the_source_gets_the_arguments_of_ros_by_the_one_command(words, message):
    """Those that are wrong are told; those that are right were passed over, too."""
    found = subprocess.run(
        [sys.executable, '-m', 'screw_kinematics', 'joint_state_source', '--ros-args', *words],
        capture_output=True, text=True, timeout=LIMIT)
    assert found.returncode == 2 and message in found.stderr.splitlines()[-1]


def test_without_ros_the_extra_is_named():
    run = subprocess.run(
        [sys.executable, '-c', 'import sys; sys.modules["rclpy"] = None\n'
         'from screw_kinematics.tools.demo.main import main; sys.exit(main([]))'],
        capture_output=True, text=True)
    assert run.returncode == 2
    assert run.stderr.count('\n') == 1
    assert "pip install 'screw_kinematics[ros]'" in run.stderr
