# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Input as it really comes: every message is used, or refused with a reason, and counted."""
import math
import re

from geometry_msgs.msg import AccelStamped, TwistStamped
import numpy as np
import pytest
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from screw_kinematics import core, models
from sensor_msgs.msg import JointState
from support.rig import (
    joint_state, KEEP, PUMA, running, six, smooth_motion, stamp_ns)
from visualization_msgs.msg import Marker, MarkerArray

MS = 1_000_000
JOINTS = tuple(f'q{i}' for i in range(1, 7))
BEST_EFFORT = {'subscription': {'reliability': 'best_effort'}}


@pytest.fixture(scope='module')
def rig(module_context, tmp_path_factory):
    """Run a node with a robot for each kind of input."""
    def robot(topic, **settings):
        return {'description': PUMA, 'outputs': ['twist'], 'joint_states_topic': topic,
                'velocity_source': 'measured', **settings}

    parameters = {
        'robots': ['good', 'bad', 'level', 'lonely', 'spread', 'reliable', 'best_effort',
                   'unstamped', 'gone', 'flooded', 'doubled', 'slow', 'slow_measured'],
        'good': robot('good'), 'bad': robot('bad'), 'level': robot('level'),
        'lonely': robot('lonely'),
        'spread': robot(['arm_states', 'wrist_states']),
        'reliable': robot('reliable'), 'best_effort': robot('best_effort'),
        'unstamped': robot('unstamped'), 'flooded': robot('flooded'),
        'doubled': robot('doubled'), 'slow': robot('slow', velocity_source='auto'),
        'slow_measured': robot('slow', outputs=['twist', 'accel']),
        'gone': robot('gone', stale_timeout=0.3, outputs=['twist', 'markers']),
        'qos_overrides': {'/best_effort': BEST_EFFORT, '/flooded': BEST_EFFORT}}
    with running(module_context, tmp_path_factory.mktemp('input'), parameters) as rig:
        listened = [name for name in parameters['robots'] if name != 'lonely']
        for name in listened:
            rig.listen(f'{name}/twist', TwistStamped)
        rig.listen('gone/markers', MarkerArray)
        rig.listen('slow_measured/accel', AccelStamped)
        for name in listened:
            rig.wait_until_serving(name, parameters[name]['outputs'])
        yield rig


def serve(rig, robot, send):
    """Send samples, stamped with their number, until the robot answers; return the stamp."""
    twists, k = rig.received[f'{robot}/twist'], 0

    def answers():
        nonlocal k
        k += 1
        send(k * MS)
        return twists
    rig.wait(answers)
    rig.wait(lambda: stamp_ns(twists[-1]) == k * MS)
    return k * MS


def truth(t):
    """Return the twist at a time [s]."""
    return models.load(PUMA).state(*smooth_motion(6, t)).velocity


def counts(rig, robot):
    """Return received, used and refused of a robot, by its diagnostics."""
    values = rig.status(robot)[2]
    return [int(values[key]) for key in ('received', 'used', 'refused')]


BAD = [
    (joint_state(JOINTS, 0, [0.1] * 5, [0.1] * 5), 'position_of_wrong_length'),
    (joint_state(JOINTS, 0, [], []), 'position_of_wrong_length'),
    (joint_state(JOINTS, 0, [0.1] * 7, [0.1] * 6), 'position_of_wrong_length'),
    (joint_state(JOINTS, 0, [0.1] * 5 + [math.nan], [0.1] * 6), 'position_not_finite'),
    (joint_state(JOINTS, 0, [0.1] * 5 + [-math.inf], [0.1] * 6), 'position_not_finite'),
    (joint_state(JOINTS, 0, [0.1] * 6), 'velocity_not_measured'),
    (joint_state(JOINTS, 0, [0.1] * 6, [0.1] * 5 + [math.nan]), 'velocity_not_measured'),
    (joint_state((*JOINTS, 'q1'), 0, [0.1] * 7, [0.1] * 7), 'joint_named_twice'),
    (joint_state(['finger'], 0, [0.1], [0.1]), 'no_joint_of_robot')]


def test_bad_messages_are_refused_counted_and_do_no_harm(rig):
    publisher = rig.publisher('bad')
    q, qd = smooth_motion(6, 0.0)
    last = serve(rig, 'bad', lambda stamp: publisher.publish(joint_state(JOINTS, stamp, q, qd)))
    twists = rig.received['bad/twist']
    before = len(twists)
    for message, _ in BAD:
        last += MS
        message.header.stamp.nanosec = last
        publisher.publish(message)
        publisher.publish(joint_state(JOINTS, last, q, qd))
    publisher.publish(joint_state(JOINTS, last, q, qd))             # equal stamp
    publisher.publish(joint_state(JOINTS, last - 5 * MS, q, qd))    # back a little
    publisher.publish(serialize_message(joint_state(JOINTS, last, q, qd))[:100])
    publisher.publish(joint_state(JOINTS, -5 * 10**9, q, qd))
    rig.wait_for_value('node', '/bad refused stamp_negative', 1)
    rig.wait_for_value('node', '/bad refused malformed_message', 1)
    rig.wait_for_value('bad', 'refused stamp_not_increasing', 2)
    for reason in {reason for _, reason in BAD}:
        expected = sum(reason == other for _, other in BAD)
        rig.wait_for_value('bad', f'refused {reason}', expected)
    received, used, refused = counts(rig, 'bad')
    assert received == used + refused and refused == len(BAD) + 2
    rig.wait(lambda: len(twists) == before + len(BAD))
    assert np.all(np.isfinite([six(m.twist) for m in twists]))
    rig.wait(lambda: re.search(rf'bad: position_not_finite \({JOINTS[5]} at (nan|-inf)\), ',
                               rig.log.read_text()))


def test_it_says_whether_its_core_is_compiled(rig):
    state = core.build().state
    rig.wait_for_value('node', 'core', state)
    assert f'the core is {state}' in rig.log.read_text()


def test_levels_of_the_diagnostics(rig):
    publisher, stamp = rig.publisher('level'), rig.node.get_clock().now().nanoseconds
    q, qd = smooth_motion(6, 0.0)
    good, bad = joint_state(JOINTS, 0, q, qd), joint_state(JOINTS, 0, [*q[:5], math.nan], qd)
    short, twice = joint_state(JOINTS, 0, q[:5]), joint_state([*JOINTS[:5], JOINTS[0]], 0, q)
    for messages, level, told in (
            ([good], b'\0', 'running'), ([bad], b'\2', 'every message is refused: '
                                         f'position_not_finite ({JOINTS[5]} at nan)'),
            # What is refused now, not what was most often.
            ([short], b'\2', 'position_of_wrong_length (5 positions for 6 names)'),
            ([twice], b'\2', f'joint_named_twice ({JOINTS[0]})'),
            ([good, good, bad], b'\1', 'messages refused: position_not_finite'),
            ([good], b'\0', 'running')):
        def reported():
            nonlocal stamp
            for message in messages:
                stamp += MS
                message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
                publisher.publish(message)
            rig.spin(0.004)
            now, text, _ = rig.status('level')
            return now == level and told in text
        rig.wait(reported)


def test_nobody_listens_and_nothing_is_computed(rig):
    publisher = rig.publisher('lonely')
    for k in range(50):
        publisher.publish(joint_state(JOINTS, k * MS + 1, *smooth_motion(6, k * 1e-3)))
    rig.wait_for_value('lonely', 'received', 50)
    level, message, values = rig.status('lonely')
    assert (level, message) == (b'\0', 'ready; nobody listens')
    assert values['used nothing_wanted'] == '50' and values['outputs listened to'] == ''


def test_joints_on_several_topics_in_any_order_with_others_between(rig):
    arm, wrist = rig.publisher('arm_states'), rig.publisher('wrist_states')

    def send(stamp):
        q, qd = smooth_motion(6, stamp * 1e-9)
        arm.publish(joint_state(['q3', 'lamp', 'q1', 'q2'], stamp,
                                [q[2], 7.0, q[0], q[1]], [qd[2], math.nan, qd[0], qd[1]]))
        rig.wait(lambda: True)
        wrist.publish(joint_state(['q6', 'q4', 'q5'], stamp, q[[5, 3, 4]], qd[[5, 3, 4]]))

    start = serve(rig, 'spread', send)
    for k in range(1, 51):
        send(start + k * MS)
    twists = rig.received['spread/twist']
    rig.wait(lambda: stamp_ns(twists[-1]) == start + 50 * MS)
    for message in twists:
        assert np.allclose(six(message.twist), truth(stamp_ns(message) * 1e-9), atol=2e-2)
    rig.wait_for_value('spread', 'joints missing', '')


@pytest.mark.parametrize('kind', ['reliable', 'best_effort'])
def test_publishers_of_either_reliability(rig, kind):
    qos = QoSProfile(depth=100, reliability=ReliabilityPolicy[kind.upper()])
    publisher = rig.publisher(kind, qos=qos)
    q, qd = smooth_motion(6, 0.0)
    serve(rig, kind, lambda stamp: publisher.publish(joint_state(JOINTS, stamp, q, qd)))


def test_heavy_losses_do_not_stop_the_node(rig):
    qos = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
    publisher = rig.publisher('flooded', qos=qos)

    def send(stamp):
        publisher.publish(joint_state(JOINTS, stamp, *smooth_motion(6, 0.0)))

    last = serve(rig, 'flooded', send)
    repeated = serialize_message(joint_state(JOINTS, last, *smooth_motion(6, 0.0)))
    before, published = counts(rig, 'flooded')[0], 0
    reports = rig.received['/diagnostics']
    for _ in range(3):
        for _ in range(60):        # with pauses, so that losses alternate with messages
            for _ in range(1000):
                publisher.publish(repeated)
            rig.spin(0.001)
        published += 60_000
        n = len(reports)
        rig.wait(lambda: len(reports) >= n + 2)     # the second was made after the last message
    received, used, refused = counts(rig, 'flooded')
    assert received == used + refused
    assert 0 < received - before < published, 'nothing was lost: this shows nothing'
    twists = rig.received['flooded/twist']
    n = len(twists)

    def answers():
        nonlocal last
        last += MS
        send(last)
        return len(twists) > n

    rig.wait(answers)


def test_messages_without_stamp_are_of_the_moment_they_arrive(rig):
    publisher = rig.publisher('unstamped')
    q, qd = smooth_motion(6, 0.0)
    twists = rig.received['unstamped/twist']
    before = rig.node.get_clock().now().nanoseconds
    sent = 0

    def send():
        nonlocal sent
        sent += 1
        publisher.publish(joint_state(JOINTS, 0, q, qd))
        return twists
    rig.wait(send)      # the program is made in the background
    rig.wait_for_value('node', '/unstamped without stamp', sent)
    n = len(twists)
    for _ in range(20):
        send()
    rig.wait(lambda: len(twists) >= n + 20)
    stamps = [stamp_ns(m) for m in twists]
    assert stamps == sorted(set(stamps))
    assert before <= stamps[0] and stamps[-1] <= rig.node.get_clock().now().nanoseconds
    rig.wait_for_value('node', '/unstamped without stamp', sent)


def test_publishers_of_joint_states_are_counted(rig):
    rig.publisher('unstamped')
    rig.wait_for_value('node', '/unstamped publishers', 1)
    second = rig.node.create_publisher(JointState, 'unstamped', 10)
    rig.wait_for_value('node', '/unstamped publishers', 2)
    rig.node.destroy_publisher(second)
    rig.wait_for_value('node', '/unstamped publishers', 1)


def test_two_publishers_of_the_same_are_named(rig):
    """As where a driver and a relay send the same joint states."""
    first, second = rig.publisher('level'), rig.node.create_publisher(JointState, 'level', 10)
    stamp, (q, qd) = rig.node.get_clock().now().nanoseconds, smooth_motion(6, 0.0)

    def reported():
        nonlocal stamp
        stamp += MS
        for publisher in (first, second):
            publisher.publish(joint_state(JOINTS, stamp, q, qd))
        rig.spin(0.004)
        return 'stamp_not_increasing (the topic has 2 publishers)' in rig.status('level')[1]
    rig.wait(reported)
    rig.node.destroy_publisher(second)


def test_silence_is_told_and_nothing_is_repeated(rig):
    publisher = rig.publisher('gone')
    q, qd = smooth_motion(6, 0.0)
    last = serve(rig, 'gone', lambda stamp: publisher.publish(joint_state(JOINTS, stamp, q, qd)))
    twists, markers = rig.received['gone/twist'], rig.received['gone/markers']

    def none_missing():
        nonlocal last
        last += MS
        publisher.publish(joint_state(JOINTS, last, q, qd))
        return rig.status('gone')[2]['joints missing'] == ''
    rig.wait(none_missing)
    rig.wait(lambda: twists and stamp_ns(twists[-1]) == last)
    rig.wait_for_value('gone', 'joints missing', ', '.join(JOINTS))
    assert rig.status('gone')[0] == b'\3'
    rig.wait(lambda: markers and markers[-1].markers[0].action == Marker.DELETEALL)
    n = len(twists)
    for k in range(8):
        publisher.publish(joint_state(JOINTS, last + (5_000 + k) * MS, q, qd))
    rig.wait(lambda: len(twists) == n + 8)
    assert [stamp_ns(m) for m in twists[n:]] == [last + (5_000 + k) * MS for k in range(8)]


def test_effort_and_description_of_the_others_are_no_matter(rig):
    publisher = rig.publisher('good')
    q, qd = smooth_motion(6, 0.0)

    def send(stamp):
        message = joint_state(JOINTS, stamp, q, qd)
        message.effort = [math.nan, 1e300]
        message.header.frame_id = 'anything'
        publisher.publish(message)

    serve(rig, 'good', send)
    assert rig.received['good/twist'][-1].header.frame_id == 'base'


def test_a_second_publisher_that_sends_zeros_is_named(rig):
    """As a joint_state_publisher that was forgotten beside the robot's own."""
    publisher = rig.publisher('doubled')
    second = rig.node.create_publisher(JointState, 'doubled', KEEP)
    rig.wait(lambda: rig.status('node')[2]['/doubled publishers'] == '2')
    k = 0

    def told():
        nonlocal k
        for _ in range(20):
            k += 1
            stamp = 10**12 + k * 4 * MS
            publisher.publish(joint_state(JOINTS, stamp, *smooth_motion(6, k * 4e-3)))
            if k % 5 == 0:
                second.publish(joint_state(JOINTS, stamp + MS, [0.0] * 6))
        rig.spin(0.01)
        level, message, _ = rig.status('doubled')
        return level == b'\1' and '2 publishers disagree on joints ' in message
    rig.wait(told)
    rig.node.destroy_publisher(second)


def test_joint_states_that_come_too_slowly_to_estimate_are_told(rig):
    """Each half second: measured twists all the same, and why there is no acceleration."""
    publisher = rig.publisher('slow')
    twists, measured = rig.received['slow/twist'], rig.received['slow_measured/twist']
    k = 0

    def send():
        nonlocal k
        k += 1
        publisher.publish(joint_state(JOINTS, k * 500 * MS, *smooth_motion(6, k * 0.5)))
        return len(measured) >= 7
    rig.wait(send)
    assert not twists and not rig.received['slow_measured/accel']

    def told():
        send()
        level, message, _ = rig.status('slow')
        return level == b'\1' and 'pauses of up to 0.5 s' in message and 'max_gap' in message
    rig.wait(told)
