# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Formulas of parallel robots hold at random postures, and are those of the textbooks."""
from functools import cache

import numpy as np
import pytest

from screw_kinematics import Joint, SerialChain
from screw_kinematics.errors import InvalidValueError
from screw_kinematics.parallel import ParallelManipulator
from screw_kinematics.screws import se3
from support.robots import robot

sympy = pytest.importorskip('sympy')
ROBOTS = ('planar_3rrr', 'stewart_6ups', 'delta')
cases = pytest.mark.parametrize(('name', 'seed'), [(n, s) for n in ROBOTS for s in range(3)])
load = cache(robot)


@cache
def formulas(name):
    from screw_kinematics.symbolic.parallel import ParallelFormulas
    return ParallelFormulas(load(name))


@cache
def moment(name, seed):
    """Return a random posture, actuated and passive rates, and the platform's states."""
    manipulator, rng = load(name), np.random.default_rng(seed)
    posture = manipulator.posture(
        manipulator.home.actuated + rng.uniform(-0.1, 0.1, manipulator.dof))
    rates = rng.normal(size=(3, manipulator.dof))
    states, passive = manipulator.rates(posture, *rates)
    return posture, rates, passive, states


def values(name, seed):
    """Return numbers for all symbols of the formulas."""
    found, (posture, rates, passive, _) = formulas(name), moment(name, seed)
    known = {}
    for symbols, numbers in zip(found.q, (posture.actuated, *rates)):
        known.update(zip(symbols, numbers))
    for symbols, numbers in zip(found.theta, (posture.passive, *passive)):
        known.update(zip(symbols, numbers))
    known.update(zip(found.position, posture.pose[:3, 3]))
    R = posture.pose[:3, :3]
    known.update(zip(found.rotation.ravel(), R.ravel()))
    known[sympy.Symbol('phi', real=True)] = np.arctan2(R[1, 0], R[0, 0])
    known = {s: float(x) for s, x in known.items() if s.is_Symbol}
    for limb in found.limbs:
        for wrench in limb.wrenches:
            if wrench.along is not None:
                d = evaluated(wrench.along, known)
                known.update((s, x) for s, x in zip(wrench.unit, d / np.linalg.norm(d))
                             if s.is_Symbol)
    return known


def evaluated(expressions, known):
    """Return expressions as numbers."""
    return np.array(function(tuple(known), tuple(expressions))(*known.values()), dtype=float)


@cache
def function(symbols, expressions):
    return sympy.lambdify(symbols, expressions, cse=True)       # printed once, not many times


@cache
def biases(name):
    """Return the known parts of acceleration and jerk of each limb."""
    return [[limb.bias(n) for n in (2, 3)] for limb in formulas(name).limbs]


@cases
def test_screws_are_those_of_the_limbs(name, seed):
    posture, known = moment(name, seed)[0], values(name, seed)
    manipulator = load(name)
    joints = dict(zip(manipulator.joint_names + manipulator.passive_joint_names, posture.joints))
    for limb, found in zip(manipulator.limbs, formulas(name).limbs):
        expected = limb.screws([joints[n] for n in limb.joint_names])
        assert found.joints == [joint.name for joint in limb.joints]
        for screw, numbers in zip(found.screws, expected):
            np.testing.assert_allclose(evaluated(screw, known), numbers, atol=1e-10)


@cases
def test_equations_of_velocity_acceleration_and_jerk(name, seed):
    (_, rates, _, (twist, *higher)), known = moment(name, seed), values(name, seed)
    for limb, bias in zip(formulas(name).limbs, biases(name)):
        bias = [evaluated(part, known) for part in bias]
        for wrench in limb.wrenches:
            screw = evaluated(wrench.screw, known)
            work = np.zeros(load(name).dof)
            work[list(wrench.work)] = evaluated(wrench.work.values(), known)
            assert wrench.constraint == (not wrench.work)
            np.testing.assert_allclose(
                se3.klein_form(screw, twist), work @ rates[0], atol=1e-10)
            for state, rate, known_part in zip(higher, rates[1:], bias):
                np.testing.assert_allclose(
                    se3.klein_form(screw, state),
                    work @ rate + se3.klein_form(screw, known_part), atol=1e-9)


@cases
def test_wrenches_span_those_of_the_manipulator(name, seed):
    posture, known = moment(name, seed)[0], values(name, seed)
    actuation, constraint = load(name).wrenches(posture)
    for limb, held, free in zip(formulas(name).limbs, actuation, constraint):
        found = np.array([evaluated(wrench.screw, known) for wrench in limb.wrenches])
        assert np.linalg.matrix_rank(found, 1e-9) == len(held) + len(free) == len(found)
        both = np.vstack([found, held, free])
        assert np.linalg.matrix_rank(both, 1e-9) == len(found)
        assert [w.constraint for w in limb.wrenches] == [False] * len(held) + [True] * len(free)


@pytest.mark.parametrize('seed', range(3))
def test_the_row_of_a_leg_is_its_unit_line(seed):
    """(s; R b x s) with s = (p + R b - a) / l, and no factor at the leg's rate."""
    pose, known = moment('stewart_6ups', seed)[0].pose, values('stewart_6ups', seed)
    angle = np.radians
    for limb, foot, head in zip(formulas('stewart_6ups').limbs, (10, 110, 130, 230, 250, 350),
                                (50, 70, 170, 190, 290, 310)):
        a = 0.5 * np.array([np.cos(angle(foot)), np.sin(angle(foot)), 0])
        arm = pose[:3, :3] @ (0.3 * np.array([np.cos(angle(head)), np.sin(angle(head)), 0]))
        leg = pose[:3, 3] + arm - a
        s = leg / np.linalg.norm(leg)
        (wrench,) = limb.wrenches
        assert not wrench.screw[3:].tolist()[0].has(*formulas('stewart_6ups').position)
        assert list(wrench.work.values()) == [1]
        np.testing.assert_allclose(
            evaluated(wrench.screw, known), [*s, *np.cross(arm, s)], atol=1e-10)


def test_the_motor_of_a_planar_limb_works_with_its_lever():
    """0.3 (cos q f_y - sin q f_x), in the plane of the angle phi alone."""
    found = formulas('planar_3rrr')
    assert found.moving == [[2, 3, 4]] * 3
    for k, limb in enumerate(found.limbs):
        wrench, q = limb.wrenches[0], found.q[0][k]
        fx, fy, fz = wrench.unit
        lever = sympy.Rational(3, 10) * (sympy.cos(q) * fy - sympy.sin(q) * fx)
        rest = sympy.expand(wrench.work[k] - lever)
        assert fz == 0 and all(abs(c) < 1e-11 for c in rest.as_coefficients_dict().values())


def test_limbs_of_no_known_form_are_told():
    """Skew hinges all along leave wrenches that are no lines through them."""
    from screw_kinematics.symbolic.parallel import ParallelFormulas
    T, rng = np.eye(4), np.random.default_rng(0)
    T[:3, 3] = 0.2, 0.1, 1.0
    limbs = [SerialChain([
        Joint(f'j{k}{i}', 'revolute', rng.normal(size=3), rng.normal(size=3)) for i in range(6)],
        T, name=f'limb_{k}') for k in range(6)]
    strange = ParallelManipulator(limbs, [f'j{k}0' for k in range(6)], name='strange')
    with pytest.raises(InvalidValueError,
                       match="strange: the wrenches .* limb 'limb_0' are not all lines through"):
        ParallelFormulas(strange)
