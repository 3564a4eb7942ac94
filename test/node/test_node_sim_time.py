# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Simulated time: pause, other rates, reset, and a recording that plays in a loop."""
from geometry_msgs.msg import TwistStamped
import numpy as np
import pytest
from rosgraph_msgs.msg import Clock
from screw_kinematics import models
from support.rig import joint_state, PUMA, running, six, smooth_motion, stamp_ns

MS = 1_000_000
JOINTS = tuple(f'q{i}' for i in range(1, 7))


@pytest.fixture
def rig(context, tmp_path):
    """Run a node in simulated time."""
    parameters = {'robots': ['arm', 'bare'], 'use_sim_time': True,
                  'arm': {'description': PUMA, 'stale_timeout': 0.5},
                  'bare': {'description': PUMA, 'joint_states_topic': 'bare', 'outputs': ['twist'],
                           'velocity_source': 'measured'}}
    with running(context, tmp_path, parameters) as rig:
        rig.twists = rig.listen('arm/twist', TwistStamped)
        rig.listen('bare/twist', TwistStamped)
        for robot in ('arm', 'bare'):
            rig.wait_until_serving(robot, ['twist'])
        rig.clock = rig.publisher('/clock', Clock)
        yield rig


def tick(rig, ns):
    """Set the simulated time."""
    message = Clock()
    message.clock.sec, message.clock.nanosec = divmod(ns, 10**9)
    rig.clock.publish(message)


def play(rig, begin, n, period=2 * MS, pace=0.002, in_step=True):
    """Play n samples of simulated time from an instant, in step with the outputs that come."""
    publisher = rig.publisher('joint_states')
    for k in range(n):
        stamp = begin + k * period
        tick(rig, stamp)
        q, qd = smooth_motion(6, stamp * 1e-9)
        publisher.publish(joint_state(JOINTS, stamp, q, qd))
        rig.spin(pace)
        if in_step and k % 10 == 9:     # else the time may leap over the timeout
            rig.wait(lambda: stamp_ns(rig.twists[-1]) == stamp)
    return begin + n * period


def test_pause_rates_and_loops(rig):
    chain = models.load(PUMA)
    start = 5 * 10**9
    now = start
    while not rig.twists:       # the program is made in the background
        now = play(rig, now, 10, in_step=False)
    now = play(rig, now, 200)
    # A pause, longer than the timeout by the wall clock, is none for the simulation.
    rig.spin(1.0)
    now = play(rig, now, 100)
    # Slower, then faster than the wall clock.
    now = play(rig, now, 50, pace=0.01)
    now = play(rig, now, 200, period=4 * MS, pace=0.001)
    steps = set(np.diff([stamp_ns(m) for m in rig.twists]))
    assert steps == {2 * MS, 4 * MS}

    # The recording begins again, twice: all but the first samples of each turn lead to outputs.
    for _ in range(2):
        n = len(rig.twists)
        play(rig, start, 150)
        stamps = [stamp_ns(m) for m in rig.twists[n:]]
        assert stamps == [start + k * 2 * MS for k in range(7, 150)]
    for message in rig.twists[-50:]:
        state = chain.state(*smooth_motion(6, stamp_ns(message) * 1e-9))
        assert np.allclose(six(message.twist), state.velocity, atol=1e-3)
    rig.wait_for_value('arm', 'refused', 0)


def test_without_stamps_the_simulated_clock_counts(rig):
    publisher, twists = rig.publisher('bare'), rig.received['bare/twist']
    q, qd = smooth_motion(6, 0.0)
    publisher.publish(joint_state(JOINTS, 0, q, qd))
    rig.wait_for_value('node', '/bare refused no_stamp_and_no_clock_yet', 1)
    now = 10**9
    while not twists:
        now += 10 * MS
        tick(rig, now)
        rig.spin(0.02)
        publisher.publish(joint_state(JOINTS, 0, q, qd))
        rig.spin(0.02)

    def caught_up():
        publisher.publish(joint_state(JOINTS, 0, q, qd))
        return stamp_ns(twists[-1]) == now
    rig.wait(caught_up)
    assert 10**9 < stamp_ns(twists[0])
    seen = len(twists)

    def refused():
        return int(rig.status('bare')[2].get('refused stamp_not_increasing', 0))
    before = refused()
    for _ in range(5):      # time stands still: nothing new can be told
        publisher.publish(joint_state(JOINTS, 0, q, qd))
    rig.wait(lambda: refused() >= before + 5)
    assert len(twists) == seen
