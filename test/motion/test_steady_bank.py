# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Weights that are renewed for several steps at once are those renewed step by step."""
import numpy as np
import pytest

from screw_kinematics.motion import MotionEstimator, steady_steps
from screw_kinematics.motion.filter_bank import BANDWIDTHS, FilterBank

PERIOD, JOINTS, STEPS = 1e-3, 3, 2000


def weights_of_a_run(monkeypatch, renewal, with_velocity):
    """Return the weights after each step, and whether they were renewed in it."""
    monkeypatch.setattr(steady_steps, 'REWEIGH', renewal)
    random = np.random.default_rng(7)
    t = PERIOD * np.arange(STEPS)[:, None]
    q = np.sin(3 * t + np.arange(JOINTS)) + random.normal(0, 1e-4, (STEPS, JOINTS))
    v = 3 * np.cos(3 * t + np.arange(JOINTS)) + random.normal(0, 1e-2, (STEPS, JOINTS))
    intervals = PERIOD * (1 + random.uniform(-0.2, 0.2, STEPS))
    ratio = np.array([50.0, 80.0, np.inf]) if with_velocity else None
    bank = FilterBank(JOINTS, BANDWIDTHS, window=0.1)
    bank.start(q[0])
    weights, steady = [], []
    for k in range(1, STEPS):
        bank.step(intervals[k], PERIOD, PERIOD, q[k], v[k] if with_velocity else None, ratio)
        weights.append(bank.weights)
        steady.append(bank.steady is not None and not bank._unweighed)
    bank.release()
    return np.array([*weights, bank.weights]), np.array([*steady, True])


@pytest.mark.parametrize('with_velocity', [False, True])
def test_together_or_one_by_one(monkeypatch, with_velocity):
    single, _ = weights_of_a_run(monkeypatch, 0.0, with_velocity)
    several, renewed = weights_of_a_run(monkeypatch, 4 * PERIOD, with_velocity)
    assert renewed.sum() > 50 and not renewed.all()
    assert np.abs(np.diff(single, axis=0)).max() > 1e-3
    np.testing.assert_allclose(several[renewed], single[renewed], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize('with_velocity', [False, True])
def test_compiled_or_not(with_velocity):
    pytest.importorskip('numba')
    random = np.random.default_rng(3)
    t = PERIOD * np.arange(1500)
    q = np.sin(3 * t[:, None] + np.arange(JOINTS)) + random.normal(0, 1e-4, (1500, JOINTS))
    v = 3 * np.cos(3 * t[:, None] + np.arange(JOINTS)) + random.normal(0, 1e-2, (1500, JOINTS))
    # Jitter within what kept gains bear, and a pause that lets them go in the midst of a renewal.
    t += random.uniform(0, 0.2 * PERIOD, 1500) + 0.05 * (t > 1.2007)
    plain, compiled = (MotionEstimator(JOINTS) for _ in range(2))
    compiled.warm_up()
    plain._use(None)
    compared = 0
    for k, stamp in enumerate(t.tolist()):
        motions = [e.update(stamp, q[k], v[k] if with_velocity else None)
                   for e in (plain, compiled)]
        if motions[0] is None:
            assert motions[1] is None
            continue
        assert motions[0].stamp == motions[1].stamp
        for row in range(4):
            np.testing.assert_allclose(
                motions[1].state[row], motions[0].state[row], rtol=1e-7, atol=1e-9)
        if not plain._bank._unweighed:      # else the noise it knows is some steps old
            compared += 1
            np.testing.assert_allclose(
                motions[1].covariance, motions[0].covariance, rtol=1e-5, atol=1e-12)
    assert compared > 100
