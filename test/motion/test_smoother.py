# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Laws of the smoother of recorded samples."""

import numpy as np
import pytest

from screw_kinematics.errors import InvalidValueError, ShapeError
from screw_kinematics.motion import MotionEstimator, smooth
from support.motions import acceleration_error, run, samples, sines

RATE = 250


def error_of(motion, result, settled=0.3):
    late = (result.stamps > settled) & (result.stamps < result.stamps[-1] - settled)
    return np.sqrt(np.mean((result.acceleration - motion(result.stamps)[2])[late] ** 2))


def test_exact_on_cubics():
    stamps = np.cumsum(np.random.default_rng(0).uniform(0.5, 1.5, 1500)) / RATE
    cubic = np.polynomial.Polynomial([0.3, 0.4, -0.3, 0.05])
    result = smooth(stamps, cubic(stamps)[:, None])
    middle = slice(300, -300)
    for order, row in enumerate([result.position, result.velocity, result.acceleration]):
        truth = cubic.deriv(order)(result.stamps)
        np.testing.assert_allclose(row[middle, 0], truth[middle], atol=10.0 ** (3 * order - 10))


def test_better_than_online_and_consistent():
    motion = sines(3, 5)
    stamps, positions = samples(motion, RATE, 8.0, 3)
    result = smooth(stamps, positions)
    claimed, states, _ = run(MotionEstimator(5), stamps, positions)
    assert error_of(motion, result) < 0.5 * acceleration_error(motion, claimed, states)
    inner = slice(200, -200)
    errors = result.acceleration - motion(result.stamps)[2]
    ratio = np.mean((errors**2 / result.variance[:, 2])[inner])
    assert 0.2 < ratio < 1.6


def test_pieces_leave_no_seam(monkeypatch):
    motion = sines(4, 2)
    stamps, positions = samples(motion, RATE, 12.0, 4)
    whole = smooth(stamps, positions)
    monkeypatch.setattr('screw_kinematics.motion.smoother.PIECE', 500)
    pieces = smooth(stamps, positions)
    apart = np.abs(pieces.acceleration - whole.acceleration) / np.sqrt(whole.variance[:, 2])
    assert apart.max() < 0.1


def test_velocity_helps_and_a_wrong_one_does_no_harm():
    motion = sines(5, 3)
    stamps, positions = samples(motion, RATE, 6.0, 5, resolution=1e-4)
    rng = np.random.default_rng(5)
    good = motion(stamps)[1] + 2e-3 * rng.normal(size=positions.shape)
    without = error_of(motion, smooth(stamps, positions))
    assert error_of(motion, smooth(stamps, positions, good)) < 0.9 * without
    for wrong in (0 * good, -good, np.full_like(good, np.nan), motion(stamps - 5e-3)[1]):
        assert error_of(motion, smooth(stamps, positions, wrong)) < 1.1 * without


def test_bad_samples_are_left_out_and_gaps_divide():
    motion = sines(6, 2)
    stamps, positions = samples(motion, RATE, 6.0, 6)
    clean = smooth(np.delete(stamps, slice(700, 900)), np.delete(positions, slice(700, 900), 0))
    messy_stamps = np.insert(stamps, 300, stamps[299])
    messy = np.insert(positions, 300, positions[299], axis=0)
    messy_stamps, messy = np.insert(messy_stamps, 400, stamps[399]), np.insert(messy, 400, 9., 0)
    keep = np.r_[:702, 902:len(messy)]
    result = smooth(messy_stamps[keep], messy[keep])
    assert result.used.sum() == len(result.stamps) == len(clean.stamps)
    np.testing.assert_allclose(result.acceleration, clean.acceleration, rtol=1e-9)


@pytest.mark.parametrize('rate, together, repeated', [
    (1000, 1, False), (1000, 3, False), (250, 2, False), (100, 1, False), (1000, 1, True),
    (100, 1, True)])
def test_odd_readings_cost_little(rate, together, repeated):
    motion = sines(7, 3, 1.0)
    stamps, positions = samples(motion, rate, 8.0, 8, 1e-4)
    odd = positions.copy()
    for j in range(3):
        for begin in range(rate // 2 + 11 * j, len(stamps) - rate // 2, rate // 2):
            rows = slice(begin, begin + together)
            odd[rows, j] = positions[begin - 1, j] if repeated else positions[rows, j] + 0.015
    assert error_of(motion, smooth(stamps, odd)) < 1.2 * error_of(
        motion, smooth(stamps, positions))


def test_continuous_joint_is_unwrapped():
    stamps = np.arange(1000) / RATE
    wrapped = (3.0 * stamps + np.pi) % (2 * np.pi) - np.pi
    result = smooth(stamps, wrapped[:, None], continuous=[True])
    np.testing.assert_allclose(result.position[:, 0], 3.0 * stamps, atol=1e-9)
    np.testing.assert_allclose(result.velocity[100:-100, 0], 3.0, atol=1e-7)


def test_stamps_a_little_before_their_reading_are_no_period_after_the_one_before():
    motion, rng = sines(2, 7), np.random.default_rng(2)
    ticks = np.arange(2000) / RATE
    positions = np.round(motion(ticks)[0] / 1e-6) * 1e-6
    stamps = ticks + 1e-6 * rng.normal(size=len(ticks))
    settled = slice(100, -100)
    late, regular = (np.sqrt(np.mean((smooth(t, positions).acceleration
                                      - motion(ticks)[2])[settled]**2)) for t in (stamps, ticks))
    assert late < 1.2 * regular


@pytest.mark.parametrize('value', [0.0, 1.5])
def test_a_velocity_that_never_changes_says_nothing(value):
    """Not that the joint does not accelerate, however certain a constant seems."""
    stamps = np.arange(1000) / 200
    positions = np.round(np.sin(3 * stamps) / 1e-4)[:, None] * 1e-4
    alone = smooth(stamps, positions)
    beside = smooth(stamps, positions, np.full_like(positions, value))
    np.testing.assert_array_equal(beside.acceleration, alone.acceleration)


def test_stamps_in_other_units_are_named():
    """Nanoseconds, say, which recordings have."""
    with pytest.raises(InvalidValueError, match=r'stamps, in s, are 1e\+07 apart, and max_gap is'):
        smooth(np.arange(100) * 10_000_000, np.zeros((100, 1)))


def test_wrong_arguments_are_named():
    with pytest.raises(ShapeError, match=r'positions: expected shape \(3, n\), got \(2, 1\)'):
        smooth(np.arange(3), np.zeros((2, 1)))
    with pytest.raises(ShapeError, match=r'velocities: expected shape \(3, 1\)'):
        smooth(np.arange(3), np.zeros((3, 1)), np.zeros((3, 2)))
    with pytest.raises(InvalidValueError, match=r"stamps must be an array of numbers, got \['a"):
        smooth(['a'], [[1.0]])
    with pytest.raises(ShapeError, match=r'stamps: expected shape \(N,\), got \(\)'):
        smooth(None, None)
    with pytest.raises(InvalidValueError, match='no run of at least 8 good ones; '
                       '3 of 3 refused: run_too_short$'):
        smooth(np.arange(3) * 0.01, np.zeros((3, 1)))
    backwards = 'no run of .*; 952 of 1000 refused: stamp_not_increasing; .*too_short'
    with pytest.raises(InvalidValueError, match=backwards):
        smooth(np.arange(1000)[::-1] * 0.01, np.zeros((1000, 1)))


@pytest.mark.parametrize('period', [0.2, 0.25, 0.4, 1.0, 2.0])
def test_slow_samples(period):
    stamps = np.arange(60) * period
    result = smooth(stamps, np.sin(0.3 * stamps)[:, None], max_gap=3 * period)
    assert np.isfinite(result.variance).all()
    error = result.velocity[:, 0] - 0.3 * np.cos(0.3 * stamps)
    assert np.sqrt(np.mean(error**2)) < 0.01 * 0.3


@pytest.mark.parametrize('pause', [0.24, 0.9])
def test_pauses_within_dense_samples(pause):
    periods = np.full(1500, 1e-3)
    periods[[3, 700, 1100]] = pause
    stamps = np.cumsum(periods)
    result = smooth(stamps, np.sin(0.3 * stamps)[:, None], max_gap=2 * pause)
    assert result.used.all()
    np.testing.assert_allclose(result.velocity[:, 0], 0.3 * np.cos(0.3 * stamps),
                               atol=0.01 * 0.3)


@pytest.mark.parametrize('noise', [1e-1, 1e-2])
@pytest.mark.parametrize('pulse', [2.0, 6.0])
def test_noisy_samples_from_the_start_on(pulse, noise):
    """With all the future in view no worse than with 0.2 s of it, in motion from the start."""
    stamps = np.arange(800) * 0.01
    signal = np.sin(pulse * stamps) + 0.5 * np.sin(0.55 * pulse * stamps)
    positions = signal + noise * np.random.default_rng(0).normal(size=800)
    at, states, _ = run(MotionEstimator(1, delay=0.2, max_velocity=1000.0), stamps,
                        positions[:, None])
    result = smooth(stamps, positions[:, None], max_velocity=1000.0)
    truth = pulse * (np.cos(pulse * at) + 0.275 * np.cos(0.55 * pulse * at))
    smoothed = np.interp(at, result.stamps, result.velocity[:, 0]) - truth
    assert np.std(smoothed) < np.std(states[:, 1, 0] - truth)


@pytest.mark.parametrize('noise', [1e-1, 1e-2])
@pytest.mark.parametrize('pulse', [2.0, 6.0])
def test_noise_is_plausible_by_default_and_is_smoothed_better_than_online(pulse, noise):
    """Jumps of noise are no outliers; with all the future in view the error is well below."""
    stamps = np.arange(800) * 0.01
    signal = np.sin(pulse * stamps) + 0.5 * np.sin(0.55 * pulse * stamps)
    smoothed, online = [], []
    for seed in range(4):
        positions = signal + noise * np.random.default_rng(seed).normal(size=800)
        result = smooth(stamps, positions[:, None])
        assert result.used.mean() > 0.995
        at, states, _ = run(MotionEstimator(1, delay=0.2, max_velocity=1000.0), stamps,
                            positions[:, None])
        truth = pulse * (np.cos(pulse * at) + 0.275 * np.cos(0.55 * pulse * at))
        smoothed.append(np.std(np.interp(at, result.stamps, result.velocity[:, 0]) - truth))
        online.append(np.std(states[:, 1, 0] - truth))
    assert np.mean(smoothed) < 0.85 * np.mean(online)


def test_one_jump_among_quiet_samples_is_still_refused():
    stamps = np.arange(400) * 0.01
    positions = np.sin(stamps) + 1e-4 * np.random.default_rng(1).normal(size=400)
    positions[200] += 0.5
    result = smooth(stamps, positions[:, None])
    assert not result.used[200]
    assert result.used.sum() == 399


@pytest.mark.parametrize('noise', [1e-4, 1e-2, 1e-1])
@pytest.mark.parametrize('rate', [50, 100, 500])
def test_no_worse_than_online_at_any_delay(rate, noise):
    """Of a single sine a joint, velocity and acceleration; over several paces by a third."""
    pulses = 2.0 * np.pi * np.array([0.31, 0.7, 1.0, 1.7, 2.3, 3.0])
    random = np.random.default_rng([0, rate])
    stamps, phases = np.arange(6 * rate) / rate, random.uniform(0.0, 2.0 * np.pi, 6)
    angles = stamps[:, None] * pulses + phases
    positions = np.sin(angles) + noise * random.normal(size=angles.shape)

    def errors(at, velocity, acceleration):
        inner, angles = (at > 1.5) & (at < 4.5), at[:, None] * pulses + phases
        return (np.std((velocity - pulses * np.cos(angles))[inner], axis=0),
                np.std((acceleration + pulses**2 * np.sin(angles))[inner], axis=0))

    result = smooth(stamps, positions)
    smoothed = errors(result.stamps, result.velocity, result.acceleration)
    online = []
    for delay in (0.05, 0.1, 0.2):
        at, states, _ = run(MotionEstimator(6, delay=delay, max_velocity=1e5), stamps, positions)
        online.append(errors(at, states[:, 1], states[:, 2]))
    ratios = np.array(smoothed) / np.min(online, axis=0)
    assert ratios.max() < 1.0
    assert (np.exp(np.mean(np.log(ratios), axis=1)) < 0.7).all()


def test_exact_positions_whose_jerk_jumps_are_followed_better_than_online():
    dt, stamps = 1e-3, np.arange(4000) * 1e-3
    acceleration = np.abs((stamps[:, None] * [1.3, 2.1]) % 2.0 - 1.0) - 0.5
    first, second = acceleration[:-1], acceleration[1:]
    start = np.zeros((1, 2))
    velocity = np.concatenate([start, np.cumsum(0.5 * dt * (first + second), axis=0)])
    steps = velocity[:-1] * dt + dt**2 / 6.0 * (2.0 * first + second)
    positions = np.concatenate([start, np.cumsum(steps, axis=0)])
    result = smooth(stamps, positions)
    at, states, _ = run(MotionEstimator(2, delay=0.05), stamps, positions)
    inner = slice(500, -500)
    online = states[:, 2] - acceleration[np.rint(at / dt).astype(int)]
    smoothed = result.acceleration - acceleration
    assert np.std(smoothed[inner]) < 0.5 * np.std(online[inner])


@pytest.mark.parametrize('rate', [100, 250, 500])
def test_sudden_stops_are_followed_no_worse_than_online(rate):
    """That the noise seems to fall from filter to filter there does not make it coloured."""
    random, stamps = np.random.default_rng(rate), np.arange(3 * rate) / rate
    speed, end = random.uniform(0.5, 1.5, 6), random.uniform(1.2, 1.8, 6)
    lasting = random.uniform(0.01, 0.03, 6)

    def braking(at):
        return np.clip(at[:, None] - (end - lasting), 0.0, lasting)

    def error(at, acceleration):
        taken, near = braking(at), (at > 0.9) & (at < 2.1)
        truth = np.where((taken > 0.0) & (taken < lasting), -speed / lasting, 0.0)
        return np.sqrt(np.mean((acceleration - truth)[near] ** 2))

    taken = braking(stamps)
    positions = speed * (np.minimum(stamps[:, None], end - lasting) + taken
                         - taken**2 / (2.0 * lasting)) + 1e-6 * random.normal(size=taken.shape)
    result = smooth(stamps, positions)
    online = []
    for delay in (0.02, 0.05, 0.1):
        at, states, _ = run(MotionEstimator(6, delay=delay), stamps, positions)
        online.append(error(at, states[:, 2]))
    assert error(result.stamps, result.acceleration) < 0.95 * min(online)


def test_coloured_noise_is_not_taken_for_motion():
    """Of four times the samples, with noise on lines between, little more than twice the error."""
    harm = []
    for seed in range(3):
        motion, few, many = sines(seed, 4), np.arange(1000) / 125, np.arange(3997) / 500
        noise = 1e-5 * np.random.default_rng(seed).standard_normal((1000, 4))
        alike = np.stack([np.interp(many, few, column) for column in noise.T], axis=-1)
        harm.append(error_of(motion, smooth(many, motion(many)[0] + alike))
                    / error_of(motion, smooth(few, motion(few)[0] + noise)))
    assert np.mean(harm) < 2.3, harm


def test_an_exact_velocity_is_believed():
    motion = sines(7, 3)
    stamps = np.arange(1200) * 5e-3
    positions = np.round(motion(stamps)[0] * 1e7) * 1e-7
    without = error_of(motion, smooth(stamps, positions))
    assert error_of(motion, smooth(stamps, positions, motion(stamps)[1])) < 0.02 * without


def test_a_wrong_velocity_without_noise_is_not_believed():
    """No noise makes it seem certain, in whatever units it is, and of whichever joint."""
    motion = sines(7, 3)
    stamps = np.arange(1200) * 5e-3
    true, noise = motion(stamps), 1e-4 * np.random.default_rng(0).standard_normal((1200, 3))
    alone = smooth(stamps, true[0] + noise)
    for wrong in (true[0], np.rad2deg(true[1]), true[1] / (2 * np.pi), 1e-3 * true[1], -true[1],
                  2 * true[1], 0.1 + true[1], true[2], true[1][:, ::-1], motion(stamps + 0.03)[1],
                  np.cumsum(np.full_like(noise, 1e-12), axis=0),
                  np.where(stamps[:, None] < 3.0, 0.0, true[1])):
        beside = smooth(stamps, true[0] + noise, wrong)
        assert error_of(motion, beside) < 1.1 * error_of(motion, alone)
        late = slice(60, -60)
        apart = [np.std((r.velocity - true[1])[late]) for r in (beside, alone)]
        assert apart[0] < 1.25 * apart[1]
