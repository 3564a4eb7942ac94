# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Singular, unreachable and otherwise assembled postures end in the right report."""
from functools import cache

import numpy as np
import pytest

from screw_kinematics import SerialChain
from screw_kinematics.errors import (
    AssemblyModeError, ClosureError, InvalidValueError, ShapeError, SingularityError,
    UnknownNameError)
from screw_kinematics.parallel import ParallelManipulator
from support.planar import (
    parallelogram, planar_joints, pose_of, singular_yaw, stretched, with_endless_joints)
from support.robots import robot

load = cache(robot)


FAR = np.eye(4)
FAR[0, 3] = 50


@pytest.mark.parametrize(('name', 'changes'), [
    ('stewart_6ups', {0: 1.5}), ('stewart_6ups', {0: -0.5, 3: 0.9}),
    ('planar_3rrr', {0: 1.5, 1: -1.5})])
def test_unreachable_posture_names_a_limb(name, changes):
    manipulator = load(name)
    q = manipulator.home.actuated.copy()
    for joint, change in changes.items():
        q[joint] += change
    with pytest.raises(ClosureError, match="loop of limb 'limb_[1-6]' does not close") as error:
        manipulator.posture(q)
    assert error.value.limb in [limb.name for limb in manipulator.limbs]
    assert error.value.misfit > 1e-6


def test_singular_posture():
    """All forearms through one point: the platform can turn about it, motors locked."""
    manipulator, yaw = load('planar_3rrr'), singular_yaw()
    near = [manipulator.posture_at(pose_of(yaw=yaw + gap)) for gap in (0.1, 0.01, 0.001)]
    distances = [posture.conditioning.direct for posture in near]
    assert distances[0] > distances[1] > distances[2] > 0
    assert distances[1] == pytest.approx(10 * distances[2], rel=0.1)
    with pytest.raises(SingularityError, match='direct singularity: the platform can move'):
        manipulator.posture(planar_joints(pose_of(yaw=yaw)))


def test_beyond_a_singularity_lies_another_assembly_mode():
    """Motors of a posture beyond lead from home to the other posture they have."""
    manipulator, yaw = load('planar_3rrr'), singular_yaw()
    beyond = manipulator.posture_at(
        pose_of(yaw=yaw - 0.1), manipulator.posture_at(pose_of(yaw=yaw + 0.1)))
    np.testing.assert_allclose(
        beyond.actuated, planar_joints(pose_of(yaw=yaw - 0.1)), atol=1e-12)
    same_motors = manipulator.posture(beyond.actuated)
    np.testing.assert_allclose(same_motors.actuated, beyond.actuated, atol=1e-12)
    assert np.arcsin(same_motors.pose[1, 0]) > yaw
    manipulator.check_assembly_mode(same_motors)
    with pytest.raises(AssemblyModeError, match="another assembly mode than at home: joint '"):
        manipulator.check_assembly_mode(beyond)
    # From there the other mode is kept just as well.
    np.testing.assert_allclose(
        manipulator.posture(beyond.actuated, start=beyond).pose, beyond.pose, atol=1e-12)


def test_a_way_over_a_singularity_is_refused():
    """A parallelogram that passes its flat posture may come out as an antiparallelogram."""
    linkage = parallelogram()
    assert linkage.posture([-1.5]).conditioning.direct < linkage.home.conditioning.direct
    with pytest.raises(AssemblyModeError, match='another assembly mode.* left_base -1.6'):
        linkage.posture([-1.6])


def test_flat_parallelogram_is_singular():
    with pytest.raises(SingularityError, match='direct singularity.* left_base -1.5708'):
        parallelogram().posture([-np.pi / 2])


def test_stretched_limb_is_an_inverse_singularity():
    """The platform is held, but its motions do not determine the motors'."""
    manipulator = load('planar_3rrr')
    pose, q = stretched()
    posture = manipulator.posture(q)
    np.testing.assert_allclose(posture.pose, pose, atol=1e-7)
    assert posture.conditioning.inverse < 1e-6 < 0.1 < posture.conditioning.direct
    with pytest.raises(SingularityError, match='inverse singularity: an actuator can move'):
        manipulator.inverse_rates(posture, [0, 0, 0, 1, 0, 0])


def test_limb_that_comes_out_on_the_other_side_is_reported():
    """The working mode of one motor changes; the way is regular for the platform."""
    manipulator = load('planar_3rrr')
    pose = pose_of(y=-0.195)
    q = planar_joints(pose)
    # The other elbow: mirror the first link at the line from motor to wrist, which is
    # straight down.
    q[2] = -np.pi - q[2]
    posture = manipulator.posture(q, start=manipulator.posture(stretched()[1]))
    np.testing.assert_allclose(posture.pose, pose, atol=1e-12)
    np.testing.assert_array_equal(posture.working_mode, [1, 1, -1])
    np.testing.assert_array_equal(manipulator.posture(planar_joints(pose)).working_mode, 1)


def test_unreachable_pose_names_a_limb():
    with pytest.raises(ClosureError, match="limb 'limb_3' does not close: misfit .* after"):
        load('planar_3rrr').posture_at(pose_of(y=-0.4))


def test_motion_that_the_limbs_do_not_allow():
    delta = load('delta')
    with pytest.raises(InvalidValueError, match="limb 'limb_[123]' does not allow the platform"):
        delta.inverse_rates(delta.home, [0, 0, 1, 0, 0, 0])


@pytest.mark.parametrize('turns', [-3, 1])
def test_whole_turns_of_a_continuous_motor_do_not_count(turns):
    planar = load('planar_3rrr')
    endless = with_endless_joints(planar)
    q = planar.home.actuated + [0.1, -0.05, 0.02]
    np.testing.assert_allclose(
        endless.posture(q + 2 * np.pi * turns * np.array([1, 0, -1])).pose,
        planar.posture(q).pose, atol=1e-12)


class TestConstruction:
    """What does not make a parallel manipulator is refused."""

    limbs = tuple(parallelogram().limbs)

    @pytest.mark.parametrize(('limbs', 'actuated', 'error', 'message'), [
        (limbs[:1], ['left_base'], InvalidValueError, 'at least 2 limbs, got 1'),
        (limbs[:1] * 2, ['left_base'], InvalidValueError, "limb 'left' occurs more than once"),
        (limbs, ['left_base', 'left_base'], InvalidValueError, 'must have different names'),
        (limbs, ['elbow'], InvalidValueError, "'elbow' is in none of the limbs.*left_base"),
        (limbs, [], InvalidValueError, 'still move at home: 0 of them for mobility 1'),
        ((limbs[0], SerialChain(limbs[0].joints, limbs[0].T_base_tool, name='right')),
         ['left_base'], InvalidValueError, "passive joint 'left_tip' is in the limbs 'left'"),
        ((limbs[0], SerialChain(limbs[1].joints, FAR, name='far')), ['left_base'],
         ClosureError, "loop of limb '(left|far)' does not close"),
    ])
    def test_refused(self, limbs, actuated, error, message):
        with pytest.raises(error, match=message):
            ParallelManipulator(limbs, actuated)

    def test_home_of_unknown_joints(self):
        with pytest.raises(UnknownNameError, match="home posture: 'q7'; known: 'left_base'"):
            ParallelManipulator(self.limbs, ['left_base'], {'q7': 0.0})

    def test_huge_numbers(self):
        stewart = load('stewart_6ups')
        with pytest.raises(InvalidValueError, match='reach further than 1e.100 m at leg_1 1e'):
            stewart.posture(np.full(6, 1e300))
        far = np.eye(4)
        far[0, 3] = 1e120
        with pytest.raises(InvalidValueError, match='reach further than 1e.100 m at left'):
            ParallelManipulator([limb.with_tool(far) for limb in self.limbs], ['left_base'],
                                {'left_base': 0.5, 'right_base': 0.7})

    def test_wrong_joint_vectors(self):
        linkage = parallelogram()
        with pytest.raises(ShapeError, match=r'q of Parallel.*expected shape \(1,\), got \(2,\)'):
            linkage.posture([0.0, 1.0])
        with pytest.raises(InvalidValueError, match='q of Parallel.* must be finite'):
            linkage.posture([np.nan])
        with pytest.raises(InvalidValueError, match='up to order 4 are supported, got 5'):
            linkage.rates(linkage.home, *np.zeros((5, 1)))
