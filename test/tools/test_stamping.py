# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Ways of stamping: what they do to readings, stamps and arrivals."""
from itertools import islice

import numpy as np
import pytest

from screw_kinematics.errors import ParameterError
from screw_kinematics.tools.stamping import help_text, stampings, WAYS

RATE = 500.0


def first(way, messages=4000, begin=3.0, seed=1):
    """Return readings, stamps and arrivals of the first messages."""
    return np.array(list(islice(stampings(way, RATE, begin, seed), messages))).T


@pytest.mark.parametrize('way', WAYS)
def test_messages_come_in_order_at_the_rate_and_never_before_they_are_read(way):
    reading, stamp, sent = first(way)
    assert np.all(np.diff(reading) >= 0) and np.all(np.diff(sent) > 0)
    assert np.all(sent - reading > -1e-12)
    rate = (len(sent) - 1) / (sent[-1] - sent[0])
    assert rate == pytest.approx(RATE, rel=0.06)
    assert abs(reading[0] - 3.0) < 0.02 and way in help_text()
    np.testing.assert_array_equal(first(way, 50), first(way, 50))


def test_exact_stamps_are_the_ticks():
    reading, stamp, sent = first('exact')
    np.testing.assert_array_equal(reading, stamp)
    np.testing.assert_allclose(np.diff(stamp), 1 / RATE, rtol=1e-9)


@pytest.mark.parametrize('way', ['arrival', 'lost', 'stalls', 'bursts'])
def test_arrival_stamps_tell_when_messages_came(way):
    reading, stamp, sent = first(way)
    np.testing.assert_array_equal(stamp, sent)
    late = stamp - reading
    assert late.min() >= 1e-4
    assert np.median(late) < (5e-3 if way == 'bursts' else 1e-3)


def test_a_reader_beside_a_device_takes_its_ticks():
    reading, stamp, _ = first('reader')
    ticks = reading * 1000
    np.testing.assert_allclose(ticks, ticks.round(), atol=1e-6)
    assert 0 <= (stamp - reading).min() and (stamp - reading).max() < 1.1e-3
    # Two clocks: a loop of 2 ms takes mostly every second tick, now and then another one.
    steps, times = np.unique(np.diff(ticks.round()), return_counts=True)
    assert steps[times.argmax()] == 2 and set(steps) <= {1, 2, 3}


def test_held_readings_repeat():
    reading, _, _ = first('held')
    _, times = np.unique(reading.round(9), return_counts=True)
    assert np.median(times) == 4


def test_each_of_the_others_is_wrong_in_its_own_way():
    reading, stamp, _ = first('rounded')
    np.testing.assert_allclose(stamp * 1000, (stamp * 1000).round(), atol=1e-6)
    assert np.abs(stamp - reading).max() <= 0.5e-3 + 1e-12
    reading, stamp, _ = first('made_up')
    np.testing.assert_allclose(np.diff(stamp), 1 / RATE, rtol=1e-6)
    assert (reading - stamp)[-1] > 0.05      # the loop falls behind
    assert np.mean(np.diff(first('lost')[0]) > 1.5 / RATE) == pytest.approx(0.05, abs=0.015)
    assert np.diff(first('stalls')[2]).max() == pytest.approx(0.025, abs=4e-3)
    assert np.sort(np.diff(first('bursts')[2]))[2000] == pytest.approx(1e-5)
    reading, stamp, _ = first('clock_set')
    assert set(np.unique((stamp - reading).round(6))) == {0.0, 0.005}


def test_other_ways_are_refused():
    with pytest.raises(ParameterError, match="'stamps' is 'guessed'; allowed: exact, arrival"):
        stampings('guessed', RATE)
