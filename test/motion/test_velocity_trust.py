# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Velocities that are exact are used, those that do harm are not, and soon."""

import numpy as np
import pytest

from screw_kinematics.motion import (
    MotionEstimator, velocity_block, velocity_block_loops, velocity_evidence)
from screw_kinematics.motion.divided_difference import divided_difference
from screw_kinematics.motion.velocity_trust import VelocityTrust
from support.motions import acceleration_error, run, samples, sines

JOINTS = 4


def _as_floats(q, v, rng):
    return q.astype(np.float32).astype(float), v.astype(np.float32).astype(float)


def _with_noise(q, v, rng):
    return q + 1e-9 * rng.normal(size=q.shape), v + 1e-9 * rng.normal(size=q.shape)


def _as_they_are(q, v, rng):
    return q, v


@pytest.mark.parametrize('rate', [100, 500, 1000])
@pytest.mark.parametrize('seen', [_as_they_are, _as_floats, _with_noise])
@pytest.mark.parametrize('jitter', [0.0, 0.2])
def test_an_exact_velocity_is_used_and_pays(rate, seen, jitter):
    rng = np.random.default_rng(rate)
    motion = sines(5, JOINTS)
    count = int(2.5 * rate)
    stamps = np.round((np.arange(count) + jitter * rng.random(count)) / rate, 9)
    positions, velocities = seen(*motion(stamps)[:2], rng)
    estimator = MotionEstimator(JOINTS)
    error = acceleration_error(motion, *run(estimator, stamps, positions, velocities)[:2], 1.5)
    without = acceleration_error(motion, *run(MotionEstimator(JOINTS), stamps, positions)[:2], 1.5)
    assert estimator.velocity_used.all()
    assert not estimator.doubts()
    assert error < 0.4 * without


def _late(lag):
    def velocity(motion, stamps, positions, rng):
        return motion(stamps - lag)[1]
    return velocity


def _noisy_and_late(lag):
    def velocity(motion, stamps, positions, rng):
        return motion(stamps - lag)[1] + 2e-3 * rng.normal(size=positions.shape)
    return velocity


def _zero(motion, stamps, positions, rng):
    return np.zeros_like(positions)


def _missing(motion, stamps, positions, rng):
    return np.full_like(positions, np.nan)


def _differenced(*coefficients):
    """Backward differences, weighted."""
    def velocity(motion, stamps, positions, rng):
        steps = np.diff(positions, axis=0, prepend=positions[:1]) / (stamps[1] - stamps[0])
        weighted = [c * np.roll(steps, k, axis=0) for k, c in enumerate(coefficients)]
        return np.sum(weighted, axis=0)
    return velocity


WRONG = {
    'late 5 ms': _late(5e-3), 'late 20 ms': _late(0.02), 'late 50 ms': _late(0.05),
    'noisy, late 5 ms': _noisy_and_late(5e-3), 'noisy, late 50 ms': _noisy_and_late(0.05),
    'zero': _zero, 'missing': _missing, 'differenced': _differenced(1.0),
    'differenced, second order': _differenced(1.5, -0.5),
    'differenced, third order': _differenced(11 / 6, -7 / 6, 1 / 3),
    'differenced, mean of four': _differenced(0.25, 0.25, 0.25, 0.25),
}


@pytest.mark.parametrize(('rate', 'resolution'), [
    (100, 1e-6), (100, 1e-4), (250, 0.0), (500, 1e-4), (1000, 1e-4), (1000, 1.5e-3)])
def test_no_wrong_velocity_does_harm(rate, resolution):
    motion = sines(8, JOINTS)
    rng = np.random.default_rng(rate)
    if resolution:
        stamps, positions = samples(motion, rate, 2.0, 3, resolution=resolution)
    else:
        stamps = np.arange(2 * rate) / rate
        positions = motion(stamps)[0]
    without = acceleration_error(motion, *run(MotionEstimator(JOINTS), stamps, positions)[:2], 0.3)
    harm = {}
    for name, wrong in WRONG.items():
        velocities = wrong(motion, stamps, positions, rng)
        harm[name] = acceleration_error(motion, *run(
            MotionEstimator(JOINTS), stamps, positions, velocities)[:2], 0.3) / without
    assert max(harm.values()) < 1.1, harm


def test_true_velocities_that_tell_nothing_do_no_harm():
    motion = sines(8, JOINTS, highest=5.0)
    stamps, positions = samples(motion, 100, 3.0, 3, resolution=1e-6)
    rng = np.random.default_rng(1)
    noisy = motion(stamps)[1] + 2e-3 * rng.normal(size=positions.shape)
    error, without = (
        acceleration_error(motion, *run(MotionEstimator(JOINTS), stamps, positions, v)[:2])
        for v in (noisy, None))
    assert error < 1.1 * without


def _frozen(good, k):
    return np.where(np.arange(len(good))[:, None] < k, good, good[k])


def _to_zero(good, k):
    return np.where(np.arange(len(good))[:, None] < k, good, 0.0)


def _turned(good, k):
    return np.where(np.arange(len(good))[:, None] < k, good, -good)


def _behind(good, k):
    return np.where(np.arange(len(good))[:, None] < k, good, np.roll(good, 25, axis=0))


@pytest.mark.parametrize('gone', [_frozen, _to_zero, _turned, _behind])
@pytest.mark.parametrize('rate', [250, 1000])
def test_a_velocity_that_goes_wrong_is_dropped_within_a_fifth_of_a_second(gone, rate):
    motion = sines(9, JOINTS)
    stamps, positions = samples(motion, rate, 2.0, 9, resolution=1e-5)
    rng = np.random.default_rng(4)
    good = motion(stamps)[1] + 2e-3 * rng.normal(size=positions.shape)
    k = int(1.5 * rate)
    velocities = gone(good, k)
    estimator = MotionEstimator(JOINTS)
    for i, stamp in enumerate(stamps.tolist()):
        estimator.update(stamp, positions[i], velocities[i])
        if i == k:
            assert estimator.velocity_used.all()
        if stamp > stamps[k] + 0.2:
            assert not estimator.velocity_used.any()


@pytest.mark.parametrize('gap', [0.0, 0.03])
def test_velocities_that_are_missing_now_and_then_are_used_all_the_same(gap):
    motion = sines(9, JOINTS)
    stamps, positions = samples(motion, 500, 3.0, 9, resolution=1e-4)
    rng = np.random.default_rng(4)
    good = motion(stamps)[1] + 2e-3 * rng.normal(size=positions.shape)
    good[rng.random(len(good)) < 0.02] = np.nan
    good[(stamps % 0.7) < gap] = np.nan
    error, without = (
        acceleration_error(motion, *run(MotionEstimator(JOINTS), stamps, positions, v)[:2])
        for v in (good, None))
    assert error < 0.8 * without


def test_standstill_proves_nothing():
    trust = VelocityTrust(1)
    rng = np.random.default_rng(2)
    for k in range(2000):
        trust.push(1e-3 * k, 1e-4 * np.round(rng.normal(size=1)), 1e-3 * rng.normal(size=1))
    assert trust.ratio is None
    assert not (trust.lagging | trust.differenced | trust.idle).any()


def test_a_divided_difference_of_any_order_vanishes_on_polynomials_of_less():
    rng = np.random.default_rng(3)
    for order in (2, 4, 6):
        t = np.cumsum(rng.uniform(0.5, 1.5, (20, order + 1)), axis=1)
        c = divided_difference(t)
        np.testing.assert_allclose((c * c).sum(axis=1), 1.0)
        for power in range(order):
            np.testing.assert_allclose(
                (c * t**power).sum(axis=1), 0.0, atol=1e-12 * t.max() ** power)


@pytest.mark.parametrize('compiled', [False, True])
def test_loops_measure_as_arrays_do(compiled):
    measure = velocity_block_loops.measure
    if compiled:
        measure = pytest.importorskip('numba').njit(measure, error_model='numpy')
    for t, q, v in blocks_of_samples(25 if compiled else 100):
        np.testing.assert_allclose(
            measure(t, q, v), velocity_block.measure(t, q, v), rtol=1e-6, atol=1e-16)


def test_machine_code_judges_as_lists_do():
    pytest.importorskip('numba')
    from screw_kinematics.motion.compiled_admission import judge
    known = np.zeros((velocity_evidence.ROWS, 3))
    known[velocity_evidence.RATIO] = np.inf
    changes = 0
    for number, block in enumerate(blocks_of_samples(25)):
        expected, changed = velocity_evidence.judge(*block, known, number)
        known, changed_too = judge(*block, known, number)
        np.testing.assert_allclose(known, expected, rtol=1e-6, atol=1e-16)
        assert changed == changed_too
        changes += changed
    assert changes > 0


def blocks_of_samples(step):
    """Yield stamps, positions and velocities with all that is judged in them."""
    rng = np.random.default_rng(1)
    t = np.cumsum(1e-3 * (1.0 + 0.1 * rng.random(1200)))
    angle = 3.0 * t[:, None] + np.arange(3)
    vigour = np.array([1.0, 0.5, 0.0])
    q = np.round(vigour * np.sin(angle), 5) + 1e-6 * vigour * rng.normal(size=angle.shape)
    v = vigour * (3.0 * np.cos(angle) + 1e-3 * rng.normal(size=angle.shape))
    v[900:, 0] *= -1.0
    v[600, 1] = np.nan
    for block, begin in enumerate(range(0, 1100, step)):
        rows = slice(begin, begin + 36 + block % 2)
        yield t[rows], q[rows], v[rows]
