# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What the stamps' clock is known by."""
import numpy as np
import pytest
from screw_kinematics.motion.tick_counter import LONGEST, TickCounter

LATE = 3e-4


@pytest.mark.parametrize('rate', [200, 1000, 4000])
@pytest.mark.parametrize('settled', [2.5, 8.0])
def test_late_arrival_averages_out_over_the_whole_memory(rate, settled):
    """The phase wanders by no more than the mean of all stamps in memory, at any rate."""
    errors = []
    for seed in range(12):
        rng = np.random.default_rng([rate, seed])
        late = rng.exponential(LATE, int(rate * (settled + 0.5)))
        counter = TickCounter(late[0], 1.0 / rate, 1, LATE)
        for k in range(1, len(late)):
            counter.advance(1, k / rate + late[k], True)
            if k > settled * rate:
                errors.append(counter.phase - k / rate)
    # At its end a line is known by twice the standard error of the mean. Outliers count less,
    # so that the mean itself is not that of the lateness.
    assert np.std(errors) < 1.5 * 2.0 * LATE / np.sqrt(LONGEST * rate)
