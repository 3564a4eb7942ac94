# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The first period, from stamps alone: neither lateness is taken for losses, nor the reverse."""
import numpy as np
import pytest
from screw_kinematics.motion.first_ticks import FirstTicks


def late_by_waiting(rng):
    return np.arange(80) * 1e-3 + rng.exponential(3e-4, 80)


def with_losses(rng):
    return np.cumsum(1 + rng.poisson(0.06, 80)) * 1e-3 + rng.normal(0.0, 1e-4, 80)


def with_many_losses(rng):
    return np.cumsum(1 + rng.poisson(0.4, 80)) * 1e-3 + rng.normal(0.0, 3e-5, 80)


def of_every_second_tick_or_the_next(rng):
    return np.cumsum(1 + (rng.random(80) < 0.5)) * 1e-3 + rng.normal(0.0, 3e-5, 80)


@pytest.mark.parametrize('stamped', [
    late_by_waiting, with_losses, with_many_losses, of_every_second_tick_or_the_next])
def test_a_first_period_is_right_within_a_twentieth(stamped):
    """But for few of 400 beginnings: twenty stamps may look like others."""
    wrong = 0
    for seed in range(400):
        stamps = np.maximum.accumulate(stamped(np.random.default_rng(seed))).tolist()
        begun = FirstTicks(stamps[0])
        found = next(ticks for stamp in stamps[1:] if (ticks := begun.add(stamp)) is not None)
        wrong += abs(found.period - 1e-3) > 5e-5
    assert wrong < 0.02 * 400
