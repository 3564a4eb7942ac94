# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Each sample is used, or refused for a reason, or begins a new run."""

import math

import numpy as np
import pytest

from screw_kinematics.errors import InvalidValueError, UnknownNameError
from screw_kinematics.motion import ESTIMATORS, make_estimator, MotionEstimator

PERIOD = 0.002


def feed(estimator, stamps, position=0.0):
    """Feed a constant position; return the outcomes."""
    outcomes = []
    for stamp in stamps:
        estimator.update(stamp, np.full(estimator.n_joints, position))
        outcomes.append(estimator.last_outcome)
    return outcomes


@pytest.fixture(params=sorted(ESTIMATORS))
def estimator(request):
    made = make_estimator(request.param, 2)
    feed(made, PERIOD * np.arange(100))
    assert made.last_outcome == 'estimate'
    return made


def test_first_estimate_after_eight_samples():
    outcomes = feed(MotionEstimator(3), PERIOD * np.arange(10))
    assert outcomes == ['warming up'] * 7 + ['estimate'] * 3


def test_first_estimate_waits_for_the_delay():
    outcomes = feed(MotionEstimator(3, delay=0.02), PERIOD * np.arange(20))
    assert 10 <= outcomes.index('estimate') <= 12


def test_gap_restarts(estimator):
    assert feed(estimator, [0.198 + 0.2501]) == ['warming up']
    assert estimator.restarts == {'gap': 1}
    assert estimator.refusals == {}


def test_stamps_far_back_restart(estimator):
    assert feed(estimator, [0.198 - 0.51]) == ['warming up']
    assert estimator.restarts == {'stamp_jump_back': 1}


@pytest.mark.parametrize('step', [0.0, -0.4])
def test_stamps_that_do_not_advance_are_refused_and_counted(estimator, step):
    outcomes = feed(estimator, [0.198 + step] * 21)
    assert outcomes == ['refused: stamp_not_increasing'] * 20 + ['warming up']
    assert estimator.refusals == {'stamp_not_increasing': 20}
    assert estimator.restarts == {'stamps_stuck': 1}


def test_implausible_jump_is_refused_five_times_and_then_restarts(estimator):
    outcomes = feed(estimator, 0.2 + PERIOD * np.arange(6), position=1.0)
    assert outcomes == ['refused: implausible_jump'] * 5 + ['warming up']
    assert estimator.restarts == {'jump': 1}


def test_one_outlier_leaves_no_trace(estimator):
    feed(estimator, [0.2], position=1.0)
    motion = estimator.update(0.202, np.zeros(2))
    np.testing.assert_allclose(motion.state, 0, atol=1e-9)


@pytest.mark.parametrize(('position', 'reason'), [
    ((0.0, math.nan), 'nan_position'),
    ((math.inf, 0.0), 'nan_position'),
    ((1e7, 0.0), 'implausible_position'),
    ((0.0,), 'wrong_length'),
    ((0.0, 0.0, 0.0), 'wrong_length'),
])
def test_bad_positions_are_refused(estimator, position, reason):
    assert estimator.update(0.2, np.array(position)) is None
    assert estimator.last_outcome == f'refused: {reason}'
    assert estimator.last_refusal == reason
    assert estimator.update(0.202, np.zeros(2)) is not None


def test_a_run_does_not_begin_with_an_absurd_position():
    estimator = MotionEstimator(1)
    estimator.update(0.0, np.array([1e300]))
    assert estimator.last_outcome == 'refused: implausible_position'


def test_stamp_that_is_no_number_is_refused(estimator):
    assert feed(estimator, [math.nan, math.inf]) == ['refused: stamp_not_finite'] * 2


def test_every_sample_is_accounted_for():
    rng = np.random.default_rng(5)
    estimator = MotionEstimator(1, delay=0.01)
    tally = {'estimate': 0, 'warming up': 0, 'refused': 0}
    steps = [PERIOD, 0.0, 0.3, -0.01, -1.0]
    stamps = np.cumsum(rng.choice(steps, 500, p=[.9, .04, .02, .03, .01]))
    for stamp in stamps:
        motion = estimator.update(stamp, rng.choice([0.0, 1.0, np.nan], 1, p=[.9, .05, .05]))
        outcome = estimator.last_outcome.split(':')[0]
        assert (motion is not None) == (outcome == 'estimate')
        tally[outcome] += 1
    assert sum(tally.values()) == 500
    assert tally['refused'] == sum(estimator.refusals.values()) > 0


def test_reset_forgets_the_run(estimator):
    estimator.reset()
    assert feed(estimator, [0.0], position=5.0) == ['warming up']
    assert estimator.restarts == {}


@pytest.mark.parametrize('sign', [1, -1])
def test_continuous_joint_passes_the_seam(sign):
    estimator = MotionEstimator(2, continuous=[True, False])
    for k in range(3000):
        angle = sign * 3.0 * PERIOD * k
        wrapped = math.remainder(angle, 2 * math.pi)
        motion = estimator.update(PERIOD * k, np.array([wrapped, 0.0]))
    assert estimator.refusals == {}
    np.testing.assert_allclose(motion.velocity, [sign * 3.0, 0], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(motion.acceleration, 0, atol=1e-6)


@pytest.mark.parametrize(('settings', 'message'), [
    ({'delay': -0.1}, 'delay is -0.1 s; allowed: 0 to 1 s'),
    ({'min_samples': 0}, 'min_samples is 0'),
    ({'velocity': 'guess'}, "velocity is 'guess'; allowed: .*'auto'"),
    ({'window': 0.0}, 'window is 0.0 s'),
    ({'max_gap': 0.0}, 'max_gap is 0.0; allowed: more than 0'),
])
def test_wrong_settings_are_named(settings, message):
    with pytest.raises(InvalidValueError, match=message):
        MotionEstimator(2, **settings)


def test_unknown_kind_lists_the_known():
    with pytest.raises(UnknownNameError, match="unknown estimator 'magic'; known: 'bank'"):
        make_estimator('magic', 2)


def test_no_joints_is_refused():
    with pytest.raises(InvalidValueError, match='n_joints is 0'):
        MotionEstimator(0)
