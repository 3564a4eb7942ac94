# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The joints' own motion as topics, and what an inertial measurement unit at the tip says."""
import numpy as np
import pytest
from screw_kinematics import models
from screw_kinematics.screws.rotations import rotation_from_quaternion
from sensor_msgs.msg import Imu, JointState
from support.rig import joint_state, running, smooth_motion, stamp_ns
from trajectory_msgs.msg import JointTrajectory

ARM = """
<robot name="arm">
  <link name="base"/><link name="upper"/><link name="lower"/><link name="hand"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0.1 0 0.5" rpy="0.3 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-9" upper="9" effort="1" velocity="9"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
    <origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-9" upper="9" effort="1" velocity="9"/></joint>
  <joint name="wrist" type="revolute"><parent link="lower"/><child link="hand"/>
    <origin xyz="0.3 0.1 0"/><axis xyz="1 0 0"/>
    <mimic joint="elbow" multiplier="-0.5" offset="0.2"/>
    <limit lower="-9" upper="9" effort="1" velocity="9"/></joint>
</robot>"""
OUTPUTS = {'joint_motion': JointTrajectory, 'joint_states': JointState, 'imu': Imu}
ROBOTS = {
    'plain': {},
    'turned': {'expressed_in': 'tip', 'outputs': ['imu', 'joint_motion']},
    'rooted': {'reference_point': 'base', 'outputs': ['imu', 'joint_motion']},
    'alone': {'outputs': ['joint_motion'], 'estimator': {'delay': 0.02}},
    'moon': {'gravity': [0.0, 1.0, -1.62], 'outputs': ['imu', 'joint_motion']}}
PERIOD, START, SAMPLES = 5_000_000, 10**11, 300
NAMES = ['elbow', 'shoulder']


@pytest.fixture(scope='module')
def messages(module_context, tmp_path_factory):
    """Run a node with these robots over one motion; return messages by robot and output."""
    parameters = {'robots': list(ROBOTS)} | {
        name: {'description': ARM, 'outputs': list(OUTPUTS), **settings}
        for name, settings in ROBOTS.items()}
    with running(module_context, tmp_path_factory.mktemp('joints'), parameters) as rig:
        got = {(name, output): rig.listen(f'{name}/{output}', OUTPUTS[output])
               for name in ROBOTS for output in parameters[name]['outputs']}
        publisher = rig.publisher('joint_states')
        for name in ROBOTS:
            rig.wait(lambda: set(rig.status(name)[2].get('outputs listened to', '').split(', '))
                     == set(parameters[name]['outputs']))
        k = 0
        while not all(got.values()) or k < SAMPLES:
            q, qd = smooth_motion(2, k * PERIOD * 1e-9)
            publisher.publish(joint_state(NAMES, START + k * PERIOD, q, qd))
            rig.spin(0.003)
            k += 1
        last = START + (k - 1) * PERIOD
        rig.wait(lambda: all(stamp_ns(m[-1]) >= last - 20_000_000 for m in got.values()))
        yield got


def motions(messages, robot):
    """Return positions, velocities and accelerations of all joints, by stamp."""
    result = {}
    for message in messages[robot, 'joint_motion']:
        point, = message.points
        assert message.joint_names == ['shoulder', 'elbow', 'wrist'] and not point.effort
        assert (point.time_from_start.sec, point.time_from_start.nanosec) == (0, 0)
        result[stamp_ns(message)] = np.array([
            point.positions, point.velocities, point.accelerations])
    return result


@pytest.mark.parametrize('robot', ['plain', 'alone'])
def test_joint_motion_is_the_joints_and_their_followers(messages, robot):
    found = motions(messages, robot)
    assert len(found) > 100
    for stamp, motion in list(found.items())[150:]:
        t = (stamp - START) * 1e-9
        (elbow, shoulder), (elbow_rate, shoulder_rate) = smooth_motion(2, t)
        np.testing.assert_allclose(motion[0], [shoulder, elbow, 0.2 - 0.5 * elbow], atol=1e-5)
        np.testing.assert_allclose(
            motion[1], [shoulder_rate, elbow_rate, -0.5 * elbow_rate], atol=1e-3)
        ahead, behind = (smooth_motion(2, t + dt)[1] for dt in (1e-4, -1e-4))
        slope = (ahead - behind) / 2e-4
        np.testing.assert_allclose(motion[2], [slope[1], slope[0], -0.5 * slope[0]], atol=0.02)


def test_the_delay_is_in_the_stamp(messages):
    stamps = [stamp_ns(m) for m in messages['alone', 'joint_motion']]
    assert (stamps[-1] - START) % PERIOD == 0
    assert set(np.diff(stamps)) == {PERIOD}


def test_joint_states_are_of_the_same_motion(messages):
    found = motions(messages, 'plain')
    states = {stamp_ns(m): m for m in messages['plain', 'joint_states']}
    assert len(found.keys() & states.keys()) > 100
    for stamp in found.keys() & states.keys():
        assert states[stamp].name == ['shoulder', 'elbow', 'wrist']
        assert list(states[stamp].position) == found[stamp][0].tolist()
        assert list(states[stamp].velocity) == found[stamp][1].tolist()


@pytest.mark.parametrize('robot', ['plain', 'turned', 'rooted', 'moon'])
def test_imu_says_what_the_joint_motion_means(messages, robot):
    """Whatever axes and point the other outputs have: it is the tip's own."""
    arm = models.load_urdf(ARM)
    gravity = np.array([0, 1, -1.62] if robot == 'moon' else [0, 0, -9.80665])
    found = motions(messages, robot)
    compared = 0
    for message in messages[robot, 'imu']:
        if stamp_ns(message) not in found:
            continue
        compared += 1
        motion = dict(zip(('shoulder', 'elbow', 'wrist'), found[stamp_ns(message)].T))
        state = arm.state(*np.array([motion[name] for name in arm.joint_names]).T)
        R = state.pose[:3, :3]
        o, w, f = message.orientation, message.angular_velocity, message.linear_acceleration
        assert message.header.frame_id == 'hand'
        np.testing.assert_allclose(
            rotation_from_quaternion(np.array([o.x, o.y, o.z, o.w])), R, atol=1e-9)
        np.testing.assert_allclose([w.x, w.y, w.z], R.T @ state.classical(1)[:3], atol=1e-9)
        np.testing.assert_allclose(
            [f.x, f.y, f.z], R.T @ (state.classical(2)[3:] - gravity), atol=1e-9)
        for covariance in (message.orientation_covariance, message.angular_velocity_covariance,
                           message.linear_acceleration_covariance):
            values = np.linalg.eigvalsh(np.reshape(covariance, (3, 3)))
            assert values[-1] > 0 and values[0] > -1e-9 * values[-1]
    assert compared > 100
