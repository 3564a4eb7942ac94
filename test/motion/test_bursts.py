# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Samples taken regularly, but delivered and stamped in bursts."""

import numpy as np
import pytest

from screw_kinematics.motion import MotionEstimator
from screw_kinematics.motion.bursts import BurstClock
from support.motions import acceleration_error, run, samples, sines

RATE = 500


def in_bursts(stamps, size, rng, first=0):
    """Return stamps on arrival with the last of each burst, the others just before it."""
    place = (np.arange(len(stamps)) + first) % size
    last = np.minimum(np.arange(len(stamps)) - place + size - 1, len(stamps) - 1)
    late = np.repeat(rng.uniform(0, 1e-4, len(stamps) // size + 2), size)[first:][:len(stamps)]
    return stamps[last] + late + 2e-5 * place + rng.uniform(0, 1e-5, len(stamps))


@pytest.mark.parametrize(('size', 'first'), [(2, 0), (5, 0), (5, 3), (8, 1)])
@pytest.mark.parametrize('lost', [0.0, 0.03])
def test_bursts_cost_little_accuracy(size, first, lost):
    motion = sines(3, 4)
    ticks, positions = samples(motion, RATE, 3.0, 3)
    rng = np.random.default_rng(size)
    stamps = in_bursts(ticks, size, rng, first)
    kept = (rng.random(len(ticks)) >= lost) | (ticks < 0.2)
    regular = acceleration_error(motion, *run(MotionEstimator(4), ticks, positions)[:2], 1.5)
    estimator = MotionEstimator(4)
    claimed, states, _ = run(estimator, stamps[kept], positions[kept])
    assert (np.diff(claimed) > 0.0).all()
    error = acceleration_error(motion, claimed, states, 1.5)
    unaware = MotionEstimator(4, regularise=False)
    given = acceleration_error(
        motion, *run(unaware, stamps[kept], positions[kept])[:2], 1.5)
    assert error < (1.1 if lost else 0.3) * given
    if not lost:        # which sample of a burst was lost cannot be known before its end
        assert error < 1.3 * regular
        assert any('regular clock' in doubt for doubt in estimator.doubts())


def test_samples_really_taken_in_bursts_keep_their_stamps():
    motion = sines(3, 4)
    ticks = np.arange(1500) / RATE
    stamps = in_bursts(ticks, 5, np.random.default_rng(1))
    assert BurstClock.recognise(stamps[:40]) is not None
    estimator = MotionEstimator(4)
    run(estimator, stamps, motion(stamps)[0])
    assert not estimator.doubts() or 'regular clock' not in ''.join(estimator.doubts())


@pytest.mark.parametrize('jitter', [0.0, 0.1, 0.9])
@pytest.mark.parametrize('lost', [0.0, 0.1, 0.3])
def test_other_stamps_are_no_bursts(jitter, lost):
    rng = np.random.default_rng(5)
    for _ in range(100):
        stamps = (np.arange(80) + jitter * rng.uniform(-0.5, 0.5, 80)) / RATE
        assert BurstClock.recognise(stamps[rng.random(80) >= lost][:40]) is None


def test_the_clock_lets_go_when_the_bursts_end():
    motion = sines(3, 4)
    ticks, positions = samples(motion, RATE, 4.0, 3)
    stamps = np.where(ticks < 2.0, in_bursts(ticks, 5, np.random.default_rng(1)), ticks)
    stamps[1000:] += 0.02
    _, states, _ = run(MotionEstimator(4), stamps, positions)
    _, expected, _ = run(MotionEstimator(4), ticks, positions)
    truth = motion(ticks[-250:])[2]
    error, plain = (np.sqrt(np.mean((x[-250:, 2] - truth)**2)) for x in (states, expected))
    assert error < 1.01 * plain
