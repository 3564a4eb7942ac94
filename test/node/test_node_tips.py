# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Several tips of one robot: each is what a robot of its own would be, from one estimator."""
from geometry_msgs.msg import AccelStamped, PoseStamped, TwistStamped
import numpy as np
import pytest
from screw_kinematics import models
from screw_kinematics.errors import ParameterError
from screw_kinematics.pipeline.parameter_file import robot_settings
from screw_kinematics.screws.rotations import pose, rotation_rpy
from support.rig import joint_state, running, six, smooth_motion, stamp_ns
from trajectory_msgs.msg import JointTrajectory


def branch(parent, joint, child, place, axis):
    return (f'<link name="{child}"/><joint name="{joint}" type="revolute">'
            f'<parent link="{parent}"/><child link="{child}"/><origin xyz="{place}"/>'
            f'<axis xyz="{axis}"/><limit lower="-9" upper="9" effort="1" velocity="9"/></joint>')


TORSO = '<robot name="torso"><link name="base"/>' + ''.join((
    branch('base', 'waist', 'chest', '0 0 0.5', '0 0 1'),
    branch('chest', 'neck', 'head', '0 0 0.4', '0 1 0'),
    branch('chest', 'left', 'left/hand-0', '0 0.3 0.2', '1 0 0'),
    branch('chest', 'right', 'right_hand', '0 -0.3 0.2', '1 0 0'))) + '</robot>'
NAMES = ['right', 'waist', 'left', 'neck']
OFFSET = [0.1, 0.0, 0.2, 0.3, -0.2, 0.5]
TOPICS = {
    'torso/head/twist': TwistStamped, 'torso/head/pose': PoseStamped,
    'torso/left_hand_0/twist': TwistStamped, 'torso/left_hand_0/joint_motion': JointTrajectory,
    'torso/right_hand/twist': TwistStamped, 'torso/right_hand/accel': AccelStamped}
PERIOD, START, SAMPLES = 5_000_000, 10**11, 60


def parameters():
    return {
        'robots': ['torso'],
        'torso': {
            'description': TORSO, 'tips': ['head', 'left/hand-0', 'right_hand'],
            'velocity_source': 'measured', 'outputs': ['twist'], 'reference_point': 'tip',
            'head': {'outputs': ['twist', 'pose'], 'tool_offset': OFFSET},
            'left/hand-0': {'outputs': ['twist', 'joint_motion'], 'expressed_in': 'tip'},
            'right_hand': {'outputs': ['twist', 'accel'], 'reference_point': 'base'}}}


@pytest.fixture(scope='module')
def got(module_context, tmp_path_factory):
    """Run a node with a torso over one motion; return messages by topic, and its last status."""
    with running(module_context, tmp_path_factory.mktemp('tips'), parameters()) as rig:
        messages = {topic: rig.listen(topic, kind) for topic, kind in TOPICS.items()}
        publisher = rig.publisher('joint_states')
        rig.wait(lambda: set(rig.status('torso')[2].get('outputs listened to', '').split(', '))
                 == {topic.removeprefix('torso/') for topic in TOPICS})
        k = 0
        while not all(messages.values()) or k < SAMPLES:
            q, qd = smooth_motion(4, k * PERIOD * 1e-9)
            publisher.publish(joint_state(NAMES, START + k * PERIOD, q, qd))
            rig.spin(0.003)
            k += 1
        rig.wait_for_value('torso', 'received', k)
        rig.spin(0.2)
        assert rig.set_parameters(**{'torso__head__reference_point': 'base'}).successful
        refused = rig.set_parameters(**{'torso__right_hand__reference_point': 'middle'})
        assert not refused.successful and 'torso.right_hand.reference_point' in refused.reason
        yield messages, rig.status('torso')


def states(tip, messages):
    """Yield messages with the state of a chain of its own at their instant."""
    chain = models.load_urdf(TORSO, tip_frame=tip)
    if tip == 'head':
        chain = chain.with_tool(pose(rotation_rpy(*OFFSET[3:]), OFFSET[:3]), 'tool')
    assert messages
    for message in messages:
        q, qd = (dict(zip(NAMES, x)) for x in smooth_motion(4, (stamp_ns(message) - START) * 1e-9))
        yield message, chain.state([q[n] for n in chain.joint_names],
                                   [qd[n] for n in chain.joint_names])


def test_each_tip_has_its_own_tool_axes_and_point(got):
    messages, _ = got
    for message, state in states('head', messages['torso/head/twist']):
        np.testing.assert_allclose(six(message.twist), state.velocity, rtol=1e-12, atol=1e-14)
        assert message.header.frame_id == 'base'
    for message, state in states('left/hand-0', messages['torso/left_hand_0/twist']):
        np.testing.assert_allclose(six(message.twist), state.expressed_in('tip').velocity,
                                   rtol=1e-12, atol=1e-14)
        assert message.header.frame_id == 'left/hand-0'
    for message, state in states('right_hand', messages['torso/right_hand/twist']):
        np.testing.assert_allclose(six(message.twist), state.about('base').velocity,
                                   rtol=1e-12, atol=1e-14)
    for message, state in states('head', messages['torso/head/pose']):
        p = message.pose.position
        np.testing.assert_allclose([p.x, p.y, p.z], state.pose[:3, 3], rtol=1e-12, atol=1e-14)


def test_joint_motion_of_a_tip_is_of_its_own_joints(got):
    messages, _ = got
    for message in messages['torso/left_hand_0/joint_motion']:
        point, = message.points
        q, qd = (dict(zip(NAMES, x)) for x in smooth_motion(4, (stamp_ns(message) - START) * 1e-9))
        assert message.joint_names == ['waist', 'left']
        assert list(point.positions) == [q['waist'], q['left']]
        assert list(point.velocities) == [qd['waist'], qd['left']]


def test_accelerations_come_for_every_tip_alike(got):
    messages, _ = got
    accels = messages['torso/right_hand/accel']
    assert {stamp_ns(m) for m in accels} <= {
        stamp_ns(m) for m in messages['torso/head/twist']}
    assert np.isfinite([six(m.accel) for m in accels]).all()


def test_one_robot_is_reported(got):
    _, (level, message, values) = got
    assert values['joints missing'] == ''
    assert '4 joints, base -> head_tool, left/hand-0, right_hand' in values['model']


@pytest.mark.parametrize('tips', [['a', 'a'], ['a.b'], ['a-b', 'a/b'], 7])
def test_tips_have_different_names_that_can_be_topics(tips):
    with pytest.raises(ParameterError, match="'arm.tips'.*different frames"):
        robot_settings('arm', {'tips': tips})


def test_a_tip_takes_what_it_has_not_of_its_own_from_the_robot():
    settings = robot_settings('arm', {
        'tips': ['a', 'b'], 'expressed_in': 'tip', 'b.expressed_in': 'base'})
    assert [(part.name, part.topic, part.tip_frame, part.expressed_in)
            for part in settings.parts] == [
        ('arm.a', 'arm/a', 'a', 'tip'), ('arm.b', 'arm/b', 'b', 'base')]
    with pytest.raises(ParameterError, match="'arm.b.outputs'"):
        robot_settings('arm', {'tips': ['a', 'b'], 'b.outputs': ['nonsense']})
