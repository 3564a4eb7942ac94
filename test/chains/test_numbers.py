# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Extreme numbers: errors stay within what rounding explains, and nothing breaks down."""
import numpy as np
import pytest

from screw_kinematics.motion import ESTIMATORS, make_estimator
from support import accuracy_cases, robots

CASES = {case.name: case for case in accuracy_cases.cases()}


@pytest.mark.parametrize('name', CASES)
def test_errors_are_of_rounding(name):
    case = CASES[name]
    for method, found in accuracy_cases.errors(case).items():
        for quantity, error in found.items():
            assert error <= case.bounds[method], f'{method}: {quantity}'


def test_inverse_rates_lose_no_more_than_the_condition_costs():
    for distance, condition, error in accuracy_cases.inverse_errors():
        assert error <= 10 * condition * accuracy_cases.EPSILON, distance


@pytest.mark.parametrize('turns', [1, 1000, 159_155])
def test_whole_turns_change_nothing_but_the_rounding_of_the_angle(turns):
    panda = robots.robot('panda')
    q, qd, qdd = robots.random_motion(11, 7, order=2)
    here, there = panda.state(q, qd, qdd), panda.state(q + 2 * np.pi * turns, qd, qdd)
    rounding = 20 * accuracy_cases.EPSILON * (1 + 2 * np.pi * turns)
    for x, y in ((here.pose, there.pose), (here.reduced_acceleration, there.reduced_acceleration)):
        np.testing.assert_allclose(y, x, rtol=0, atol=rounding * np.abs(x).max())


def test_states_scale_with_time():
    """The same path run 2^40 times slower: each state falls by that power, to the bit."""
    panda = robots.robot('panda')
    motion = robots.random_motion(12, 7)
    slow = motion * 2.0 ** (-40 * np.arange(5))[:, None]
    fast, slowed = panda.state(*motion), panda.state(*slow)
    for n, (x, y) in enumerate(zip(fast.reduced, slowed.reduced), start=1):
        assert np.array_equal(x * 2.0 ** (-40 * n), y)


@pytest.mark.parametrize('kind', ESTIMATORS)
@pytest.mark.parametrize('step', [1e-6, 1e-9, 1e-12])
def test_tiny_steps_do_not_shake_estimators(kind, step):
    """Smooth motion sampled at any rate: rates are finite and never exceed the true ones."""
    estimator = make_estimator(kind, 2)
    for k in range(300):
        t = k * step
        motion = estimator.update(t, np.array([0.3 + 0.5 * t, np.sin(3 * t)]),
                                  np.array([0.5, 3 * np.cos(3 * t)]))
        if motion is not None:
            assert np.all(np.isfinite(motion.acceleration))
            assert np.all(np.abs(motion.velocity) <= 1.01 * np.array([0.5, 3]))
