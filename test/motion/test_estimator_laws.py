# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What holds of the default estimator whatever the robot."""

import numpy as np
import pytest

from screw_kinematics.motion import FixedKalmanFilter, MotionEstimator, SavitzkyGolay
from support.motions import acceleration_error, jumps, run, samples, sines

RATE = 500


@pytest.mark.parametrize('delay', [0.0, 0.02, 0.05])
@pytest.mark.parametrize('spread', [0.0, 0.9])
@pytest.mark.parametrize('kind', [MotionEstimator, FixedKalmanFilter])
def test_exact_on_cubics_at_any_stamps(kind, spread, delay):
    rng = np.random.default_rng(3)
    stamps = np.cumsum((1 + spread * rng.uniform(-1, 1, 2000)) / RATE)
    coefficients = np.array([[0.3, -1.0], [0.4, 0.2], [-0.3, 0.1], [0.05, -0.02]])
    cubic = [np.polynomial.Polynomial(c) for c in coefficients.T]
    positions = np.stack([p(stamps) for p in cubic], axis=-1)
    estimator = kind(2, delay=delay, regularise=False)
    claimed, states, _ = run(estimator, stamps, positions)
    for k, (order, bound) in enumerate([(0, 1e-9), (1, 1e-7), (2, 1e-5), (3, 1e-2)]):
        truth = np.stack([p.deriv(order)(claimed[-50:]) for p in cubic], axis=-1)
        np.testing.assert_allclose(states[-50:, k], truth, atol=bound)


def test_savitzky_golay_is_exact_on_quartics_at_any_stamps():
    rng = np.random.default_rng(3)
    stamps = np.cumsum((1 + 0.9 * rng.uniform(-1, 1, 300)) / RATE)
    quartic = np.polynomial.Polynomial([0.1, -0.5, 0.3, 1.0, -2.0])
    claimed, states, _ = run(SavitzkyGolay(1), stamps, quartic(stamps)[:, None])
    for order in range(4):
        np.testing.assert_allclose(
            states[:, order, 0], quartic.deriv(order)(claimed), rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize('delay', [0.0, 0.02])
def test_unbiased_at_standstill(delay):
    rng = np.random.default_rng(11)
    n = 40
    positions = 0.7 + 1e-4 * rng.normal(size=(1000, n))
    claimed, states, _ = run(MotionEstimator(n, delay=delay), np.arange(1000) / RATE, positions)
    means = states[claimed > 0.8].mean(axis=0)
    for order in range(4):
        deviation = means[order].std() / np.sqrt(n)
        assert abs((means[order] - 0.7 * (order == 0)).mean()) < 4 * deviation


@pytest.mark.parametrize('delay', [0.0, 0.02])
@pytest.mark.parametrize('measured', [False, True])
def test_covariance_is_consistent(delay, measured):
    ratios = []
    for seed in range(3):
        motion = sines(seed, 4)
        stamps, positions = samples(motion, RATE, 2.5, seed, resolution=1e-4)
        velocities = None
        if measured:
            rng = np.random.default_rng(seed)
            velocities = motion(stamps)[1] + 5e-3 * rng.normal(size=positions.shape)
        claimed, states, variances = run(
            MotionEstimator(4, delay=delay), stamps, positions, velocities)
        good = (claimed > 0.8) & np.isfinite(variances[:, 0, 0])
        error = states[good] - motion(claimed[good]).swapaxes(0, 1)
        ratios.append((error**2 / variances[good]).mean(axis=(0, 2)))
    # Normalised error squared, by order of derivative: 1 if the covariance were perfect.
    mean = np.mean(ratios, axis=0)
    assert (mean > 0.25).all() and (mean < 1.6).all(), mean


def test_invariant_to_the_scale_of_a_joint():
    motion = sines(2, 3)
    stamps, positions = samples(motion, RATE, 1.5, 2)
    scale = 2.0 ** -np.array([0, 3, 6])
    _, states, variances = run(MotionEstimator(3), stamps, positions)
    _, scaled, scaled_variances = run(MotionEstimator(3), stamps, positions * scale)
    np.testing.assert_allclose(scaled / scale, states, rtol=1e-6, atol=1e-6)
    good = np.isfinite(variances[:, 0, 0])
    np.testing.assert_allclose(
        scaled_variances[good] / scale**2, variances[good], rtol=1e-4)


def test_a_delay_is_honest_and_pays():
    motion = sines(7, 7, highest=5.0)
    stamps, positions = samples(motion, RATE, 3.0, 7)
    errors = []
    for delay in (0.0, 0.02, 0.05):
        estimator = MotionEstimator(7, delay=delay)
        claimed, states, _ = run(estimator, stamps, positions)
        np.testing.assert_allclose(claimed, stamps[-len(claimed):] - delay, atol=1e-12)
        errors.append(acceleration_error(motion, claimed, states))
    assert errors[1] < 0.6 * errors[0]
    assert errors[2] < 0.9 * errors[1]


@pytest.mark.parametrize('delay', [0.02, 0.05])
def test_instants_a_little_before_a_reading_are_no_period_after_the_one_before(delay):
    motion, rng = sines(2, 7), np.random.default_rng(2)
    ticks = np.arange(500) / 100
    positions = np.round(motion(ticks)[0] / 1e-6) * 1e-6
    errors = [acceleration_error(motion, *run(MotionEstimator(7, delay=delay), stamps,
                                              positions)[:2])
              for stamps in (ticks + 1e-6 * rng.normal(size=len(ticks)), ticks)]
    assert errors[0] < 2.0 * errors[1]


@pytest.mark.parametrize('delay', [0.0, 0.02])
@pytest.mark.parametrize('counts', [4096, 65536])
def test_positions_of_single_precision_show_the_same_steps_of_an_encoder(counts, delay):
    stamps, step = np.arange(400) / 100, 2 * np.pi / counts
    motion = sines(5, 3)
    positions = np.round(motion(stamps / 5)[0] / step) * step
    double, single = (run(MotionEstimator(3, delay=delay), stamps, given)[1]
                      for given in (positions, positions.astype(np.float32).astype(float)))
    assert np.abs(single - double).max() < 1e-2 * np.abs(double).max()


def _lagging(motion, stamps, rng):
    return motion(stamps - 5e-3)[1] + 1e-3 * rng.normal(size=motion(stamps)[1].shape)


def _zero(motion, stamps, rng):
    return np.zeros_like(motion(stamps)[1])


def _missing(motion, stamps, rng):
    return np.full_like(motion(stamps)[1], np.nan)


def _reversed(motion, stamps, rng):
    return -motion(stamps)[1]


@pytest.mark.parametrize('wrong', [_lagging, _zero, _missing, _reversed])
@pytest.mark.parametrize('delay', [0.0, 0.02])
def test_a_wrong_velocity_does_no_harm(wrong, delay):
    motion = sines(9, 7)
    rng = np.random.default_rng(9)
    stamps, positions = samples(motion, RATE, 3.0, 9)
    estimator = MotionEstimator(7, delay=delay)
    with_velocity = run(estimator, stamps, positions, wrong(motion, stamps, rng))[:2]
    without = run(MotionEstimator(7, delay=delay), stamps, positions)[:2]
    assert acceleration_error(motion, *with_velocity) < 1.1 * acceleration_error(motion, *without)
    if wrong is not _lagging:       # whose lag is found and allowed for
        assert not any(estimator.velocity_used)


def test_a_good_velocity_helps_and_a_differenced_one_is_seen_through():
    motion = sines(9, 7)
    rng = np.random.default_rng(9)
    stamps, positions = samples(motion, RATE, 3.0, 9, resolution=1e-4)
    good = motion(stamps)[1] + 2e-3 * rng.normal(size=positions.shape)
    differenced = np.gradient(positions, stamps, axis=0)
    differenced[1:] = np.diff(positions, axis=0) * RATE
    without = acceleration_error(motion, *run(MotionEstimator(7), stamps, positions)[:2])
    estimator = MotionEstimator(7)
    assert acceleration_error(motion, *run(estimator, stamps, positions, good)[:2]) < 0.8 * without
    assert any(estimator.velocity_used)
    estimator = MotionEstimator(7)
    used = run(estimator, stamps, positions, differenced)[:2]
    assert acceleration_error(motion, *used) < 1.1 * without
    assert any('differenced' in doubt for doubt in estimator.doubts())


@pytest.mark.parametrize('delay', [0.02, 0.05])
@pytest.mark.parametrize('noise', [1e-6, 1e-3])
def test_a_velocity_whose_filters_are_behind_a_jump_does_no_harm(noise, delay):
    motion = jumps(3, 7)
    stamps, positions = samples(motion, 250, 4.0, 3)
    velocities = motion(stamps)[1] + noise * np.random.default_rng(3).normal(size=positions.shape)
    errors = [acceleration_error(motion, *run(MotionEstimator(7, delay=delay), stamps, positions,
                                              measured)[:2])
              for measured in (velocities, None)]
    assert errors[0] < 1.06 * errors[1]


def test_stamps_on_arrival_of_a_periodic_sampler_are_regularised():
    motion = sines(12, 7)
    rng = np.random.default_rng(12)
    ticks = np.arange(1000) / 250
    positions = motion(ticks)[0] + 1e-6 * rng.normal(size=(1000, 7))
    stamps = ticks + 2e-4 * rng.normal(size=1000)
    estimator = MotionEstimator(7)
    regular = acceleration_error(motion, *run(estimator, stamps, positions)[:2], settled=1.5)
    given = acceleration_error(
        motion, *run(MotionEstimator(7, regularise=False), stamps, positions)[:2], settled=1.5)
    assert regular < 0.5 * given
    assert any('regular clock' in doubt for doubt in estimator.doubts())


@pytest.mark.parametrize('kind', [MotionEstimator, FixedKalmanFilter, SavitzkyGolay])
def test_never_nan_and_never_raises(kind):
    rng = np.random.default_rng(21)
    estimator = kind(2, delay=0.01)
    stamp = 0.0
    for _ in range(3000):
        stamp += rng.choice([2e-3, 2.2e-3, 1e-7, 0.0, -1e-3, 0.3, -2.0, np.nan],
                            p=[.5, .44, .01, .01, .02, .01, .005, .005])
        stamp = 0.0 if np.isnan(stamp) else stamp
        position = rng.choice([0.0, 1e-5, np.nan, 7.0, 1e300], 2, p=[.5, .46, .01, .02, .01])
        velocity = rng.choice([0.0, 0.1, np.nan, np.inf, 1e200], 2, p=[.5, .46, .02, .01, .01])
        motion = estimator.update(stamp, position, velocity if rng.random() < 0.8 else None)
        if motion is not None:
            assert np.isfinite(motion.state).all()
            if rng.random() < 0.05:
                assert np.isfinite(motion.covariance).all()


def test_results_are_read_only():
    motion = run(MotionEstimator(2), np.arange(9) / RATE, np.zeros((9, 2)))
    estimator = MotionEstimator(2)
    for k in range(9):
        motion = estimator.update(k / RATE, np.zeros(2))
    with pytest.raises(ValueError, match='read-only'):
        motion.acceleration[0] = 1.0
    with pytest.raises(ValueError, match='read-only'):
        motion.covariance[0] = 1.0
