# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What must not change, or change as told, where the samples are changed: laws without a truth."""
from hypothesis import given, HealthCheck, settings, strategies as st
import numpy as np
from screw_kinematics.motion import MotionEstimator

N, COUNT, PERIOD = 3, 220, 1 / 128      # exact in binary
PLAIN = settings(max_examples=12, deadline=None, derandomize=True,
                 suppress_health_check=list(HealthCheck))


def recorded(seed, velocity):
    """Return stamps, positions and velocities of a swing with a little noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(COUNT) * PERIOD
    w, phase = rng.uniform(0.5, 6.0, N), rng.uniform(0, 6, N)
    q = np.sin(w * t[:, None] + phase) + rng.normal(0, 1e-4, (COUNT, N))
    q = np.round(q * 2.0**20) * 2.0**-20        # so that nothing is rounded where they are moved
    v = w * np.cos(w * t[:, None] + phase) + rng.normal(0, 1e-3, (COUNT, N))
    return t, q, v if velocity else None


def estimates(t, q, v, **options):
    """Return stamps, states (K, 3, n) and variances (K, 3, n) of the estimates."""
    estimator = MotionEstimator(q.shape[1], **options)
    found = [estimator.update(stamp, position, None if v is None else v[k])
             for k, (stamp, position) in enumerate(zip(t, q))]
    found = [motion for motion in found if motion is not None]
    assert len(found) > COUNT - 60
    return (np.array([m.stamp for m in found]),
            np.array([[m.position, m.velocity, m.acceleration] for m in found]),
            np.array([m.covariance[:, [0, 1, 2], [0, 1, 2]].T for m in found]))


def assert_same(found, expected, tolerance=1e-5):
    size = np.abs(expected[1]).max(axis=(0, 2))[None, :, None]
    assert found[1].shape == expected[1].shape
    np.testing.assert_allclose(found[1] / size, expected[1] / size, atol=tolerance)
    np.testing.assert_allclose(found[2], expected[2], rtol=1e-2)


def found_of(estimates, n, joints=slice(None)):
    """Return the latest n of some estimates, of some joints."""
    return [estimates[0][-n:], *(part[-n:, :, joints] for part in estimates[1:])]


SEEDS, FLAGS = st.integers(0, 10**6), st.booleans()
DELAYS = st.sampled_from([0.0, 0.03125])


@PLAIN
@given(SEEDS, FLAGS, DELAYS, st.integers(-2000, 2000))
def test_time_may_begin_anywhere(seed, velocity, delay, begin):
    t, q, v = recorded(seed, velocity)
    plain, later = estimates(t, q, v, delay=delay), estimates(t + begin, q, v, delay=delay)
    np.testing.assert_allclose(later[0] - begin, plain[0], atol=1e-9)
    assert_same(later, plain)


@PLAIN
@given(SEEDS, FLAGS, DELAYS, st.integers(-3, 3))
def test_positions_may_begin_anywhere(seed, velocity, delay, where):
    t, q, v = recorded(seed, velocity)
    plain, moved = estimates(t, q, v, delay=delay), estimates(t, q + where, v, delay=delay)
    moved[1][:, 0] -= where
    assert_same(moved, plain)


@PLAIN
@given(SEEDS, FLAGS, DELAYS)
def test_joints_may_turn_the_other_way(seed, velocity, delay):
    t, q, v = recorded(seed, velocity)
    plain = estimates(t, q, v, delay=delay)
    other = estimates(t, -q, None if v is None else -v, delay=delay)
    assert_same((other[0], -other[1], other[2]), plain, 1e-9)


@PLAIN
@given(SEEDS, FLAGS, DELAYS, st.permutations(range(N)))
def test_joints_may_come_in_any_order(seed, velocity, delay, order):
    t, q, v = recorded(seed, velocity)
    plain = estimates(t, q, v, delay=delay)
    mixed = estimates(t, q[:, order], None if v is None else v[:, order], delay=delay)
    assert_same(mixed, (plain[0], plain[1][:, :, order], plain[2][:, :, order]))


@PLAIN
@given(SEEDS, FLAGS, DELAYS, st.lists(st.integers(0, N - 1), min_size=N, max_size=N))
def test_joints_may_have_an_estimator_each_or_share_one(seed, velocity, delay, group_of):
    t, q, v = recorded(seed, velocity)
    plain = estimates(t, q, v, delay=delay)
    for group in set(group_of):
        own = [joint for joint in range(N) if group_of[joint] == group]
        found = estimates(t, q[:, own], None if v is None else v[:, own], delay=delay)
        # The first estimates wait for the joint that is mostly noise for longest.
        n = min(len(found[0]), len(plain[0]))
        np.testing.assert_allclose(found[0][-n:], plain[0][-n:], atol=1e-9)
        assert_same(found_of(found, n), found_of(plain, n, own))
