# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Clocks and payload of a running system are found, and what is found mends the node's output."""
import subprocess
import sys
import time

from geometry_msgs.msg import WrenchStamped
import numpy as np
import pytest

pytest.importorskip('mujoco')
pytest.importorskip('rosbags')
pytest.importorskip('matplotlib')

import rclpy    # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile    # noqa: E402
from screw_kinematics.tools.check import main as check    # noqa: E402
from sensor_msgs.msg import JointState    # noqa: E402
from std_msgs.msg import String    # noqa: E402
from support import loaded_arm as arm    # noqa: E402
from support.rig import joint_state, wrench_stamped    # noqa: E402

START, STEP, OFFSET = 10**11, 4_000_000, 0.014


def published_while(context, *commands):
    """Publish joint states and wrenches, whose clock is apart, while tools run; return outputs."""
    node = rclpy.create_node('source', context=context)
    states = node.create_publisher(JointState, 'joint_states', 100)
    wrenches = node.create_publisher(WrenchStamped, 'ft', 100)
    description = node.create_publisher(String, 'robot_description', QoSProfile(
        depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
    description.publish(String(data=arm.urdf()))
    t = np.arange(0, 120, STEP * 1e-9)
    q, qd = arm.readings(t)
    shown = arm.wrenches(t, rng=np.random.default_rng(1))
    runs = [subprocess.Popen([sys.executable, '-m', 'screw_kinematics', *command],
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            for command in commands]
    for k in range(len(t)):
        stamp = START + k * STEP
        states.publish(joint_state(arm.NAMES, stamp, q[k], qd[k]))
        wrenches.publish(wrench_stamped(
            stamp - round(OFFSET * 1e9), shown[k], arm.FRAME))
        time.sleep(0.003)
        if all(run.poll() is not None for run in runs):
            break
    found = [run.communicate(timeout=120)[0] for run in runs]
    node.destroy_node()
    assert [run.returncode for run in runs] == [0] * len(runs), found
    return found


def test_check_delay_and_identify_of_a_running_system(context, tmp_path):
    picture = tmp_path / 'clocks.png'
    delay, out = published_while(
        context,
        ['check', 'delay', '--tip', 'tool0', '--against', 'ft', '--seconds', '15', '--plot',
         str(picture)],
        ['identify', 'payload', '--wrench', 'ft', '--seconds', '15', '--name', 'arm'])
    shown = float(delay.split('set robot.stamp_offset: ')[1].split(',')[0])
    assert shown == pytest.approx(-OFFSET, abs=2e-4)
    assert picture.read_bytes().startswith(b'\x89PNG')
    assert float(out.split('mass: ')[1].split()[0]) == pytest.approx(arm.BODY.mass, rel=0.01)
    assert float(out.split('stamp_offset: ')[1].split()[0]) == pytest.approx(-OFFSET, abs=2e-4)


@pytest.mark.parametrize('command, message', [
    (['--against', 'ft'], 'nobody publishes /ft, /joint_states, /robot_description; check topic'),
    (['--against', 'ft', '--seconds', '0'], "parameter 'seconds' is 0.0; allowed: more than 0"),
    (['--against', 'ft', '--plot', 'x.txt'], "'x.txt'; allowed: a file ending in .png")])
def test_nothing_to_listen_to_is_one_line(command, message, ros_domain, capsys):
    assert check.main(['delay', '--seconds', '0.5', *command]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count('\n') == 1, error
