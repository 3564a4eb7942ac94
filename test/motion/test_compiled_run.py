# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A run in machine code changes nothing: not its results, not what is refused, not the counts."""
from functools import partial
import math

from hypothesis import example, given, settings, strategies as st
import numpy as np
import pytest

from screw_kinematics.motion import MotionEstimator
from screw_kinematics.pipeline.group_motion import GroupMotion, MotionSettings

pytest.importorskip('numba')

JOINTS = 3

# What happens to a stream of samples: its name, and the number of steady samples before it.
EVENTS = ('lost', 'gap', 'repeated', 'back', 'far back', 'jump', 'nan', 'short', 'velocity on',
          'velocity off', 'one velocity off', 'absurd velocity', 'slower', 'jittering', 'reset',
          'doubts', 'words')


def stream(seed, events, period=1e-3):
    """Yield an action for the estimator ('push', 'reset', ...) and its arguments."""
    rng = np.random.default_rng(seed)
    time, jitter, measured, partly = 0.0, 0.0, seed % 2 == 1, False
    phase = rng.uniform(0, 6, JOINTS)

    def sample(stamp):
        q = 0.8 * np.sin(3 * stamp + phase) + 2.0 * stamp + 1e-5 * rng.normal(size=JOINTS)
        q[0] = math.remainder(q[0], 2 * math.pi)
        v = 2.4 * np.cos(3 * stamp + phase) + 2.0 + 1e-3 * rng.normal(size=JOINTS)
        if partly:
            v[1] = math.nan
        noise = jitter * rng.uniform(-1, 1)
        return stamp + noise, q.tolist(), v.tolist() if measured else None

    for event, count in [('start', 250), *events]:
        if event == 'lost':
            time += 2 * period
        elif event == 'gap':
            time += 0.3
        elif event in ('repeated', 'back', 'far back'):
            step = {'repeated': 0.0, 'back': 0.01, 'far back': 0.6}[event]
            yield 'push', sample(time - step)
        elif event in ('jump', 'nan', 'short'):
            stamp, q, v = sample(time + 0.5 * period)
            q[1] = {'jump': q[1] + 1.0, 'nan': math.nan, 'short': q[1]}[event]
            yield 'push', (stamp, q[:2] if event == 'short' else q, v)
        elif event.startswith('velocity'):
            measured = event == 'velocity on'
        elif event == 'one velocity off':
            partly = not partly
        elif event == 'absurd velocity':
            stamp, q, _ = sample(time + 0.5 * period)
            yield 'push', (stamp, q, [1e200, math.inf, 0.0])
        elif event == 'slower':
            period *= 1.3
        elif event == 'jittering':
            jitter = 0.02e-3 if not jitter else 0.0
        elif event == 'words':
            yield 'push', (time, ['a', 'b', 'c'], None)
        elif event != 'start':
            yield event, ()
        for _ in range(count):
            time += period
            yield 'push', sample(time)


def act(estimator, action, arguments):
    """Return the motion, or None."""
    if action == 'push':
        try:
            return estimator.update(*arguments)
        except ValueError:
            return None
    getattr(estimator, action)()
    return None


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 99), delay=st.sampled_from([0.0, 0.01]),
       regularise=st.booleans(),
       events=st.lists(st.tuples(st.sampled_from(EVENTS), st.integers(0, 60)), max_size=8))
@example(seed=1, delay=0.0, regularise=True, events=[(e, 60) for e in EVENTS])
@example(seed=1, delay=0.01, regularise=True, events=[(e, 60) for e in EVENTS])
@example(seed=2, delay=0.01, regularise=False, events=[(e, 7) for e in EVENTS + EVENTS[::-1]])
@example(seed=1, delay=0.0, regularise=True, events=[('velocity off', 1), ('velocity on', 1)] * 20)
def test_with_machine_code_or_without(seed, delay, regularise, events):
    make = partial(MotionEstimator, JOINTS, delay, regularise=regularise,
                   continuous=[True, False, False])
    compiled, plain = make(), make()
    compiled.warm_up()
    plain._use(None)
    for action, arguments in stream(seed, events):
        one, other = (act(e, action, arguments) for e in (compiled, plain))
        assert compiled.last_outcome == plain.last_outcome
        assert (one is None) == (other is None)
        if one is not None and other is not None:
            assert one.stamp == pytest.approx(other.stamp, abs=1e-12)
            for row in range(4):
                np.testing.assert_allclose(
                    one.state[row], other.state[row], rtol=1e-7, atol=1e-7 * 20**row)
    assert compiled.refusals == plain.refusals and compiled.restarts == plain.restarts
    assert compiled.doubts() == plain.doubts()
    np.testing.assert_array_equal(compiled.velocity_used, plain.velocity_used)


@pytest.mark.parametrize('delay', [0.0, 0.02])
@pytest.mark.parametrize('measured', [False, True])
@pytest.mark.parametrize('jitter', [0.0, 20e-6])
def test_steady_samples_run_in_machine_code(delay, measured, jitter):
    rng = np.random.default_rng(1)
    estimator = MotionEstimator(JOINTS, delay)
    estimator.warm_up()
    swift = steady = 0
    for k in range(3000):
        t = 1e-3 * k
        q = np.sin(t + np.arange(JOINTS)) + 1e-5 * rng.normal(size=JOINTS)
        v = np.cos(t + np.arange(JOINTS)) + 1e-3 * rng.normal(size=JOINTS)
        estimator.update(t + jitter * rng.normal(), q, v if measured else None)
        swift += k >= 1000 and estimator._run.active
        steady += k >= 1000 and estimator._bank.steady is not None
    assert steady > (0.9 if measured else 0.99) * 2000 and swift > 0.97 * steady


@pytest.mark.parametrize('delay', [0.0, 0.02])
@pytest.mark.parametrize('compiled', [False, True])
def test_a_motion_stays_as_it_is(delay, compiled):
    rng = np.random.default_rng(2)
    first, second = MotionEstimator(JOINTS, delay), MotionEstimator(JOINTS, delay)
    for estimator in first, second:
        estimator.warm_up()
        if not compiled:
            estimator._use(None)
    kept = []
    for k in range(1000):
        q = np.sin(2e-3 * k + np.arange(JOINTS)) + 1e-5 * rng.normal(size=JOINTS)
        late, at_once = first.update(1e-3 * k, q), second.update(1e-3 * k, q)
        if k > 600 and k % 7 == 0:
            kept.append((late, at_once, late.state.copy(), at_once.covariance))
    for late, at_once, state, covariance in kept:
        np.testing.assert_array_equal(late.state, state)
        np.testing.assert_array_equal(late.state, at_once.state)
        np.testing.assert_array_equal(late.covariance, covariance)


@pytest.mark.parametrize('delay', [0.0, 0.02])
@pytest.mark.parametrize('order', [1, 2, 3, 4])
def test_groups_give_the_estimates_in_a_row(order, delay):
    compiled, plain = (
        GroupMotion(MotionSettings(delay=delay), [False] * JOINTS, order, compiled=c)
        for c in (True, False))
    plain.estimator._use(None)
    rng = np.random.default_rng(3)
    for k in range(900):
        q = (np.sin(2e-3 * k + np.arange(JOINTS)) + 1e-5 * rng.normal(size=JOINTS)).tolist()
        v = (2 * np.cos(2e-3 * k + np.arange(JOINTS)) + 1e-3 * rng.normal(size=JOINTS)).tolist()
        one, other = (group.update(10**18 + 10**6 * k, q, v) for group in (compiled, plain))
        assert (one is None) == (other is None)
    assert compiled.estimator._run.active and compiled.stamp_ns == plain.stamp_ns
    assert len(one) == (order + 1) * JOINTS
    np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-4)
    np.testing.assert_array_equal(
        compiled.motion.state[:min(order, 3) + 1].ravel(), one[:4 * JOINTS])
