# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A second publisher of the same joints leaves nothing behind in what is known of the first."""

import numpy as np
import pytest
from screw_kinematics.errors import Reason
from screw_kinematics.motion import MotionEstimator

STEP, BESIDE, PERIOD = 5e-3, 5e-4, 5.0
ALONE, CALM, SETTLED = 0.5, 2.0, 1.5


def slow_motion(seed):
    """Return a function of time: positions and velocities that repeat, of two sines a joint."""
    phase = np.random.default_rng(seed).uniform(0.0, 2 * np.pi, (2, 3))
    omega = 2 * np.pi * np.array([[1.0], [2.0]]) / PERIOD
    amplitude = np.array([[0.3], [0.1]])

    def motion(t):
        angle = omega * np.asarray(t)[..., None, None] + phase
        return ((amplitude * np.sin(angle)).sum(-2) + [0.3, 0.65, 1.0],
                (amplitude * omega * np.cos(angle)).sum(-2))
    return motion


@pytest.mark.parametrize('both', [1.0, 2.4])
@pytest.mark.parametrize('delay', [0.0, 0.02])
@pytest.mark.parametrize('seed', range(2))
def test_nothing_is_left_of_a_second_publisher(seed, delay, both):
    """It runs backwards: where the two meet, readings of both are plausible, and taken."""
    own = slow_motion(seed)
    speed = np.sqrt(np.mean(own(np.arange(0.0, PERIOD, STEP))[1]**2, axis=0))
    taken = 0
    for begin in np.arange(0.0, PERIOD, 0.25):
        estimator, judged = MotionEstimator(3, delay), []
        second, alone = begin + ALONE, begin + ALONE + both
        times = np.arange(begin, alone + CALM, STEP)
        for t, q, qd, others_q, others_qd, due in zip(
                times, *own(times), *own(-(times + BESIDE)), own(times - delay)[1]):
            found = estimator.update(t, q, qd)
            if t - delay > alone + SETTLED:
                judged.append((found.velocity, due))
            if second <= t < alone:
                estimator.update(t + BESIDE, others_q, -others_qd)
                taken += estimator.reason is not Reason.IMPLAUSIBLE_JUMP
        found, due = np.swapaxes(judged, 0, 1)
        assert (abs(found - due) < 1e-3 * speed).all(), begin
    assert taken > 10
