# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The program of a parallel manipulator: outputs, warm start, and recovery from errors."""
from functools import cache

import numpy as np
import pytest

from screw_kinematics.errors import ClosureError, ScrewKinematicsError, UnknownNameError
from support.parallel_geometry import moment, ROBOTS
from support.robots import robot

load = cache(robot)
OUTPUTS = ('pose', 'twist', 'accel', 'jerk', 'snap', 'reduced_accel', 'reduced_jerk',
           'reduced_snap', 'jacobian')


@pytest.mark.parametrize('pole', ['base', 'tip'])
@pytest.mark.parametrize('axes', ['base', 'tip'])
@pytest.mark.parametrize('name', ROBOTS)
def test_outputs_are_those_of_the_manipulator(name, axes, pole):
    manipulator, joints = load(name), moment(name, 0).joints
    program = manipulator.compile(OUTPUTS, axes, pole)
    assert (program.order, program.inputs) == (4, 5 * manipulator.dof)
    found = program(*joints)
    state = manipulator.state(*joints).about(pole).expressed_in(axes)
    expected = {
        'pose': [*state.pose[:3, 3], *state.pose[:3, :3].ravel()], 'twist': state.velocity,
        'accel': state.classical(2), 'jerk': state.classical(3), 'snap': state.classical(4),
        'reduced_accel': state.reduced_acceleration, 'reduced_jerk': state.reduced_jerk,
        'reduced_snap': state.reduced_snap}
    assert list(found) == list(OUTPUTS)
    for output, values in expected.items():
        np.testing.assert_allclose(found[output], values, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(
        found['jacobian'].reshape(6, -1) @ joints[1], state.velocity, atol=1e-12)


@pytest.mark.parametrize('name', ROBOTS)
def test_passive_joints_of_the_last_sample(name):
    manipulator, joints = load(name), moment(name, 1).joints
    program = manipulator.compile(('accel', 'passive_velocity', 'passive_position'))
    found = program(*joints[:3])
    posture = manipulator.posture(joints[0])
    _, rates = manipulator.rates(posture, *joints[1:3])
    assert program.passive_joint_names == manipulator.passive_joint_names
    np.testing.assert_allclose(program.posture.passive, posture.passive, atol=1e-12)
    np.testing.assert_allclose(program.passive_rates, rates, atol=1e-12)
    np.testing.assert_array_equal(found['passive_position'], program.posture.passive)
    np.testing.assert_array_equal(found['passive_velocity'], program.passive_rates[0])


def test_report_of_the_last_posture():
    planar = load('planar_3rrr')
    program = planar.compile(('pose',))
    program(moment('planar_3rrr', 0).joints[0])
    report, posture = program.report(), program.posture
    assert report['distance to direct singularity'] == posture.conditioning.direct
    assert report['distance to inverse singularity'] == posture.conditioning.inverse
    assert report['limbs in another working mode'] == 0
    assert 0 < report['Newton steps'] < 20 and report['largest misfit of a loop'] < 1e-12


@pytest.mark.parametrize('name', ROBOTS)
def test_batch_is_sample_after_sample(name):
    manipulator = load(name)
    target = moment(name, 2).joints[0]
    q = np.linspace(manipulator.home.actuated, target, 20)
    qd = np.broadcast_to(target - manipulator.home.actuated, q.shape)
    one, many = (manipulator.compile(('pose', 'twist')) for _ in range(2))
    rows = many.batch(q, qd)
    for k in range(len(q)):
        for output, values in one(q[k], qd[k]).items():
            np.testing.assert_array_equal(rows[output][k], values)


def test_a_bad_sample_is_forgotten():
    """After unreachable samples the next good one has the state it always had."""
    stewart = load('stewart_6ups')
    program = stewart.compile(('pose', 'twist'))
    q, qd = moment('stewart_6ups', 0).joints[:2]
    good = program(q, qd)
    for _ in range(120):
        with pytest.raises(ClosureError, match='does not close'):
            program(q + [1, 0, 0, 0, 0, 0], qd)
    assert program.posture.pose[0, 3] == good['pose'][0]
    for output, values in program(q, qd).items():
        np.testing.assert_allclose(values, good[output], atol=1e-12)


def test_reset_goes_back_to_home():
    stewart = load('stewart_6ups')
    program = stewart.compile(('pose',))
    program(moment('stewart_6ups', 0).joints[0])
    assert program.posture is not stewart.home
    program.reset()
    assert program.posture is stewart.home
    assert program.passive_rates == []


def test_steps_too_long_for_the_warm_start_keep_the_assembly_mode():
    """Samples far apart are reached on the way, not by a jump into another mode."""
    planar = load('planar_3rrr')
    program = planar.compile(('pose',))
    rng = np.random.default_rng(0)
    reached = 0
    for _ in range(30):
        q = planar.home.actuated + rng.uniform(-0.4, 0.4, 3)
        try:
            found = program(q)['pose']
        except ScrewKinematicsError:
            continue
        reached += 1
        posture = planar.posture(q)
        np.testing.assert_allclose(found[:3], posture.pose[:3, 3], atol=1e-10)
    assert reached > 10


def test_unknown_output():
    with pytest.raises(UnknownNameError, match="unknown output 'speed'; known: 'pose'"):
        load('delta').compile(('speed',))


def test_tool_on_the_platform():
    """A tool moves with the platform: the same states, shifted to its point."""
    delta = load('delta')
    offset = np.eye(4)
    offset[:3, 3] = 0.1, -0.2, 0.3
    tool = delta.with_tool(offset, 'gripper')
    q, qd, qdd = moment('delta', 0).joints[:3]
    plain, moved = delta.state(q, qd, qdd), tool.state(q, qd, qdd)
    assert moved.tip_frame == 'gripper'
    np.testing.assert_allclose(moved.pose, plain.pose @ offset, atol=1e-12)
    there = plain.about(moved.pose[:3, 3])
    np.testing.assert_allclose(moved.velocity, there.velocity, atol=1e-12)
    np.testing.assert_allclose(moved.reduced_acceleration, there.reduced_acceleration, atol=1e-12)


def test_results_go_where_they_are_wanted():
    manipulator, joints = load('planar_3rrr'), moment('planar_3rrr', 0).joints
    program = manipulator.compile(('pose', 'twist'))
    expected = program(*joints)
    out = np.empty((1, 18))
    results = program.batch(*[part[None] for part in joints], out=out)
    assert np.shares_memory(results['pose'], out)
    np.testing.assert_allclose(results['pose'][0], expected['pose'], atol=1e-12)


def test_operations_are_those_of_the_steps_that_a_sample_takes():
    """More are needed for more outputs, far more than for an arm of as many joints."""
    twist, more = (load('stewart_6ups').compile(outputs).operations for outputs in (
        ('twist',), ('pose', 'twist', 'accel', 'jacobian')))
    assert 2000 < twist < more < 30_000
