# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Groups at one instant: exact on motions of the order that is known."""
import itertools

import numpy as np
import pytest
from scipy.linalg import expm
from screw_kinematics.errors import Reason
from screw_kinematics.motion.joint_motion import JointMotion
from screw_kinematics.pipeline.group_motion import Motion
from screw_kinematics.pipeline.joint_groups import JointGroup
from screw_kinematics.pipeline.synchronizer import Synchronizer

MS = 1_000_000
COEFFICIENTS = np.random.default_rng(5).uniform(-1, 1, (4, 3))
"""Of cubics, one for each of three joints."""


def motion(columns, stamp_ns):
    """Return position to jerk of some of the joints."""
    t = stamp_ns * 1e-9
    powers = [[1, t, t**2, t**3], [0, 1, 2 * t, 3 * t**2], [0, 0, 2, 6 * t], [0, 0, 0, 6]]
    return Motion(stamp_ns, (np.array(powers) @ COEFFICIENTS[:, columns]).ravel().tolist())


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
    joined = Synchronizer(3)
    for k in range(1, 20):
        t = k * 10 * MS
        assert joined.add(arm, motion([0, 2], t)) is (
            Reason.JOINTS_MISSING if k == 1 else Reason.MERGED)
        whole = joined.add(hand, motion([1], t + skew))
        expected = motion([0, 1, 2], min(t, t + skew))
        assert whole.stamp_ns == expected.stamp_ns
        assert np.allclose(whole.values, expected.values, rtol=1e-12, atol=1e-12)


def test_who_begins_a_round_later_is_awaited_in_the_next(arm, hand):
    """The hand is known before the arm; both come at each instant, the arm first."""
    joined = Synchronizer(3)
    joined.add(hand, motion([1], 0))
    for k in range(1, 20):
        joined.add(arm, motion([0, 2], k * 10 * MS))
        whole = joined.add(hand, motion([1], k * 10 * MS))
        assert k < 3 or whole.stamp_ns == k * 10 * MS


@pytest.mark.parametrize('order', list(itertools.permutations(range(3))))
def test_who_missed_a_message_lags_for_some_rounds_only(order):
    """Three groups at each instant: one message is lost, in the tenth round."""
    groups = [JointGroup((k,), False) for k in range(3)]
    for lost in range(3):
        joined, whole = Synchronizer(3), {}
        for k in range(1, 60):
            for number in order:
                if (k, number) != (10, lost):
                    state = joined.add(groups[number], motion([number], k * 4 * MS))
                    if isinstance(state, Motion):
                        whole[k] = state
        assert len(whole) >= 56 and set(range(35, 60)) <= {
            k for k, state in whole.items() if state.stamp_ns == k * 4 * MS}
        assert list(whole) == sorted(whole)


@pytest.mark.parametrize('rate', [50, 70, 80, 90, 95, 99])
@pytest.mark.parametrize('older', [0, 12, 25, -25])
def test_who_is_a_little_slower_holds_nobody_up_nor_takes_time_back(arm, hand, rate, older):
    """The hand's stamps are older, by its clock or its filter, than when they arrive."""
    messages = [(k * 10 * MS, arm, [0, 2], 0) for k in range(1, 1000)] + [
        (round(k * 1000 * MS / rate) + 3 * MS, hand, [1], older * MS)
        for k in range(5, 10 * rate)]
    joined, instants = Synchronizer(3), []
    for arrival, group, columns, age in sorted(messages, key=lambda message: message[0]):
        whole = joined.add(group, motion(columns, arrival - age))
        if isinstance(whole, Motion):
            instants.append(whole.stamp_ns)
    assert len(instants) > 880 and instants == sorted(instants)


def test_a_slow_group_does_not_hold_up_the_fast_one(arm, hand):
    joined, instants = Synchronizer(3), []
    for k in range(1, 101):
        t = k * 2 * MS
        if k % 25 == 1:
            joined.add(hand, motion([1], t))
        whole = joined.add(arm, motion([0, 2], t))
        if isinstance(whole, Motion):
            instants.append(whole.stamp_ns)
            assert np.allclose(whole.values, motion([0, 1, 2], whole.stamp_ns).values, atol=1e-12)
    assert len(instants) >= 97      # the second message of a round tells that nobody else comes
    assert instants == sorted(set(instants))


def test_the_other_takes_the_lead_when_the_leader_is_gone(arm, hand):
    joined = Synchronizer(3, max_apart_ns=50 * MS)
    for k in range(1, 10):
        t = k * 2 * MS
        joined.add(hand, motion([1], t)) if k == 1 else None
        joined.add(arm, motion([0, 2], t))
    results = [joined.add(hand, motion([1], t)) for t in range(20 * MS, 100 * MS, 10 * MS)]
    led = [r for r in results if isinstance(r, Motion)]
    assert led and led[0].stamp_ns == 30 * MS
    assert results[-1] is Reason.TOO_FAR_APART
    joined.keep([hand])
    assert joined.add(hand, motion([1], 100 * MS)) is Reason.JOINTS_MISSING


def test_no_order_is_invented(arm, hand):
    joined = Synchronizer(3)
    joined.add(arm, Motion(5, [1.0, 3.0]))
    assert joined.add(hand, Motion(5, [2.0, 7.0])) == Motion(5, [1.0, 2.0, 3.0])


def test_once_cleared_it_waits_for_all(arm, hand):
    joined = Synchronizer(3)
    joined.add(arm, Motion(5, [1.0, 3.0]))
    joined.clear()
    assert joined.add(hand, Motion(5, [2.0])) is Reason.JOINTS_MISSING


@pytest.mark.parametrize('later', [7 * MS, -11 * MS])
def test_carried_covariances_are_those_of_the_motion_that_carries(arm, hand, later):
    """Of the state x at a time, at another one e^(N dt) x: covariance e^(N dt) C e^(N dt)^T."""
    rng = np.random.default_rng(8)
    root = rng.normal(size=(2, 4, 4)) * [[1], [10], [100], [1000]]
    covariances = root @ root.swapaxes(1, 2)
    covariances[1, 0] = covariances[1, :, 0] = np.nan       # a position that nobody knows
    estimate = JointMotion(0.0, [0.0] * 8, lambda: covariances)
    joined = Synchronizer(3)
    # The hand sets the instant: it is older, or it alone keeps up.
    carried = Motion(20 * MS, [0.0] * 8, estimate.variances, estimate=estimate)
    joined.add(hand, Motion((20 * MS) + later, [0.0] * 4))
    whole = joined.add(arm, carried)
    if later > 0:
        whole = joined.add(hand, Motion(20 * MS + later, [0.0] * 4))
        whole = joined.add(hand, Motion(20 * MS + later, [0.0] * 4))
    assert whole.stamp_ns == 20 * MS + later
    step = expm(np.eye(4, k=1) * later * 1e-9)
    found = np.reshape(whole.variances, (4, 3))
    np.testing.assert_allclose(found[:, 0], np.diag(step @ covariances[0] @ step.T), rtol=1e-9)
    known = (step @ np.nan_to_num(covariances[1]) @ step.T).diagonal()[1:]
    np.testing.assert_allclose(found[1:, 2], known, rtol=1e-9)
    assert np.isnan(found[0, 2]) and np.isnan(found[:, 1]).all()


def test_variances_come_in_the_order_of_the_robot_and_are_unknown_where_nobody_knows(arm, hand):
    joined = Synchronizer(3)
    joined.add(arm, Motion(5, [0.0] * 8, [1.0, 3.0, 4.0, 6.0, 7.0, 9.0, 10.0, 12.0]))
    whole = joined.add(hand, Motion(5, [0.0] * 4))
    expected = [k if k % 3 != 2 else np.nan for k in range(1, 13)]
    np.testing.assert_array_equal(whole.variances, expected)
