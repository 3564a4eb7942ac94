# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Parallel manipulators answer what serial chains answer, by the same names."""
from functools import cache

import numpy as np
import pytest

from screw_kinematics import InverseSolver
from screw_kinematics.errors import InvalidValueError, ShapeError, UnknownNameError
from screw_kinematics.screws import se3
from support.parallel_geometry import moment, ROBOTS
from support.robots import robot

load = cache(robot)
instant = cache(moment)
EXACT = InverseSolver(exact=True)
each_robot = pytest.mark.parametrize('name', ROBOTS)
each_place = pytest.mark.parametrize('pole, axes', [
    ('tip', 'base'), ('base', 'tip'), (np.array([0.1, -0.2, 0.3]), 'base')])


@each_robot
@each_place
def test_jacobian_times_rates_is_the_twist(name, pole, axes):
    q, qd = instant(name, 1).joints[:2]
    twist = load(name).state(q, qd).about(pole).expressed_in(axes).velocity
    np.testing.assert_allclose(load(name).jacobian(q, pole, axes) @ qd, twist, atol=1e-11)


@each_robot
@each_place
@pytest.mark.parametrize('kind', ['classical', 'reduced'])
def test_inverse_of_every_order(name, pole, axes, kind):
    """The joints' derivatives come back from the platform's exact motion."""
    exact, manipulator = instant(name, 2), load(name)
    q, qd, qdd, qddd, qdddd = exact.joints
    state = manipulator.state(*exact.joints).about(pole).expressed_in(axes)

    def wanted(n):
        return state.classical(n) if kind == 'classical' else state.reduced[n - 1]

    where = (kind, pole, axes)
    for found, expected in (
            (manipulator.inverse_velocity(q, state.velocity, pole, axes, solver=EXACT), qd),
            (manipulator.inverse_acceleration(q, qd, wanted(2), *where, solver=EXACT), qdd),
            (manipulator.inverse_jerk(q, qd, qdd, wanted(3), *where, solver=EXACT), qddd),
            (manipulator.inverse_snap(q, qd, qdd, qddd, wanted(4), *where, solver=EXACT),
             qdddd)):
        np.testing.assert_allclose(found.rates, expected, rtol=0,
                                   atol=1e-9 * max(1, np.abs(expected).max()))


@each_robot
def test_the_coriolis_lie_term_is_what_the_rates_contribute(name):
    q, qd, qdd = instant(name, 3).joints[:3]
    manipulator = load(name)
    term = manipulator.coriolis_lie(q, qd)
    np.testing.assert_allclose(
        term + manipulator.jacobian(q) @ qdd,
        manipulator.state(q, qd, qdd).reduced_acceleration, atol=1e-10)
    # Quadratic in the rates.
    np.testing.assert_allclose(manipulator.coriolis_lie(q, 2 * qd), 4 * term, atol=1e-10)


@each_robot
def test_joint_efforts_have_the_power_of_the_wrench(name):
    q, qd = instant(name, 1).joints[:2]
    wrench = np.random.default_rng(3).normal(size=6)
    efforts = load(name).joint_efforts(q, wrench)
    power = se3.klein_form(wrench, load(name).state(q, qd).velocity)
    assert efforts @ qd == pytest.approx(power, rel=1e-10)


def test_batches_are_samples_side_by_side():
    manipulator = load('planar_3rrr')
    q = manipulator.home.actuated + 0.05 * np.random.default_rng(4).normal(size=(2, 3, 3))
    qd = np.random.default_rng(5).normal(size=(2, 3, 3))
    state, jacobian = manipulator.state(q, qd), manipulator.jacobian(q, axes='tip')
    twist = state.expressed_in('tip').velocity
    np.testing.assert_allclose(se3.matvec(jacobian, qd), twist, atol=1e-12)
    one = manipulator.state(q[1, 2], qd[1, 2])
    np.testing.assert_allclose(state.pose[1, 2], one.pose, atol=1e-11)
    np.testing.assert_allclose(manipulator.pose(q), state.pose, atol=1e-11)
    rates = manipulator.inverse_velocity(q, state.velocity, solver=EXACT).rates
    np.testing.assert_allclose(rates, qd, atol=1e-10)
    assert manipulator.manipulability(q).measure.shape == (2, 3)
    assert manipulator.state(q[0, :0]).pose.shape == (0, 4, 4)


def test_wrong_arguments_are_refused():
    manipulator = load('planar_3rrr')
    q = manipulator.home.actuated
    with pytest.raises(ShapeError, match=r'q of Parallel.*expected shape \(\.\.\., 3\), got \(2,'):
        manipulator.state(q[:2])
    with pytest.raises(ShapeError, match=r'derivative 1 of q of .*, as q, got \(3, 3\)'):
        manipulator.state(np.stack([q, q]), np.zeros((3, 3)))
    with pytest.raises(InvalidValueError, match='must be numbers'):
        manipulator.state(['0'] * 3)
    with pytest.raises(InvalidValueError, match='up to order 4 are supported, got 5'):
        manipulator.state(*[q] * 6)
    with pytest.raises(UnknownNameError, match="unknown axes 'tool'"):
        manipulator.jacobian(q, axes='tool')
    with pytest.raises(UnknownNameError, match="unknown kind 'true'"):
        manipulator.inverse_jerk(q, q, q, np.zeros(6), kind='true')
    with pytest.raises(ShapeError, match=r'state of order 1: expected shape \(6,\)'):
        manipulator.inverse_rates(manipulator.home, np.zeros(5))
    with pytest.raises(InvalidValueError, match='pose is no rigid displacement'):
        manipulator.posture_at(np.diag([1.0, 1, -1, 1]))
