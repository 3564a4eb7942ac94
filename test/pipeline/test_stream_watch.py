# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Faults of streams are found, and sound streams have none, however they move."""
import numpy as np
import pytest
from screw_kinematics.pipeline.joint_groups import JointGroup, Reading
from screw_kinematics.pipeline.stream_watch import StreamWatch

NAMES = ['q1', 'q2']


def motion(t):
    """Return positions and velocities."""
    w = np.array([2.0, 9.0])
    return 0.5 + 0.4 * np.sin(w * t), 0.4 * w * np.cos(w * t)


def watch(readings, **options):
    """Return a watch that has seen these positions and velocities."""
    group, result = JointGroup((0, 1), True), StreamWatch(NAMES, **options)
    for k, (position, velocity) in enumerate(readings):
        result.update(Reading(group, k, list(position), None if velocity is None
                              else list(velocity)))
    return result


def sound(n=2000, rate=500.0):
    return [motion(k / rate) for k in range(n)]


@pytest.mark.parametrize('rate', [20.0, 100.0, 1000.0])
def test_a_sound_stream_has_no_faults(rate):
    assert watch(sound(rate=rate)).findings(2) == []


def test_joints_at_rest_and_velocities_of_zero_are_no_fault():
    assert watch([([0.0, 1.0], [0.0, 0.0])] * 2000).findings(1) == []
    assert watch([(q, [0.0, 0.0]) for q, _ in sound()]).findings(1) == []


@pytest.mark.parametrize('every', [1, 3, 10, 20])
def test_a_second_publisher_of_zeros_is_named(every):
    stream = []
    for k, reading in enumerate(sound(6000)):
        stream.append(reading)
        if k % every == 0:
            stream.append(([0.0, 0.0], None))
    assert watch(stream).findings(2) == [
        '2 publishers disagree on joints q1, q2: one of them is to be stopped']
    assert 'jump there and back' in watch(stream).findings(1)[0]
    assert watch(stream + sound(9000)).findings(2) == []    # once it has stopped


def test_a_second_publisher_of_old_values_is_named_with_the_joints_it_is_wrong_on():
    stream = [reading for q, v in sound(4000) for reading in ((q, v), ([q[0], 3.0], None))]
    assert watch(stream).findings(3) == [
        '3 publishers disagree on joints q2: one of them is to be stopped']


def test_one_glitch_is_no_second_publisher():
    stream = sound()
    stream[15] = ([5.0, 5.0], None)
    assert watch(stream).findings(2) == []


def test_velocity_fields_that_hold_something_else_are_named():
    assert watch([(q, q) for q, _ in sound()]).findings(1) == [
        'the velocity field holds the positions']
    assert 'commanded maximum' in watch([(q, [2.0, 2.0]) for q, _ in sound()]).findings(1)[0]


def watch_measured(readings, **options):
    """Return what a watch finds where velocities are taken as they are."""
    group, result = JointGroup((0, 1), True), StreamWatch(NAMES, measured=True, **options)
    for k, (position, velocity) in enumerate(readings):
        result.update(Reading(group, k, list(position), list(velocity)))
    return result.findings(1)


def test_measured_velocities_that_are_zero_while_the_joints_move_are_named():
    assert watch_measured(sound()) == []
    assert watch_measured([([0.0, 1.0], [0.0, 0.0])] * 2000) == []      # at rest
    assert watch_measured([(q, [0.0, 0.0]) for q, _ in sound()]) == [
        "velocity_source is 'measured', but the velocities of joints q1, q2 are zero while they "
        "move: set velocity_source to 'auto', which needs none"]
    only_one = watch_measured([(q, [v[0], 0.0]) for q, v in sound()])
    assert 'the velocities of joints q2 are zero' in only_one[0]


def test_joints_that_wrap_are_named_unless_they_are_continuous():
    turning = [((np.array([3.0 * k / 100, 0.3]) + np.pi) % (2 * np.pi) - np.pi, None)
               for k in range(20_000)]
    assert watch(turning).findings(1) == [
        "q1 jumps by whole turns: declare it 'continuous' in the model, or let the driver count "
        'its turns']
    assert watch(turning, continuous=[True, False]).findings(1) == []


def test_positions_in_degrees_are_named():
    degrees = [(np.degrees(q), np.degrees(v)) for q, v in sound()]
    found = watch(degrees).findings(1)
    assert len(found) == 2
    assert 'q1 reaches 51' in found[0] and 'are these degrees' in found[0]
    turning = [([q, 50.1 * k], v) for k, ((q, _), v) in enumerate(sound())]
    assert watch_measured(turning, continuous=[False, True]) == []


@pytest.mark.parametrize('rate', [5.0, 100.0, 1000.0])
@pytest.mark.parametrize('share', [1.0, 0.7])
def test_what_pauses_in_the_stamps_tell_was_lost_is_counted(rate, share):
    """Long pauses; single losses are none of these, nor is a clock that was set."""
    rng = np.random.default_rng(1)
    result, stamp, lost, period = StreamWatch(NAMES), 10**18, 0, round(1e9 / rate)
    for k in range(1500):
        stamp += period
        if k in (500, 900):
            missing = round(5.0 * rate) if rate > 5 else 30
            stamp, lost = stamp + missing * period, lost + missing
        if k == 1200:
            stamp += 3600 * 10**9
        if rng.random() < share or k in (499, 500, 899, 900, 1199, 1200):
            result.update(Reading(None, stamp, *map(list, motion(k / rate))))
    assert result.lost == pytest.approx(share * lost, rel=0.01 if share == 1.0 else 0.35, abs=2)


@pytest.mark.parametrize('set_at', range(10, 22))
def test_a_clock_that_is_set_to_today_has_lost_nothing(set_at):
    group, watched, stamp = JointGroup((0, 1), True), StreamWatch(NAMES), 10**9
    for k in range(60):
        stamp += 10**8 + (k == set_at) * 1_790_000_000 * 10**9
        watched.update(Reading(group, stamp, [0.1 * k, 0.0], None))
    assert watched.lost == 0
