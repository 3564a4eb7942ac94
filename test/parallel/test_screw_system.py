# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Laws of the limbs' screw systems: reciprocity, power, and least squares."""
from functools import cache

import numpy as np
import pytest

from screw_kinematics.screws import reciprocal_screws, se3
from support.parallel_geometry import moment, ROBOTS
from support.robots import robot

load = cache(robot)
cases = pytest.mark.parametrize(('name', 'seed'), [(n, s) for n in ROBOTS for s in range(3)])


@cache
def moving(name, seed):
    """Return a manipulator, its posture, and actuated rates of the exact motion."""
    manipulator, exact = load(name), moment(name, seed)
    return manipulator, manipulator.posture(exact.joints[0]), exact.joints[1:]


def limb_columns(manipulator, posture):
    """Return for each limb its Jacobian and which columns are actuated."""
    values = dict(zip(manipulator.joint_names + manipulator.passive_joint_names,
                      posture.joints))
    for limb in manipulator.limbs:
        yield (limb.jacobian([values[n] for n in limb.joint_names]),
               np.array([n in manipulator.joint_names for n in limb.joint_names]))


@cases
def test_wrenches_do_no_work_on_passive_joints(name, seed):
    """Neither those of locked actuators nor constraints; the latter on no joint at all."""
    manipulator, posture, _ = moving(name, seed)
    for (columns, actuated), held, constraint in zip(
            limb_columns(manipulator, posture), *manipulator.wrenches(posture)):
        for wrench in (*held, *constraint):
            np.testing.assert_allclose(
                se3.klein_form(wrench, columns.T[~actuated]), 0, atol=1e-12)
        for wrench in constraint:
            np.testing.assert_allclose(se3.klein_form(wrench, columns.T), 0, atol=1e-12)
        for wrench in held:
            assert np.max(np.abs(se3.klein_form(wrench, columns.T[actuated]))) > 1e-3


@cases
def test_constraints_do_no_work_on_the_platform(name, seed):
    manipulator, posture, rates = moving(name, seed)
    (twist,), _ = manipulator.rates(posture, rates[0])
    for constraint in manipulator.wrenches(posture)[1]:
        np.testing.assert_allclose(se3.klein_form(constraint, twist), 0, atol=1e-12)


@cases
def test_power_of_actuators_is_that_of_their_wrenches(name, seed):
    """What a wrench does on the platform, it does on the actuated joints of its limb."""
    manipulator, posture, rates = moving(name, seed)
    (twist,), _ = manipulator.rates(posture, rates[0])
    rate = dict(zip(manipulator.joint_names, rates[0]))
    for limb, (columns, actuated), held in zip(
            manipulator.limbs, limb_columns(manipulator, posture),
            manipulator.wrenches(posture)[0]):
        at_joints = sum(rate[n] * columns[:, i]
                        for i, n in enumerate(limb.joint_names) if actuated[i])
        np.testing.assert_allclose(
            se3.klein_form(held, twist), se3.klein_form(held, at_joints), atol=1e-12)


@cases
def test_wrenches_of_a_limb_span_the_screws_reciprocal_to_its_passive_joints(name, seed):
    manipulator, posture, _ = moving(name, seed)
    for (columns, actuated), held, constraint in zip(
            limb_columns(manipulator, posture), *manipulator.wrenches(posture)):
        expected = reciprocal_screws(columns.T[~actuated])
        both = np.vstack([held, constraint, expected])
        assert np.linalg.matrix_rank(both, 1e-9) == len(expected) == len(held) + len(constraint)


@pytest.mark.parametrize('seed', range(3))
def test_a_leg_pushes_along_its_line(seed):
    """The wrench of a UPS limb is a force from the foot's centre through the head's."""
    manipulator, posture, _ = moving('stewart_6ups', seed)
    held, constraint = manipulator.wrenches(posture)
    for points, wrenches, none in zip(manipulator.points(posture).values(), held, constraint):
        foot, head = points[0], points[3]
        (wrench,) = wrenches
        direction = (head - foot) / np.linalg.norm(head - foot)
        lever = head - posture.pose[:3, 3]
        np.testing.assert_allclose(
            wrench, np.concatenate([direction, np.cross(lever, direction)]), atol=1e-12)
        assert len(none) == 0


@pytest.mark.parametrize('seed', range(3))
def test_limbs_of_a_delta_hold_by_couples(seed):
    """So that three of them leave the platform its translations only."""
    manipulator, posture, _ = moving('delta', seed)
    couples = np.vstack(manipulator.wrenches(posture)[1])
    np.testing.assert_allclose(couples[:, :3], 0, atol=1e-12)
    assert np.linalg.matrix_rank(couples, 1e-9) == 3
    assert manipulator.mobility == 3


@cases
def test_elimination_solves_the_whole_system(name, seed):
    """Platform and passive rates at once, by least squares of all limbs' equations."""
    manipulator, posture, rates = moving(name, seed)
    (twist,), (passive,) = manipulator.rates(posture, rates[0])
    n, rate = len(passive), dict(zip(manipulator.joint_names, rates[0]))
    rows, right, first = [], [], 0
    for limb, (columns, actuated) in zip(manipulator.limbs, limb_columns(manipulator, posture)):
        row = np.zeros((6, n + 6))
        count = np.sum(~actuated)
        row[:, first:first + count] = columns[:, ~actuated]
        row[:, n:] = -np.eye(6)
        first += count
        rows.append(row)
        right.append(-sum(rate[name] * columns[:, i] for i, name in enumerate(limb.joint_names)
                          if actuated[i]))
    whole = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=1e-9)[0]
    np.testing.assert_allclose(np.concatenate([passive, twist]), whole, atol=1e-11)


def test_the_skeleton_of_a_parallel_robot_is_a_line_for_each_limb():
    delta = load('delta')
    path = np.linspace(0.0, 0.3, 4)[:, None] * np.array([1.0, 0.5, -0.2])
    lines = delta.skeleton(path)
    assert [line.shape[0] for line in lines] == [4, 4, 4] and len(lines) == 3
    points = delta.points(delta.posture(path[3]))
    for line, limb in zip(lines, points.values()):
        np.testing.assert_allclose(line[3], limb, rtol=0, atol=1e-9)
        np.testing.assert_allclose(line[:, -1], delta.state(path).pose[:, :3, 3], atol=1e-9)
