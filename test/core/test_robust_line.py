# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A line through stamps knows how well it is known, whatever neighbours have in common."""
import numpy as np
import pytest
from screw_kinematics.core.robust_line import Line

PERIOD, LATE, STAMPS = 2e-3, 3e-4, 1000


def independent(rng):
    return rng.normal(size=STAMPS)


def with_a_tail(rng):
    return rng.exponential(size=STAMPS)


def alike(rng):
    late = rng.normal(size=STAMPS + 100)
    for k in range(1, len(late)):
        late[k] += 0.8 * late[k - 1]
    return late[100:]


def in_bursts(rng):
    """Each of five waits for the last, and is as late as it was in every burst before."""
    return 4 - (rng.integers(5) + np.arange(STAMPS)) % 5 + 0.1 * rng.normal(size=STAMPS)


@pytest.mark.parametrize('lateness', [independent, with_a_tail, alike, in_bursts])
def test_the_end_of_a_line_errs_as_its_deviations_say(lateness):
    """By two standard errors of its mean: those of the middle and of the slope add up to that."""
    ends, stated = [], []
    for seed in range(100):
        line = Line(256)
        for k, late in enumerate(LATE * lateness(np.random.default_rng(seed))):
            if line.full():
                line.merge()
            line.add(k, PERIOD * k + late)
        ends.append(line.fit(STAMPS - 1.0)[0])
        stated.append(2.0 * line.error)
    error = np.std(ends)
    least = 0.6 if lateness is in_bursts else 0.8
    assert least * error < np.sqrt(np.mean(np.square(stated))) < 1.25 * error
    assert np.std(stated) < 0.3 * np.mean(stated)


def test_nothing_is_said_of_lines_through_few_stamps():
    line = Line(256)
    for k in range(63):
        line.add(k, PERIOD * k + LATE * (k % 2))
    line.fit(62.0)
    assert line.error == 0.0
