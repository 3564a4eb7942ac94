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
    """Return positions, velocities and accelerations at times that no encoder step suits."""
    t = np.asarray(t)[..., None]
    q, v, a = np.zeros((3, *t.shape[:-1], n))
    for harmonic, amplitude in ((1, 0.3), (3, 0.1), (7, 0.03)):
        w = 2 * np.pi * harmonic / 5
        phase = w * t + np.arange(n) * 1.3 * harmonic
        q, v, a = (q + amplitude * np.sin(phase), v + amplitude * w * np.cos(phase),
                   a - amplitude * w**2 * np.sin(phase))
    return q, v, a


def worst_of(found, truth):
    """Return the largest error in stated deviations; truths are velocities, accelerations."""
    states, variances = (
        np.array(rows).reshape(len(found), 4, -1)[:, 1:1 + len(truth)]
        for rows in ([made.values for made in found], [made.variances for made in found]))
    return (np.abs(states - np.stack(truth, axis=1)) / np.sqrt(variances)).max()


@pytest.mark.parametrize('delay', [0.0, 0.02])
def test_rounded_positions_that_lie_on_a_line_make_no_estimate_certain(delay):
    """A joint that moves by whole steps for a while has an error all the same."""
    estimator = MotionEstimator(6, delay=delay)
    times = (0.46 * np.arange(40)[:, None] + 1e-3 * np.arange(60)).ravel()
    rows = np.round(motion(times)[0] / STEP) * STEP
    found = [made for t, row in zip(times, rows) if (made := estimator.update(t, row)) is not None]
    assert estimator.restarts['gap'] == 39 and len(found) > 40
    assert worst_of(found, motion([made.stamp for made in found])[1:]) < 10.0


def test_what_late_stamps_say_of_a_clock_at_first_is_as_sure_as_stated():
    """Nobody tells the ticks from twenty such stamps; joints that move do."""
    delay, late, found, instants = 0.02, 4e-4, [], []
    for seed in range(120):
        estimator, begin = MotionEstimator(6, delay), 0.37 * seed
        readings, stamps, _ = zip(*islice(stampings('arrival', 1000.0, seed=seed), 150))
        rows = np.round(motion(begin + np.array(readings))[0] / STEP) * STEP
        for stamp, row in zip(stamps, rows):
            made = estimator.update(stamp, row)
            if made is not None:
                found.append(made)
                instants.append(begin + stamp - late - delay)
    assert len(found) > 10_000
    assert worst_of(found, motion(instants)[1:2]) < 10.0


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
