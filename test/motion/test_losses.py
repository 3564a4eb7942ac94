# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What is lost makes nothing certain: not how many ticks passed, nor what was before a pause."""
import numpy as np
import pytest
from screw_kinematics.motion import MotionEstimator
from screw_kinematics.motion.tick_counter import TickCounter
from support import stamping
from support.motions import sines

JOINTS = 6
LATE = 3e-4


@pytest.mark.parametrize('seed', range(8))
@pytest.mark.parametrize('wrong', [-1, 0, 1])
def test_ticks_that_nobody_told_bend_no_line(wrong, seed):
    """The period stays as well known as it was, and the phase is that of the stamps behind."""
    rng = np.random.default_rng([wrong + 1, seed])
    late = rng.exponential(LATE, 1200)
    counter = TickCounter(late[0], 1e-3, 1, LATE)
    for k in range(1, 600):
        counter.advance(1, 1e-3 * k + late[k], True)
    known = counter.line_error()[1]
    counter.begin_line()
    counter.advance(20 + wrong, 0.619 + late[600], True)
    for k in range(620, 1200):
        counter.advance(1, 1e-3 * k + late[k], True)
        _, rate = counter.line_error()
        assert rate < 1.2 * known       # the deviation is followed
        assert abs(counter.period / 1e-3 - 1.0) < 4.0 * rate
        if k > 670:     # the line is of stamps behind the gap alone
            assert abs(counter.phase - 1e-3 * k - LATE) < 3e-4


def test_a_line_that_no_stamps_go_through_is_known_the_less_the_longer():
    rng = np.random.default_rng(1)
    counter = TickCounter(0.0, 1e-3, 1, LATE)
    for k in range(1, 200):
        counter.advance(1, 1e-3 * k + rng.exponential(LATE), True)
    end, rate = counter.line_error()
    for k in range(200, 1200):
        counter.advance(1, 1e-3 * k + rng.exponential(LATE), False)
    longer, same = counter.line_error()
    assert same == pytest.approx(rate, rel=0.3)     # the deviation is followed
    assert longer > 0.8 * same > 5.0 * end * 1e-3


@pytest.mark.parametrize('seed', range(6))
@pytest.mark.parametrize('held', [0.011, 0.016])
def test_a_pause_behind_late_messages_is_as_long_as_its_ticks(held, seed):
    """It begins where the latest reading was taken, not where that came to be stamped."""
    rng, motion = np.random.default_rng(seed), sines(seed, JOINTS, 1.5)
    messages = stamping.on_arrival(*stamping.device(motion, 1000.0, 2.0, seed), rng, LATE)
    stamps, keep = messages.stamps.copy(), np.ones(len(messages.stamps), bool)
    for first in range(500, 1800, 300):
        # Held up, and lost as they catch up, while those before are still late.
        stamps[first:] = np.maximum(
            stamps[first:], stamps[first] + held + 1e-5 * np.arange(len(stamps) - first))
        keep[first + 6:first + 6 + round(1e3 * held) + 6] = False
    estimator, found = MotionEstimator(JOINTS, delay=0.02), []
    for stamp, position in zip(stamps[keep].tolist(), messages.positions[keep]):
        made = estimator.update(stamp, position)
        if made is not None and stamp > 0.4:
            found.append((made.stamp, made.velocity, made.variances[JOINTS:2 * JOINTS]))
    instants, velocities, variances = map(np.array, zip(*found))
    assert len(instants) > 1000
    true = motion(instants - 1e-4 - LATE)[1]
    assert (np.abs(velocities - true) / np.sqrt(variances)).max() < 10.0
