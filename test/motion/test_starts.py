# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""After each start of a run the estimates are as good as they say."""
from itertools import islice

import numpy as np
import pytest
from screw_kinematics.motion import MotionEstimator
from screw_kinematics.tools.stamping import stampings
from support import stamping
from support.motions import run, sines

STEP = 1e-5


def motion(t, n=6):
    """Return positions, velocities and accelerations that no encoder step suits."""
    q, v, a = np.zeros((3, n))
    for harmonic, amplitude in ((1, 0.3), (3, 0.1), (7, 0.03)):
        w = 2 * np.pi * harmonic / 5
        phase = w * t + np.arange(n) * 1.3 * harmonic
        q, v, a = (q + amplitude * np.sin(phase), v + amplitude * w * np.cos(phase),
                   a - amplitude * w**2 * np.sin(phase))
    return q, v, a


@pytest.mark.parametrize('delay', [0.0, 0.02])
def test_rounded_positions_that_lie_on_a_line_make_no_estimate_certain(delay):
    """A joint that moves by whole steps for a while has an error all the same."""
    estimator, worst = MotionEstimator(6, delay=delay), 0.0
    for number in range(40):
        for k in range(60):
            t = 0.46 * number + 1e-3 * k
            found = estimator.update(t, np.round(motion(t)[0] / STEP) * STEP)
            if found is not None:
                _, v, a = motion(t - delay)
                sizes = np.abs([found.velocity - v, found.acceleration - a])
                deviations = np.sqrt(found.covariance[:, [1, 2], [1, 2]].T)
                worst = max(worst, (sizes / deviations).max())
    assert estimator.restarts['gap'] == 39
    assert worst < 10.0


def test_what_late_stamps_say_of_a_clock_at_first_is_as_sure_as_stated():
    """Nobody tells the ticks from twenty such stamps; joints that move do."""
    delay, late, worst, judged = 0.02, 4e-4, 0.0, 0
    for seed in range(120):
        estimator, begin = MotionEstimator(6, delay), 0.37 * seed
        for reading, stamp, _ in islice(stampings('arrival', 1000.0, seed=seed), 150):
            found = estimator.update(stamp, np.round(motion(begin + reading)[0] / STEP) * STEP)
            if found is not None:
                sizes = (np.abs(found.velocity - motion(begin + stamp - late - delay)[1])
                         / np.sqrt(found.covariance[:, 1, 1]))
                worst, judged = max(worst, sizes.max()), judged + 1
    assert judged > 10_000
    assert worst < 10.0


@pytest.mark.parametrize('delay', [0.0, 0.02])
@pytest.mark.parametrize('waited', [30, 100])
@pytest.mark.parametrize('before', [0, 1, 5, 15])
@pytest.mark.parametrize('rate', [250, 500, 1000])
def test_messages_that_had_waited_tell_no_motion(rate, before, waited, delay):
    """Stamped on arrival, those that a stall has held up come at once as the run begins."""
    for seed in (1, 2):
        of, rng = sines(seed, 4), np.random.default_rng(seed)
        messages = stamping.on_arrival(
            *stamping.device(of, rate, 1.0, seed), rng, 0.05 / rate)
        stamps, end = messages.stamps.copy(), before + waited
        stamps[before:end] = np.maximum(
            stamps[before:end], stamps[end] - 1.5e-5 * np.arange(waited, 0, -1))
        instants, states, _ = run(MotionEstimator(4, delay), stamps, messages.positions)
        exact = of(instants)[2]
        assert instants[0] < stamps[end] + 0.15
        assert np.abs(states[:, 2] - exact).max() < np.abs(exact).max()
