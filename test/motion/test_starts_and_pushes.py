# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Beginnings of a run, where little is known, and pushes that position and velocity agree on."""

import numpy as np
import pytest

from screw_kinematics.motion import MotionEstimator

LARGEST = 4.0
"""Largest acceleration of the swings, rad/s^2."""


def swings(stamps, seed, n=7):
    """Return positions, velocities and accelerations, (N, n), of swings at 0.2 to 1 Hz."""
    rng = np.random.default_rng(seed)
    w, phase = 2 * np.pi * rng.uniform(0.2, 1.0, n), rng.uniform(0, 2 * np.pi, n)
    angle = w * np.asarray(stamps)[:, None] + phase
    return LARGEST / w**2 * np.sin(angle), LARGEST / w * np.cos(angle), -LARGEST * np.sin(angle)


def accelerations(stamps, positions, velocities=None, **options):
    """Return the claimed instants, (N,), and accelerations, (N, n), of an estimator."""
    estimator = MotionEstimator(positions.shape[1], **options)
    motions = [estimator.update(t, q, None if velocities is None else velocities[k])
               for k, (t, q) in enumerate(zip(stamps, positions))]
    told = [m for m in motions if m is not None]
    return np.array([m.stamp for m in told]), np.array([m.acceleration for m in told])


@pytest.mark.parametrize('step', [1e-6, 1e-5, 1e-4])
@pytest.mark.parametrize('pause', [0.01, 0.06, 0.1, 0.24])
@pytest.mark.parametrize('rate', [100, 250, 500, 1000])
def test_a_run_that_begins_tells_no_noise(rate, pause, step):
    rng = np.random.default_rng([rate, int(1e3 * pause)])
    stamps = 0.3 + np.append(0.0, pause + np.arange(0.5 * rate) / rate)
    positions = swings(stamps, rate)[0]
    positions = step * np.round((positions + 0.3 * step * rng.normal(size=positions.shape)) / step)
    _, told = accelerations(stamps, positions)
    assert np.abs(told).max() < 2 * LARGEST


@pytest.mark.parametrize('delay', [0.0, 0.02])
@pytest.mark.parametrize('rate, jitter', [(1000, 3e-4), (1000, 1e-4), (500, 3e-4), (250, 1e-4)])
@pytest.mark.parametrize('pause', [0.01, 0.03, 0.06, 0.12, 0.24])
def test_a_run_that_begins_with_late_stamps_tells_no_noise(pause, rate, jitter, delay):
    """What few samples tell of noise is not taken at its word."""
    for before in (1, 3):
        rng = np.random.default_rng([before, rate, int(1e3 * pause)])
        read = 0.3 + np.append(np.arange(before) / rate,
                               (before - 1) / rate + pause + np.arange(0.3 * rate) / rate)
        positions, velocities, _ = swings(read, rate + before)
        velocities = velocities + 1e-3 * rng.normal(size=positions.shape)
        positions = 1e-6 * np.round(positions / 1e-6)
        stamps = read + rng.exponential(jitter, read.shape)
        for measured in (None, velocities):
            _, told = accelerations(stamps, positions, measured, delay=delay)
            assert np.abs(told).max() < 2 * LARGEST


@pytest.mark.parametrize('still', [False, True])
def test_what_is_told_of_a_beginning_is_the_same_in_any_unit(still):
    rng = np.random.default_rng(5)
    stamps = np.arange(300) / 1000
    positions = 0.0 * stamps[:, None] if still else swings(stamps, 5, 1)[0]
    steps = np.round(positions / 1e-4 + 0.3 * rng.normal(size=positions.shape))
    first = [accelerations(stamps, step * steps)[0][0] for step in (1e-4, 1e-4 / 64)]
    assert first[0] == first[1]


def test_what_is_clear_of_noise_is_told_at_once():
    stamps = np.arange(40) / 1000
    claimed, told = accelerations(stamps, swings(stamps, 5)[0])
    assert claimed[0] < 0.02
    assert np.abs(told - swings(claimed, 5)[2]).max() < 0.1 * LARGEST


def test_noise_keeps_a_run_silent_for_a_tenth_of_a_second_and_no_longer():
    rng = np.random.default_rng(4)
    stamps = np.arange(200) / 1000
    claimed, _ = accelerations(stamps, 1e-4 * rng.normal(size=(200, 7)))
    assert claimed[0] == pytest.approx(0.1, abs=2e-3)
    assert len(claimed) == 200 - np.searchsorted(stamps, claimed[0] - 1e-9)


def pushed(stamps, begin, size):
    """Return position and velocity, (N, 1), of a joint that accelerates from an instant on."""
    since = np.clip(stamps - begin, 0.0, None)[:, None]
    even = 0.3 * stamps[:, None]
    return 0.5 * size * since**2 + even, size * since + 0.3


@pytest.mark.parametrize('late', [0.1, 0.5, 0.9])
def test_a_push_that_position_and_velocity_agree_on_is_followed_at_once(late):
    rng = np.random.default_rng(1)
    stamps = np.arange(1500) / 1000
    size, begin = 5.0, 1.0 + 1e-3 * late
    positions, velocities = pushed(stamps, begin, size)
    velocities += 1e-9 * rng.normal(size=velocities.shape)
    error = {}
    for known, measured in (('both', velocities), ('position', None)):
        claimed, told = accelerations(stamps, positions, measured)
        near = (claimed > begin + 1e-3) & (claimed < begin + 0.02)
        error[known] = np.sum((told[near, 0] - size)**2)
        settled = claimed > begin + 0.02
        assert np.abs(told[settled, 0] - size).max() < 0.01 * size
    assert error['both'] < 0.95 * error['position']


@pytest.mark.parametrize('size', [18.0, 50.0])
@pytest.mark.parametrize('rate', [600, 1000])
def test_how_hard_a_joint_sets_off_is_not_overstated(rate, size):
    """Scores of a joint at rest tell nothing of its motion: no filter is chosen by one sample."""
    most = []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        stamps = np.arange(rate) / rate
        since = stamps - 0.8 - rng.uniform(0.0, 1.0 / rate)
        hard = np.clip(since, 0.0, 0.02)
        positions = size * (0.5 * hard**2 + 0.02 * np.clip(since - 0.02, 0.0, None))
        positions += 1e-6 * rng.normal(size=rate)
        claimed, told = accelerations(stamps, positions[:, None])
        most.append(np.abs(told[claimed > 0.79]).max() / size)
    assert np.mean(most) < 1.35 and max(most) < 2.0


@pytest.mark.parametrize('wrong', ['position', 'repeated', 'differenced', 'filtered'])
@pytest.mark.parametrize('offset', [1e-3, -0.015])
def test_one_odd_sample_is_no_push_whatever_the_velocity(offset, wrong):
    rng = np.random.default_rng(2)
    stamps = np.arange(1500) / 1000
    positions, velocities, truth = swings(stamps, 6)
    positions = 1e-5 * np.round(positions / 1e-5 + 0.3 * rng.normal(size=positions.shape))
    velocities = velocities + 1e-3 * rng.normal(size=positions.shape)
    if wrong == 'repeated':
        positions[1000, 2], velocities[1000, 2] = positions[999, 2], velocities[999, 2]
    else:
        positions[1000, 2] += offset
    if wrong in ('differenced', 'filtered'):
        velocities[1:] = np.diff(positions, axis=0) * 1000
    if wrong == 'filtered':
        for k in range(1, len(velocities)):
            velocities[k] = velocities[k - 1] + 0.17 * (velocities[k] - velocities[k - 1])
    claimed, told = accelerations(stamps, positions, velocities)
    near = (claimed > 0.99) & (claimed < 1.1)
    truth = swings(claimed, 6)[2]
    assert np.abs(told - truth)[near].max() < 0.5


def test_exact_simulators_are_known_exactly():
    rng = np.random.default_rng(3)
    stamps = np.arange(1500) / 1000
    positions, velocities, _ = swings(stamps, 7)
    velocities = velocities + 1e-9 * rng.normal(size=velocities.shape)
    claimed, told = accelerations(stamps, positions, velocities)
    error = np.abs(told - swings(claimed, 7)[2])
    assert error[claimed > 0.5].max() < 1e-3 * LARGEST
    assert np.sqrt(np.mean(error[claimed > 0.5]**2)) < 1e-5 * LARGEST
