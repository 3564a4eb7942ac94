# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Three robots in one node: what happens to one is nothing to the others, by counts."""
from contextlib import contextmanager
from pathlib import Path
import subprocess
import sys

from geometry_msgs.msg import AccelStamped, TwistStamped
import numpy as np
from rclpy.qos import DurabilityPolicy, QoSProfile
from screw_kinematics import models
from std_msgs.msg import String
from support.rig import PUMA, RPR, running, six, smooth_motion, stamp_ns

RATE = 250
PERIOD = 10**9 // RATE
ARM = [f'q{i}' for i in range(1, 7)]
LEG = ['hip', 'knee']
SOURCE = Path(__file__).parents[1] / 'support' / 'joint_source.py'
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def leg(length):
    """Return the URDF of a leg with two joints and a shin of some length."""
    return f"""<robot name="leg">
      <link name="pelvis"/><link name="thigh"/><link name="shin"/><link name="foot"/>
      <joint name="hip" type="revolute"><parent link="pelvis"/><child link="thigh"/>
        <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="1" velocity="9"/></joint>
      <joint name="knee" type="revolute"><parent link="thigh"/><child link="shin"/>
        <origin xyz="0 0 -0.4"/><axis xyz="0 1 0"/>
        <limit lower="-2" upper="2" effort="1" velocity="9"/></joint>
      <joint name="ankle" type="fixed"><parent link="shin"/><child link="foot"/>
        <origin xyz="0 0 -{length}"/></joint>
    </robot>"""


@contextmanager
def source(topic, first_stamp, names):
    """Run a publisher of joint states; kill it at the end."""
    process = subprocess.Popen(
        [sys.executable, str(SOURCE), topic, str(RATE), str(first_stamp), *names])
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def assert_no_gap(messages, at_least):
    """Every sample since the first output has led to an output."""
    stamps = np.array([stamp_ns(m) for m in messages])
    assert len(stamps) >= at_least
    assert np.all(np.diff(stamps) == PERIOD), np.diff(stamps)[np.diff(stamps) != PERIOD]


def is_of_leg(message, length, tip):
    """Whether a twist is that of a leg with a shin of this length, at this tip."""
    chain = models.load_urdf(leg(length), tip_frame=tip)
    q, qd = smooth_motion(8, stamp_ns(message) * 1e-9)
    return np.allclose(six(message.twist), chain.state(q[:2], qd[:2]).velocity, atol=1e-2)


def changed(message, before, after):
    """Whether a twist is that of one leg and not of another; at times they move alike."""
    return is_of_leg(message, *after) and not is_of_leg(message, *before)


def test_what_happens_to_one_is_nothing_to_the_others(context, tmp_path):
    outputs = [f'{robot}/{output}' for robot in ('arm', 'leg', 'planar')
               for output in ('twist', 'accel')]
    parameters = {
        'robots': ['arm', 'leg', 'planar'],
        'arm': {'description': PUMA}, 'leg': {'description': ''},
        'planar': {'description': RPR, 'joint_states_topic': 'cell/joint_states',
                   'stale_timeout': 3.0}}      # longer than the machine may stand still
    with running(context, tmp_path, parameters) as rig:
        got = {topic: rig.listen(topic, TwistStamped if 'twist' in topic else AccelStamped)
               for topic in outputs}
        for robot in ('arm', 'leg', 'planar'):
            rig.wait_until_serving(robot, ['twist', 'accel'])
        assert rig.status('leg')[1] == "waiting for a description on 'robot_description'"
        assert rig.status('planar')[0] == b'\3'     # stale: nothing comes

        with source('joint_states', 0, [*LEG, *ARM]):
            rig.wait(lambda: len(got['arm/accel']) > 100)
            assert not got['leg/twist'] and not got['planar/twist']

            # The leg is described late, and again while it moves.
            descriptions = rig.node.create_publisher(String, 'robot_description', LATCHED)
            descriptions.publish(String(data=leg(0.4)))
            rig.wait(lambda: len(got['leg/accel']) > 100)
            assert is_of_leg(got['leg/twist'][60], 0.4, 'foot')
            descriptions.publish(String(data=leg(0.9)))
            rig.wait(lambda: changed(got['leg/twist'][-1], (0.4, 'foot'), (0.9, 'foot')))
            assert rig.set_parameters(leg__tip_frame='shin').successful
            rig.wait(lambda: changed(got['leg/twist'][-1], (0.9, 'foot'), (0.9, 'shin')))
            descriptions.publish(String(data='<robot name="leg"><link name="a"/>'))
            rig.wait(lambda: 'robot_description' in rig.status('leg')[1])
            assert rig.status('leg')[0] == b'\1'
            assert 'the old model stays' in rig.log.read_text()

            # The third robot's publisher comes late, dies, and returns.
            for life in range(2):
                n = len(got['planar/accel'])
                with source('cell/joint_states', life * 100 * 10**9, ['q1', 'q2', 'q3']):
                    rig.wait(lambda: len(got['planar/accel']) > n + 100)
                    rig.wait_for_value('planar', 'joints missing', '')
                if life == 0:
                    rig.wait_for_value('planar', 'joints missing', 'q1, q2, q3')

        # Give the last samples time to arrive, on all topics of a robot alike.
        rig.wait(lambda: len({stamp_ns(got[f'arm/{o}'][-1]) for o in ('twist', 'accel')}) == 1)
        rig.wait_for_value('arm', 'refused', 0)
        for robot in ('arm', 'leg'):
            for output in ('twist', 'accel'):
                assert_no_gap(got[f'{robot}/{output}'], 300)
        planar = [stamp_ns(m) for m in got['planar/twist']]
        second = next(i for i, s in enumerate(planar) if s >= 100 * 10**9)
        assert_no_gap(got['planar/twist'][:second], 100)
        assert_no_gap(got['planar/twist'][second:], 100)
        for robot in ('arm', 'leg', 'planar'):
            values = {key: int(rig.status(robot)[2][key])
                      for key in ('received', 'used', 'refused')}
            assert values['received'] == values['used'] + values['refused']


def test_a_description_that_did_not_suit_the_parameters_is_read_again_with_others(
        context, tmp_path):
    """The topic says it once; the parameter is set right, in two steps, the first one wrong."""
    parameters = {'robots': ['leg'], 'leg': {'tip_frame': 'fot', 'base_frame': 'pelvs'}}
    with running(context, tmp_path, parameters) as rig:
        twists = rig.listen('leg/twist', TwistStamped)
        rig.node.create_publisher(String, 'robot_description', LATCHED).publish(
            String(data=leg(0.4)))
        rig.wait(lambda: "'pelvs'" in rig.status('leg')[1])
        assert rig.set_parameters(leg__base_frame='pelvis').successful
        rig.wait(lambda: "'fot'" in rig.status('leg')[1])
        assert rig.status('leg')[0] == b'\2' and not twists
        assert rig.set_parameters(leg__tip_frame='foot').successful
        with source('joint_states', 0, LEG):
            rig.wait(lambda: twists and is_of_leg(twists[-1], 0.4, 'foot'))
