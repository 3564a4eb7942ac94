# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A mobile manipulator over DDS: joint states and the base's motion in, states in odom out."""
import json

from geometry_msgs.msg import AccelStamped, PoseStamped, TwistStamped
from nav_msgs.msg import Odometry
import numpy as np
from screw_kinematics import models
from screw_kinematics.screws.body_state import BodyState
from screw_kinematics.screws.exponential import exp
from screw_kinematics.screws.rotations import pose, quaternion_from_rotation, rotation_rpy
from screw_kinematics.screws.se3 import inverse
from screw_kinematics.tools.view.live import LiveRobots
from screw_kinematics.tools.view.motion import ShownMotion
from std_msgs.msg import String
from support.rig import (
    joint_state, KEEP, LIMIT, running, six, smooth_motion, stamp_ns, start)

MOUNT = 'xyz="0.2 0 0.4" rpy="0 0 0.5"'


def link(name):
    return f'<link name="{name}"/>'


def turning(name, parent, child, place, axis):
    return (f'<joint name="{name}" type="revolute"><parent link="{parent}"/>'
            f'<child link="{child}"/><origin xyz="{place}"/><axis xyz="{axis}"/>'
            '<limit lower="-9" upper="9" effort="1" velocity="9"/></joint>')


ROBOT = '<robot name="mobile">' + ''.join((
    *map(link, ('base_link', 'arm', 'upper', 'fore', 'hand')),
    f'<joint name="mount" type="fixed"><parent link="base_link"/><child link="arm"/>'
    f'<origin {MOUNT}/></joint>',
    turning('q1', 'arm', 'upper', '0 0 0.3', '0 0 1'),
    turning('q2', 'upper', 'fore', '0.1 0 0.2', '0 1 0'),
    turning('q3', 'fore', 'hand', '0.4 0 0', '1 0 0'))) + '</robot>'
NAMES = ['q1', 'q2', 'q3']
START, PERIOD, EVERY = 10**12, 4_000_000, 5


def base_motion(t):
    """Return the components of the twist of base_link, and its pose, of a steady bend."""
    rate, speed = 0.4 + 0.3 * np.sin(t), np.array([0, 0, 0.8, 1.0, 0, 0])
    way = 0.4 * t - 0.3 * (np.cos(t) - 1)
    return rate * speed, exp(way * speed)


def exact(t):
    """Return the state of the hand in odom, with velocity and acceleration."""
    arm = models.load_urdf(ROBOT, 'base_link', 'hand')
    q, qd = smooth_motion(3, t)
    h = 1e-4
    qdd = (smooth_motion(3, t + h)[1] - smooth_motion(3, t - h)[1]) / (2 * h)
    twist, place = base_motion(t)
    rate = (base_motion(t + h)[0] - base_motion(t - h)[0]) / (2 * h)
    seat = BodyState(place, (twist, rate), place[:3, 3], 'tip', 'tip')
    return seat.followed_by(arm.state(q, qd, qdd))


def odometry(t_ns, child='base_link'):
    twist, place = base_motion((t_ns - START) * 1e-9)
    message = Odometry(child_frame_id=child)
    message.header.frame_id = 'odom'
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(t_ns, 10**9)
    p, o = message.pose.pose.position, message.pose.pose.orientation
    p.x, p.y, p.z = place[:3, 3].tolist()
    o.x, o.y, o.z, o.w = quaternion_from_rotation(place[:3, :3]).tolist()
    put(message.twist.twist, twist)
    return message


def twist_stamped(t_ns):
    twist, _ = base_motion((t_ns - START) * 1e-9)
    message = TwistStamped()
    message.header.frame_id = 'base_link'
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(t_ns, 10**9)
    put(message.twist, twist)
    return message


def put(message, twist):
    w, v = message.angular, message.linear
    w.x, w.y, w.z, v.x, v.y, v.z = twist.tolist()


def parameters(**more):
    return {'robots': ['mobile'],
            'mobile': {'description': ROBOT, 'base_frame': 'arm', 'tip_frame': 'hand',
                       'base_motion_topic': 'base', 'stale_timeout': 60.0,
                       'outputs': ['pose', 'twist', 'accel'], **more}}


def drive(rig, kind, make, enough, begin=0):
    """Publish joints and base from a step on, until there is enough; return the next step."""
    joints, base = rig.publisher('joint_states'), rig.publisher('base', kind)
    k = begin
    while not enough() or k < begin + 200:
        t_ns = START + k * PERIOD
        if k % EVERY == 0:
            base.publish(make(t_ns))
        joints.publish(joint_state(NAMES, t_ns, *smooth_motion(3, (t_ns - START) * 1e-9)))
        rig.spin(0.002)
        k += 1
        assert k < 20000, rig.status('mobile')
    return k


def compare(messages, value, late=0.8):
    """Compare messages with what the exact motion says, once the estimators have settled."""
    checked = [m for m in messages if (stamp_ns(m) - START) * 1e-9 > late]
    assert checked
    for message in checked[::5]:
        found, known = value(message, exact((stamp_ns(message) - START) * 1e-9))
        yield np.abs(found - known).max()


def test_states_in_the_frame_of_the_odometry(context, tmp_path):
    with running(context, tmp_path, parameters(estimator={'delay': 0.02})) as rig:
        poses = rig.listen('mobile/pose', PoseStamped)
        twists = rig.listen('mobile/twist', TwistStamped)
        accels = rig.listen('mobile/accel', AccelStamped)
        rig.wait_until_serving('mobile', ['pose', 'twist', 'accel'])
        k = drive(rig, Odometry, odometry, lambda: len(accels) > 400)
        for messages in (poses, twists, accels):
            assert {m.header.frame_id for m in messages} == {'odom'}
        assert max(compare(poses, lambda m, state: (
            np.array([m.pose.position.x, m.pose.position.y, m.pose.position.z]),
            state.pose[:3, 3]))) < 1e-3
        assert max(compare(twists, lambda m, state: (
            six(m.twist), state.velocity))) < 5e-3
        assert max(compare(accels, lambda m, state: (
            six(m.accel), state.classical(2)))) < 0.1
        assert rig.status('mobile')[2]['base motion relative to'] == 'odom'
        assert rig.status('node')[2]['/base type'] == 'nav_msgs/msg/Odometry'

        # What is wrong is refused, counted and told; the rest goes on.
        base = rig.publisher('base', Odometry)
        strange = odometry(START + k * PERIOD, child='base_footprint')
        crooked = odometry(START + k * PERIOD)
        crooked.pose.pose.orientation.w += 0.5
        absurd = odometry(START + k * PERIOD)
        absurd.twist.twist.linear.x = float('nan')
        for message, reason in ((strange, 'frame_not_fixed_to_base'),
                                (crooked, 'base_orientation_not_normalised'),
                                (absurd, 'values_not_finite')):
            base.publish(message)
            rig.wait_for_value('mobile', f'base motion refused {reason}', 1)
        count = len(accels)
        k = drive(rig, Odometry, odometry, lambda: len(accels) > count + 100, k)
        told = ' '.join(s.message for array in rig.received['/diagnostics'] for s in array.status)
        assert "'base_footprint'; allowed: 'base_link', 'arm'" in told
        assert 'qos_overrides' not in told

        # What it is relative to changes while it runs.
        for choice, frame in (('base', 'arm'), ('world', 'odom')):
            assert rig.set_parameters(mobile__relative_to=choice).successful
            k = drive(rig, Odometry, odometry,
                      lambda name=frame: twists[-1].header.frame_id == name, k)
        refused = rig.set_parameters(mobile__relative_to='odom')
        assert not refused.successful and 'base, world, or nothing' in refused.reason

        # A base that is silent for longer than stale_timeout is no base that stands.
        for step in range(20):
            t_ns = START + (k + step) * PERIOD + 61 * 10**9
            rig.publisher('joint_states').publish(joint_state(NAMES, t_ns, [0.1] * 3))
        rig.wait(lambda: int(rig.status('mobile')[2].get('refused base_motion_too_old', 0)) > 5)


def test_a_base_that_says_no_pose_and_tips_of_both_kinds(context, tmp_path):
    given = parameters(
        velocity_source='measured', tips=['hand', 'fore'], outputs=['twist'],
        fore={'relative_to': 'base'})
    del given['mobile']['tip_frame']
    with running(context, tmp_path, given) as rig:
        hand = rig.listen('mobile/hand/twist', TwistStamped)
        fore = rig.listen('mobile/fore/twist', TwistStamped)
        rig.wait_until_serving('mobile', ['hand/twist', 'fore/twist'])
        joints = rig.publisher('joint_states')
        k = -20000      # nobody says how the base moves
        while not (len(fore) > 10 and rig.status(
                'mobile', 'left out: no message of the base came')[1]):
            t_ns = START + k * PERIOD
            joints.publish(joint_state(NAMES, t_ns, *smooth_motion(3, (t_ns - START) * 1e-9)))
            rig.spin(0.002)
            k += 1
            assert k < 0, rig.status('mobile')
        assert not hand and {m.header.frame_id for m in fore} == {'arm'}
        drive(rig, TwistStamped, twist_stamped, lambda: len(hand) > 200)
        # In axes of the base, as nobody says how these are turned.
        assert {m.header.frame_id for m in hand} == {'arm'}
        mount = pose(rotation_rpy(0, 0, 0.5), (0.2, 0, 0.4))

        def in_base(message, state):
            _, place = base_motion((stamp_ns(message) - START) * 1e-9)
            back = inverse(place @ mount)[:3, :3]
            return six(message.twist), np.concatenate([back @ state.velocity[:3],
                                                       back @ state.velocity[3:]])
        assert max(compare(hand, in_base)) < 2e-2


def test_the_view_draws_a_robot_where_its_base_is(context, tmp_path):
    with running(context, tmp_path, parameters()) as rig:
        motion = ShownMotion('mobile', models.load_urdf(ROBOT, 'arm', 'hand'), world='odometry')
        with LiveRobots([motion], [['joint_states']], '') as shown:
            rig.wait_until_serving('mobile', ['pose', 'twist', 'accel'])

            def enough():
                # Longer than what comes of a sample takes: the states shown are of one stamp.
                shown.listen(0.02)
                return len(motion.snapshots) > 40
            drive(rig, Odometry, odometry, enough)
        assert motion.world == 'odom'
        mount = pose(rotation_rpy(0, 0, 0.5), (0.2, 0, 0.4))
        for snapshot in motion.snapshots[20:]:
            # On the base's bend, as far along as it has turned.
            seat = snapshot.base @ inverse(mount)
            way = np.arctan2(seat[1, 0], seat[0, 0]) / 0.8
            np.testing.assert_allclose(seat, exp(way * np.array([0, 0, 0.8, 1, 0, 0])), atol=2e-3)
            np.testing.assert_allclose(snapshot.skeleton[0][-1], snapshot.pose[:3, 3], atol=1e-9)


def test_a_topic_of_another_type_is_named(context, tmp_path):
    with running(context, tmp_path, parameters()) as rig:
        rig.node.create_publisher(String, 'base', KEEP)
        rig.wait(lambda: rig.status('node')[1]
                 == '/base is of type std_msgs/msg/String; allowed: nav_msgs/msg/Odometry, '
                    'geometry_msgs/msg/TwistStamped')


def test_the_topic_of_the_base_is_one_of_its_own(ros_domain, tmp_path):
    file, log = tmp_path / 'wrong.yaml', tmp_path / 'log'
    file.write_text(json.dumps({'kinematic_state_publisher': {
        'ros__parameters': parameters(base_motion_topic='joint_states')}}))
    process = start(['--params-file', str(file)], log)
    assert process.wait(LIMIT) == 1
    assert "'mobile.base_motion_topic' is '/joint_states'; allowed: another" in log.read_text()
