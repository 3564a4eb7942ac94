# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Whatever stamps say, the motion is nearly that of readings stamped with their true ticks."""

import numpy as np
import pytest
from screw_kinematics.core.readings import Readings
from screw_kinematics.errors import Reason
from screw_kinematics.motion import MotionEstimator, smooth
from support import stamping
from support.motions import sines

JOINTS = 4
SETTLED = 0.8


def motion_of(seed):
    return sines(seed, JOINTS)


def arrival(rate, mean):
    def messages(motion, seed):
        rng = np.random.default_rng(seed)
        return stamping.on_arrival(*stamping.device(motion, rate, 3.0, seed), rng, mean)
    return messages


def reader(device_rate, rate):
    def messages(motion, seed):
        rng = np.random.default_rng(seed)
        return stamping.by_reader(*stamping.device(motion, device_rate, 3.0, seed), rng, rate)
    return messages


def lossy(motion, seed):
    rng = np.random.default_rng(seed)
    return stamping.with_losses(arrival(500, 3e-4)(motion, seed), rng, 0.05)


def stalling(motion, seed):
    return stamping.with_stalls(arrival(500, 1e-4)(motion, seed), 0.025, 0.8)


def bursts(motion, seed):
    return stamping.in_bursts(arrival(500, 5e-5)(motion, seed), 4)


def clock_set(motion, seed):
    messages = arrival(500, 1e-6)(motion, seed)
    return stamping.with_clock_set(stamping.with_clock_set(messages, 5e-3, 1.2), -1e-2, 2.2)


WAYS = {
    # messages, price at no delay and at 20 ms over true stamps
    'on arrival, 1 kHz': (arrival(1000, 3e-4), 1.25, 1.35),
    'on arrival, 500 Hz, late': (arrival(500, 1e-3), 1.25, 1.45),
    'on arrival, 100 Hz': (arrival(100, 5e-4), 1.45, 1.6),
    'reader, 1 kHz of 1 kHz': (reader(1000, 1000), 1.25, 1.5),
    'held, 500 Hz at 1 kHz': (reader(500, 1000), 1.4, 1.5),
    'lost messages': (lossy, 1.25, 1.35),
    'stalls': (stalling, 1.4, 1.7),
    'bursts of four': (bursts, 1.3, 1.8),
    'clock set': (clock_set, 1.25, 1.4),
}


def error(motion, messages, delay, allowed):
    """Return the RMS error of the acceleration, by the best constant latency of those allowed."""
    estimator = MotionEstimator(JOINTS, delay)
    offset = messages.stamps - messages.stamped
    instants, found = [], []
    for k, stamp in enumerate(messages.stamps):
        outcome = estimator.update(stamp, messages.positions[k])
        if outcome is not None:
            assert abs(outcome.stamp - (stamp - delay)) <= 1e-12
            if messages.stamped[k] > SETTLED:
                instants.append(outcome.stamp - offset[k])
                found.append(outcome.values)
    assert len(found) > 0.98 * (messages.stamped > SETTLED).sum()
    accelerations = np.array(found)[:, 2 * JOINTS:3 * JOINTS]
    return min(np.sqrt(np.mean((accelerations - motion(np.array(instants) - late)[2])**2))
               for late in np.unique(np.linspace(0.0, allowed, 5))), estimator


@pytest.mark.parametrize('delay', [0.0, 0.02])
@pytest.mark.parametrize('way', WAYS)
def test_the_price_of_a_way_of_stamping(way, delay):
    messages_of, *most = WAYS[way]
    prices = []
    for seed in (1, 2):
        motion = motion_of(seed)
        messages = messages_of(motion, seed)
        fresh = np.append(True, np.diff(messages.read) > 0)
        true = stamping.Messages(messages.read[fresh], messages.positions[fresh],
                                 messages.read[fresh], messages.read[fresh])
        mean = float(np.mean((messages.stamped - messages.read)[fresh]))
        price = error(motion, messages, delay, mean)[0] / error(motion, true, delay, 0.0)[0]
        prices.append(price)
    assert np.exp(np.mean(np.log(prices))) < most[delay > 0.0], prices


def test_what_the_clock_found_is_told():
    motion = motion_of(3)
    _, estimator = error(motion, reader(500, 1000)(motion, 3), 0.0, 0.0)
    assert any(doubt.startswith('read by another clock: device at 500.') or
               doubt.startswith('read by another clock: device at 499.')
               for doubt in estimator.doubts()), estimator.doubts()
    assert 'held' in estimator.doubts()[0]
    _, estimator = error(motion, arrival(500, 1e-6)(motion, 3), 0.0, 0.0)
    assert estimator.doubts() == []


@pytest.mark.parametrize('way', ['reader, 1 kHz of 1 kHz', 'on arrival, 500 Hz, late'])
def test_the_smoother_knows_the_clock_too(way):
    motion = motion_of(5)
    messages = WAYS[way][0](motion, 5)
    result = smooth(messages.stamps, messages.positions)
    inner = (result.stamps > 0.5) & (result.stamps < result.stamps[-1] - 0.5)
    mean = float(np.mean(messages.stamped - messages.read))
    smoothed = min(
        np.sqrt(np.mean((result.acceleration - motion(result.stamps - late)[2])[inner]**2))
        for late in np.linspace(0.0, 2 * mean, 9))
    for delay in (0.0, 0.05):
        assert smoothed < 1.05 * error(motion, messages, delay, mean)[0]
    assert any('clock' in finding for finding in result.findings)


@pytest.mark.parametrize('rate', [100, 250, 500, 1000])
@pytest.mark.parametrize('pause', [0.01, 0.06, 0.1, 0.2, 0.24])
def test_no_start_after_a_pause_overshoots(rate, pause):
    stamps = 0.3 + np.append(0.0, pause + np.arange(rate // 2) / rate)
    for delay in (0.0, 0.02):
        estimator = MotionEstimator(1, delay)
        for stamp in stamps:
            position = round(np.sin(np.pi * stamp) / 1e-5) * 1e-5
            found = estimator.update(stamp, [position])
            if found is not None:
                assert found.stamp == stamp - delay
                assert abs(found.acceleration[0]) < 2 * np.pi**2


@pytest.mark.parametrize('faster', [0.2, 0.6, 1.2, 3.0, 4.8])
@pytest.mark.parametrize('rate', [100, 1000])
def test_no_change_of_rate_overshoots(rate, faster):
    first = np.arange(int(0.6 * rate)) / rate
    stamps = 0.3 + np.append(first, first[-1] + np.arange(1, int(0.4 * rate * faster))
                             / (rate * faster))
    estimator = MotionEstimator(3)
    phase = np.arange(3)
    for stamp in stamps:
        found = estimator.update(stamp, np.round(np.sin(np.pi * stamp + phase), 5))
        if found is not None:
            assert np.abs(found.acceleration).max() < 2 * np.pi**2


@pytest.mark.parametrize('step', [1e-5, 1e-4, 1e-3])
@pytest.mark.parametrize('rate', [100, 250, 500, 1000])
def test_a_driver_that_stands_still_makes_no_stop(rate, step):
    stamps = np.arange(3 * rate) / rate
    positions = np.round(np.sin(np.pi * stamps) / step) * step
    begin, length = int(2.13 * rate), int(0.06 * rate)
    positions[begin:begin + length] = positions[begin - 1]
    estimator = MotionEstimator(1)
    outcomes = []
    for stamp, position in zip(stamps, positions):
        found = estimator.update(stamp, [position])
        outcomes.append(estimator.reason)
        if found is not None and stamp > 1.0:
            assert abs(found.acceleration[0] + np.pi**2 * np.sin(np.pi * stamp)) < 60.0
    late = outcomes[begin:begin + length]
    assert late[0] is None and late[-1] is Reason.NO_NEW_READING
    assert Reason.NO_NEW_READING not in outcomes[begin + length:]


def test_one_repeated_position_is_left_out_and_told():
    stamps = np.arange(1000) / 250
    positions = np.round(np.sin(np.pi * stamps), 5)
    positions[700] = positions[699]
    estimator = MotionEstimator(1)
    for stamp, position in zip(stamps, positions):
        found = estimator.update(stamp, [position])
        if found is not None and stamp > 1.0:
            assert abs(found.acceleration[0] + np.pi**2 * np.sin(np.pi * stamp)) < 0.5
    assert estimator.doubts() == ['1 of 1000 messages repeat a reading while the joints move']


def test_readings_that_were_given_other_times_have_these():
    """As the filters have: what is at its time need not be taken again, the old times may."""
    readings, stamps = Readings(1, 40), 0.01 * np.arange(30) + 1e-3 * (np.arange(30) % 2)
    for k, stamp in enumerate(stamps):
        readings.add(k, stamp - 0.01 * k, stamp, stamp, (0.0,))
    last = stamps[-1]
    assert readings.by_stamps(last) is None
    times = [time for time, _ in readings.by_ticks(last, 0.01, 0.0)]
    np.testing.assert_allclose(times, last + 0.01 * (np.arange(30) - 29), rtol=1e-12)
    assert readings.by_ticks(last, 0.01, 0.0) is None
    times = [time for time, _ in readings.by_stamps(last)]
    np.testing.assert_allclose(times, stamps, atol=1e-12)


def late_by_chance(rng):
    return np.arange(1800) / 300 + rng.exponential(3e-4, 1800)


def by_events(rng):
    return np.cumsum(rng.uniform(0.3, 1.7, 1800)) / 300


def catching_up(rng):
    """Return the stamps of a loop that stands still now and then, and catches up at once."""
    late, stamps = rng.exponential(1e-4, 1800), []
    late[rng.random(1800) < 0.03] += 0.02
    for k in range(1800):
        stamps.append(max(k / 300, stamps[-1] + 2e-4 if k else 0.0) + late[k])
    return np.array(stamps)


@pytest.mark.parametrize('times, price', [
    (late_by_chance, 1.2), (by_events, 6.0), (catching_up, 15.0)])
@pytest.mark.parametrize('seed', [0, 1, 2, 3])
def test_stamps_that_are_true_are_believed_however_irregular(times, price, seed):
    motion, errors = motion_of(seed), []
    stamps = np.unique(times(np.random.default_rng(seed)))
    positions = np.round(motion(stamps)[0] / 1e-4) * 1e-4
    for regularise in (True, False):
        estimator, instants, velocities = MotionEstimator(JOINTS, regularise=regularise), [], []
        for stamp, position in zip(stamps.tolist(), positions):
            found = estimator.update(stamp, position)
            if found is not None and stamp > SETTLED:
                instants.append(stamp)
                velocities.append(found.velocity)
        errors.append(np.sqrt(np.mean((velocities - motion(instants)[1])**2)))
    assert errors[0] < price * errors[1], errors


@pytest.mark.parametrize('steps', [0.1, 0.35, 0.7, 0.9, 1.0, 1.2, 2.0, 3.0])
@pytest.mark.parametrize('delay', [0.0, 0.02])
@pytest.mark.parametrize('rate', [100, 500, 1000])
def test_a_coarse_encoder_that_repeats_itself_holds_no_reading(steps, rate, delay):
    """However many steps a message the joint makes at the most."""
    stamps, step = np.arange(4 * rate) / rate, 1e-3
    positions = np.round(steps * rate * np.cos(stamps)) * step
    estimator = MotionEstimator(1, delay)
    for stamp, position in zip(stamps, positions):
        found = estimator.update(stamp, [position])
        assert found is not None or stamp < 0.15
    assert estimator.doubts() == []


def test_results_do_not_depend_on_where_time_and_joints_begin():
    motion = motion_of(7)
    messages = reader(500, 800)(motion, 7)

    def run(shift, order, sign):
        estimator = MotionEstimator(JOINTS, 0.02)
        rows = [estimator.update(stamp + shift, sign * position[order])
                for stamp, position in zip(messages.stamps, messages.positions)]
        return np.array([row.acceleration for row in rows if row is not None])

    order = np.array([2, 0, 3, 1])
    plain = run(0.0, np.arange(JOINTS), 1.0)
    np.testing.assert_allclose(run(0.0, np.arange(JOINTS), -1.0), -plain, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(run(0.0, order, 1.0), plain[:, order], rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(run(64.0, np.arange(JOINTS), 1.0), plain, rtol=1e-3, atol=1e-3)


@pytest.mark.parametrize('delay', [0.0, 0.02])
@pytest.mark.parametrize('apart', [0.0, 0.2, 0.5, 0.8])
@pytest.mark.parametrize('length', [0.005, 0.015, 0.03, 0.08])
@pytest.mark.parametrize('rate', [250, 1000])
def test_a_stall_of_the_network_is_no_clock_that_was_set(rate, length, apart, delay):
    """However long it is, and however fast what was held up arrives then."""
    motion = motion_of(8)
    rng = np.random.default_rng(8)
    messages = stamping.on_arrival(*stamping.device(motion, rate, 5.0, 8), rng, 0.1 / rate)
    messages = stamping.with_stalls(messages, length, 1.7, max(1e-5, apart / rate))
    mean = np.mean(messages.stamped - messages.read)
    estimator, found = MotionEstimator(JOINTS, delay), []
    for stamp, read, position in zip(messages.stamps, messages.read, messages.positions):
        outcome = estimator.update(stamp, position)
        if outcome is None and read > 1.0:
            assert estimator.reason is Reason.NO_NEW_READING
            assert stamp - delay - read > 0.015
        elif read > 1.0:
            found.append((outcome.stamp - mean, *outcome.values))
    instants, values = np.split(np.array(found), [1], axis=1)
    errors = values[:, 2 * JOINTS:3 * JOINTS] - motion(instants[:, 0])[2]
    assert np.abs(errors).max() < 0.5 * np.abs(motion(messages.read)[2]).max()


@pytest.mark.parametrize('seed', range(4))
@pytest.mark.parametrize('velocity', [True, False])
def test_pauses_among_the_first_readings_are_none_of_the_period(seed, velocity):
    """Of a node that starts under load some stretches arrive; the readings between are regular."""
    rng = np.random.default_rng(seed)
    ticks = np.concatenate([np.arange(rng.integers(5, 9)) + start for start in range(0, 900, 90)]
                           + [np.arange(900, 2500)])
    w = np.array([2.0, 3.0, 5.0])
    estimator, worst = MotionEstimator(3), 0.0
    for t in ticks * 1e-3:
        q = np.round(np.sin(w * t) * 1e5) * 1e-5
        motion = estimator.update(t, q, w * np.cos(w * t) if velocity else None)
        if motion is not None:
            worst = max(worst, np.abs(motion.acceleration + w**2 * np.sin(w * t)).max())
    assert worst < 4 * 25.0
    assert estimator.clock.period == pytest.approx(1e-3, rel=1e-3)


@pytest.mark.parametrize('velocity', [False, True])
@pytest.mark.parametrize('jitter', [0.0, 0.02, 0.12])
@pytest.mark.parametrize('rate', [250, 500, 1000])
@pytest.mark.parametrize('runs, pauses', [
    ((1, 4), (1e-3, 0.24)), ((1, 11), (1e-3, 0.24)), ((1, 100), (1e-3, 0.24)),
    ((1, 30), (0.02, 0.12)), ((100, 200), (0.03, 0.031)), ((200, 400), (0.1, 0.2))])
def test_no_loss_overshoots(runs, pauses, rate, jitter, velocity):
    """Whatever stretches are missing, estimates stay within a few times the signal."""
    seed = 1 + velocity
    motion, rng = sines(seed, 6), np.random.default_rng(seed)
    ticks, positions = stamping.device(motion, rate, min(6.0, 3000 / rate), seed)
    whole = stamping.on_arrival(ticks, positions, rng, jitter / rate)
    if jitter == 0.0:
        whole = whole._replace(stamps=ticks)
    messages = stamping.in_stretches(whole, rng, runs, pauses)
    velocities = motion(messages.read)[1] + rng.normal(0.0, 1e-4, (len(messages.read), 6))
    largest = np.abs(motion(ticks)[2]).max()
    estimator = MotionEstimator(6)
    outcomes = [estimator.update(stamp, position, speed if velocity else None)
                for stamp, position, speed in zip(messages.stamps, messages.positions, velocities)]
    found = np.array([outcome.values for outcome in outcomes if outcome is not None])
    assert len(found) > 0 and np.abs(found[:, 12:18]).max() < 5 * largest
