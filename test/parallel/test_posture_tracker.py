# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Samples close together take traced steps, and get what a search would find."""
from functools import cache
from math import factorial

import numpy as np
import pytest
from screw_kinematics import Joint, SerialChain
from screw_kinematics.errors import (
    AssemblyModeError, ClosureError, ScrewKinematicsError, SingularityError)
from screw_kinematics.parallel import ParallelManipulator
from support.parallel_geometry import moment, ROBOTS
from support.planar import (
    parallelogram, planar_joints, pose_of, singular_yaw, stretched, with_endless_joints)
from support.robots import robot

load = cache(robot)
PERIOD = 0.002
OUTPUTS = ('pose', 'twist', 'accel', 'jerk', 'snap', 'jacobian', 'passive_position',
           'passive_velocity')


def samples(name, seed, count):
    """Return joint positions and derivatives near a moment of an exact motion, by order."""
    exact = moment(name, seed).joints
    for t in PERIOD * (np.arange(count) - count // 2):
        yield [sum(exact[k + i] * t**i / factorial(i) for i in range(5 - k)) for k in range(5)]


def searched(manipulator, outputs, motion):
    """Return what outputs are at a sample, without traced steps."""
    posture = manipulator.posture(motion[0])
    state = manipulator.state(*motion)
    _, passive = manipulator.rates(posture, *motion[1:])
    every = {'pose': [*state.pose[:3, 3], *state.pose[:3, :3].ravel()],
             **{name: state.classical(n) for n, name in enumerate(OUTPUTS[1:5], 1)},
             'jacobian': posture.system.jacobian.ravel(),
             'passive_position': posture.passive, 'passive_velocity': passive[0]}
    return np.concatenate([every[name] for name in outputs])


def traced(program):
    """Return whether the last sample took traced steps."""
    return program._tracker._found is not None


@pytest.mark.parametrize('name', ROBOTS)
@pytest.mark.parametrize('outputs', [
    OUTPUTS, ('pose',), ('twist', 'passive_velocity'), ('pose', 'twist', 'accel')])
def test_a_stream_is_its_samples(name, outputs):
    manipulator = load(name)
    program = manipulator.compile(outputs)
    for k, motion in enumerate(samples(name, 3, 8)):
        values = np.concatenate(motion[:program.order + 1]).tolist()
        found, expected = np.array(program.evaluate(values)), searched(
            manipulator, outputs, motion)
        assert k == 0 or traced(program)
        for part in program.slices.values():
            scale = max(1.0, np.abs(expected[part]).max())
            np.testing.assert_allclose(found[part], expected[part], rtol=0, atol=1e-12 * scale)
    assert program.posture.iterations <= 4


def test_exact_rates_leave_one_step_to_take_and_one_to_check():
    stewart = load('stewart_6ups')
    program = stewart.compile(('pose', 'twist', 'accel'))
    for k, motion in enumerate(samples('stewart_6ups', 0, 6)):
        program(*motion[:3])
        assert k == 0 or program.posture.iterations == 2


def test_endless_motors_go_round():
    planar = load('planar_3rrr')
    endless = with_endless_joints(planar)
    program = endless.compile(('pose',))
    for k in range(5):
        q = planar.home.actuated + 0.002 * k
        found = program(q + 2 * np.pi * np.array([k, -k, 0]))['pose']
        np.testing.assert_allclose(found[:3], planar.posture(q).pose[:3, 3], atol=1e-12)
        assert k == 0 or traced(program)


def test_redundant_measurements_that_contradict_each_other():
    """Least squares, as in the search; the fourth sensor is off by a milliradian."""
    planar = load('planar_3rrr')
    names = planar.joint_names + planar.passive_joint_names
    redundant = ParallelManipulator(planar.limbs, [*planar.joint_names, 'elbow_1'],
                                    dict(zip(names, planar.home.joints)))
    program = redundant.compile(('pose', 'twist'))
    for k in range(5):
        posture = planar.posture(planar.home.actuated + 0.004 * k)
        q = np.append(posture.actuated, posture.passive[0] + 1e-3)
        qd = np.array([1.0, 0.5, -0.5, 0.2])
        found, state = program(q, qd), redundant.state(q, qd)
        assert k == 0 or traced(program)
        np.testing.assert_allclose(found['pose'][:3], state.pose[:3, 3], atol=1e-10)
        np.testing.assert_allclose(found['twist'], state.velocity, atol=1e-9)
        np.testing.assert_allclose(program.posture.misfit, redundant.posture(q).misfit, atol=1e-9)


def test_a_leg_that_spins_freely_is_searched_for():
    """Its passive joints depend on each other, which is no case for traced steps."""
    stewart = load('stewart_6ups')
    limb = stewart.limbs[0]
    joints = [Joint('spin', 'revolute', limb.joints[2].axis, limb.joints[2].point), *limb.joints]
    spinning = ParallelManipulator(
        [SerialChain(joints, limb.T_base_tool, name=limb.name), *stewart.limbs[1:]],
        stewart.joint_names, dict(zip(
            stewart.joint_names + stewart.passive_joint_names, stewart.home.joints)))
    program = spinning.compile(('pose', 'twist', 'accel'))
    for motion in samples('stewart_6ups', 2, 3):
        found, expected = program(*motion[:3]), stewart.state(*motion[:3])
        assert not traced(program)
        np.testing.assert_allclose(found['accel'], expected.classical(2), atol=1e-11)


def test_no_step_leads_over_a_direct_singularity():
    """A parallelogram that is folded flat, slowly, does not come out on the other side."""
    linkage = parallelogram()
    program = linkage.compile(('pose',))
    refused = []
    for angle in np.arange(-1.0, -1.7, -0.002):
        try:
            program([angle])
        except (AssemblyModeError, SingularityError):
            refused.append(angle)
    assert refused and max(refused) == pytest.approx(-np.pi / 2, abs=0.01)
    assert len(refused) == sum(np.arange(-1.0, -1.7, -0.002) <= max(refused))
    # Back where it was regular, it is what it was.
    np.testing.assert_allclose(
        program([-1.5])['pose'][:3], linkage.posture([-1.5]).pose[:3, 3], atol=1e-12)


def test_towards_a_direct_singularity_the_search_takes_over():
    planar, yaw = load('planar_3rrr'), singular_yaw()
    program, kinds = planar.compile(('pose',)), []
    for gap in np.geomspace(-yaw, 1e-5, 120):
        found = program(planar_joints(pose_of(yaw=yaw + gap)))['pose']
        kinds.append(traced(program))
        np.testing.assert_allclose(found[:3], 0, atol=1e-8)
    assert any(kinds[1:60]) and not kinds[-1]


def test_a_limb_that_comes_out_on_the_other_side_is_noticed():
    planar = load('planar_3rrr')
    program = planar.compile(('pose',))
    for y in np.linspace(0, -0.2 + 1e-6, 100):
        program(planar_joints(pose_of(y=y)))
    _, straight = stretched()
    for y in np.linspace(-0.2 + 1e-6, -0.19, 20):
        q = planar_joints(pose_of(y=y))
        q[2] = -np.pi - q[2]        # the other elbow, in the mirror
        found = program(q)['pose']
        np.testing.assert_allclose(found[:2], [0, y], atol=1e-8)
    assert program.report()['limbs in another working mode'] == 1
    np.testing.assert_array_equal(program.posture.working_mode, [1, 1, -1])


def test_what_stays_out_of_reach_is_refused_each_time_and_searched_for_seldom(monkeypatch):
    stewart = load('stewart_6ups')
    program = stewart.compile(('pose',))
    home = stewart.home.actuated
    searches = []
    module = __import__('screw_kinematics.parallel.posture_tracker', fromlist=['follow'])
    follow = module.follow
    monkeypatch.setattr(module, 'follow', lambda *a: searches.append(a) or follow(*a))
    program(home + 0.01)
    searches.clear()
    for _ in range(300):
        with pytest.raises(ClosureError, match="loop of limb 'limb_[1-6]' does not close"):
            program(home + [1, 0, 0, 0, 0, 0])
    assert len(searches) < 70
    # What is reached from the last good posture without a search is reached at once.
    program(home + 0.02)
    # What needs one, soon.
    for _ in range(30):
        with pytest.raises(ClosureError):
            program(home + [1, 0, 0, 0, 0, 0])
    for _ in range(8):
        try:
            found = program(home + 0.12)
            break
        except ScrewKinematicsError:
            continue
    np.testing.assert_allclose(found['pose'][:3], stewart.posture(home + 0.12).pose[:3, 3],
                               atol=1e-12)
