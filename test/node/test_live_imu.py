# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""An IMU on the tip of a running arm, over DDS: its clock, how it is mounted, its noise."""
import re
import subprocess
import sys
import time

import numpy as np
import pytest

pytest.importorskip('rosbags')

import rclpy    # noqa: E402
from screw_kinematics import models    # noqa: E402
from screw_kinematics.screws.rotations import rotation_rpy, rotation_vector    # noqa: E402
from screw_kinematics.tools import robot_options    # noqa: E402
from sensor_msgs.msg import Imu, JointState    # noqa: E402
from support.rig import joint_state, PUMA    # noqa: E402

ARM = models.load(PUMA)
MOTION = robot_options.motion(ARM, 'multisine')
TURN = rotation_rpy(0.3, -0.5, 1.1)     # from axes of the link to those of the IMU
BIAS, NOISE = np.array([0.01, -0.02, 0.005]), (0.005, 0.1)
START, STEP = 10**11, 5_000_000
OFFSETS = {'imu/data': 0, 'imu/late': 30_000_000}      # of the IMU's clock, by topic [ns]


def measured(t, rng):
    """Return what the IMU shows at times [s]: angular velocity, specific force."""
    state = ARM.state(*MOTION.derivatives(t, 2))
    to_imu = TURN @ np.swapaxes(state.pose[..., :3, :3], -1, -2)
    force = state.classical(2)[..., 3:] + [0.0, 0.0, 9.80665]
    values = [np.einsum('nij,nj->ni', to_imu, v) for v in (state.velocity[..., :3], force)]
    return [v + n * rng.normal(size=v.shape) for v, n in zip((values[0] + BIAS, values[1]), NOISE)]


def imu(stamp_ns, gyroscope, force):
    message = Imu()
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 10**9)
    w, a = message.angular_velocity, message.linear_acceleration
    w.x, w.y, w.z = gyroscope.tolist()
    a.x, a.y, a.z = force.tolist()
    return message


@pytest.fixture(scope='module')
def told(module_context):
    """Publish joint states and the IMU with either clock; return what the tool says of each."""
    node = rclpy.create_node('source', context=module_context)
    states = node.create_publisher(JointState, 'joint_states', 100)
    shown = {topic: node.create_publisher(Imu, topic, 100) for topic in OFFSETS}
    t = np.arange(0, 200, STEP * 1e-9)
    q, qd = MOTION.derivatives(t, 1)
    gyroscope, force = measured(t, np.random.default_rng(1))
    runs = {topic: subprocess.Popen(
        [sys.executable, '-m', 'screw_kinematics', 'check', 'imu', '--robot', PUMA, '--topic',
         topic, '--seconds', '12'],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) for topic in OFFSETS}
    for k in range(len(t)):
        stamp = START + k * STEP
        states.publish(joint_state(ARM.joint_names, stamp, q[k], qd[k]))
        for topic, offset_ns in OFFSETS.items():
            shown[topic].publish(imu(stamp - offset_ns, gyroscope[k], force[k]))
        if k % 2:       # a busy machine must see enough of the motion, too
            continue
        time.sleep(0.003)
        if all(run.poll() is not None for run in runs.values()):
            break
    found = {topic: run.communicate(timeout=120)[0] for topic, run in runs.items()}
    node.destroy_node()
    assert [run.returncode for run in runs.values()] == [0, 0], found
    return found


@pytest.mark.parametrize('topic', OFFSETS)
def test_check_imu_of_a_running_system(told, topic):
    out, offset_ns = told[topic], OFFSETS[topic]
    found = float(re.search(r'\(offset ([+-][\d.]+) ms', out)[1])
    assert abs(found - offset_ns * 1e-6) < 0.5
    angles = [float(a) for a in re.search(
        r'roll ([\d.-]+), pitch ([\d.-]+), yaw ([\d.-]+) degrees', out).groups()]
    error = rotation_rpy(*np.radians(angles)) @ TURN
    assert np.degrees(np.linalg.norm(rotation_vector(error))) < 0.2
    bias = [float(b) for b in re.search(
        r'bias of the gyroscope ([\d.e-]+), ([\d.e-]+), ([\d.e-]+) rad/s', out).groups()]
    np.testing.assert_allclose(bias, BIAS, atol=2e-3)
    left = [float(x) for x in re.search(
        r'specific force is .*; left are ([\d.]+), ([\d.]+), ([\d.]+)', out).groups()]
    np.testing.assert_allclose(left, NOISE[1], rtol=0.2)
