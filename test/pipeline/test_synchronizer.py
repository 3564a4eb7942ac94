# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Groups at one instant: exact on motions of the order that is known."""
import numpy as np
import pytest
from screw_kinematics.pipeline.joint_groups import JointGroup
from screw_kinematics.pipeline.synchronizer import Rounds, TOO_FAR_APART

MS = 1_000_000
COEFFICIENTS = np.random.default_rng(5).uniform(-1, 1, (4, 3))
"""Of cubics, one for each of three joints."""


def motion(columns, stamp_ns):
    """Return position to jerk of some of the joints."""
    t = stamp_ns * 1e-9
    powers = [[1, t, t**2, t**3], [0, 1, 2 * t, 3 * t**2], [0, 0, 2, 6 * t], [0, 0, 0, 6]]
    return (np.array(powers) @ COEFFICIENTS[:, columns]).ravel().tolist()


@pytest.fixture
def arm():
    """Return the first two joints as a group."""
    return JointGroup((0, 2), False)


@pytest.fixture
def hand():
    """Return the third joint as a group."""
    return JointGroup((1,), False)


@pytest.mark.parametrize('skew', [0, 3 * MS, -3 * MS])
def test_joined_at_the_older_instant_exactly(arm, hand, skew):
    rounds = Rounds(3)
    for k in range(1, 20):
        t = k * 10 * MS
        assert rounds.add(arm, t, motion([0, 2], t)) is None
        instant, joined = rounds.add(hand, t + skew, motion([1], t + skew))
        assert instant == min(t, t + skew)
        assert np.allclose(joined, motion([0, 1, 2], instant), rtol=1e-12, atol=1e-12)


def test_a_slow_group_does_not_hold_up_the_fast_one(arm, hand):
    rounds, instants = Rounds(3), []
    for k in range(1, 101):
        t = k * 2 * MS
        if k % 25 == 1:
            rounds.add(hand, t, motion([1], t))
        joined = rounds.add(arm, t, motion([0, 2], t))
        if joined is not None:
            instants.append(joined[0])
            assert np.allclose(joined[1], motion([0, 1, 2], joined[0]), atol=1e-12)
    assert len(instants) >= 97      # the second message of a round tells that nobody else comes
    assert instants == sorted(set(instants))


def test_the_other_takes_the_lead_when_the_leader_is_gone(arm, hand):
    rounds = Rounds(3, max_apart_ns=50 * MS)
    for k in range(1, 10):
        t = k * 2 * MS
        rounds.add(hand, t, motion([1], t)) if k == 1 else None
        rounds.add(arm, t, motion([0, 2], t))
    results = [rounds.add(hand, t, motion([1], t)) for t in range(20 * MS, 100 * MS, 10 * MS)]
    led = [r for r in results if isinstance(r, tuple)]
    assert led and led[0][0] == 30 * MS
    assert results[-1] == TOO_FAR_APART
    rounds.keep([hand])
    assert rounds.add(hand, 100 * MS, motion([1], 100 * MS)) is None


def test_no_order_is_invented(arm, hand):
    rounds = Rounds(3)
    rounds.add(arm, 5, [1.0, 3.0])
    assert rounds.add(hand, 5, [2.0, 7.0]) == (5, [1.0, 2.0, 3.0])


def test_cleared_rounds_wait_for_all(arm, hand):
    rounds = Rounds(3)
    rounds.add(arm, 5, [1.0, 3.0])
    rounds.clear()
    assert rounds.add(hand, 5, [2.0]) is None
