# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Each sample is used, or refused for a reason, or begins a new run."""

import math

import numpy as np
import pytest

from screw_kinematics.errors import InvalidValueError, Reason, UnknownNameError
from screw_kinematics.motion import ESTIMATORS, make_estimator, MotionEstimator

PERIOD = 0.002


def feed(estimator, stamps, position=0.0):
    """Feed a constant position; return the outcomes."""
    outcomes = []
    for stamp in stamps:
        estimator.update(stamp, np.full(estimator.n_joints, position))
        outcomes.append(estimator.reason)
    return outcomes


@pytest.fixture(params=sorted(ESTIMATORS))
def estimator(request):
    made = make_estimator(request.param, 2)
    feed(made, PERIOD * np.arange(100))
    assert made.reason is None
    return made


def test_first_estimate_after_eight_samples():
    outcomes = feed(MotionEstimator(3), PERIOD * np.arange(10))
    assert outcomes == [Reason.SETTLING] * 7 + [None] * 3


def test_first_estimate_waits_for_the_delay():
    outcomes = feed(MotionEstimator(3, delay=0.02), PERIOD * np.arange(20))
    assert 10 <= outcomes.index(None) <= 12


def test_gap_restarts(estimator):
    assert feed(estimator, [0.198 + 0.2501]) == [Reason.SETTLING]
    assert estimator.restarts == {'gap': 1}
    assert estimator.refusals == {}


def test_stamps_far_back_restart(estimator):
    assert feed(estimator, [0.198 - 0.51]) == [Reason.SETTLING]
    assert estimator.restarts == {'stamp_jump_back': 1}


@pytest.mark.parametrize('step', [0.0, -0.4])
def test_stamps_that_do_not_advance_are_refused_and_counted(estimator, step):
    outcomes = feed(estimator, [0.198 + step] * 21)
    assert outcomes == ['stamp_not_increasing'] * 20 + [Reason.SETTLING]
    assert estimator.refusals == {'stamp_not_increasing': 20}
    assert estimator.restarts == {'stamps_stuck': 1}


def test_implausible_jump_is_refused_five_times_and_then_restarts(estimator):
    outcomes = feed(estimator, 0.2 + PERIOD * np.arange(6), position=1.0)
    assert outcomes == ['implausible_jump'] * 5 + [Reason.SETTLING]
    assert estimator.restarts == {'jump': 1}


def test_one_outlier_leaves_no_trace(estimator):
    feed(estimator, [0.2], position=1.0)
    motion = estimator.update(0.202, np.zeros(2))
    np.testing.assert_allclose(motion.state, 0, atol=1e-9)


@pytest.mark.parametrize(('position', 'reason'), [
    ((0.0, math.nan), 'position_not_finite'),
    ((math.inf, 0.0), 'position_not_finite'),
    ((1e7, 0.0), 'implausible_position'),
    ((0.0,), 'position_of_wrong_length'),
    ((0.0, 0.0, 0.0), 'position_of_wrong_length'),
])
def test_bad_positions_are_refused(estimator, position, reason):
    assert estimator.update(0.2, np.array(position)) is None
    assert estimator.reason == reason and not estimator.reason.used
    assert estimator.update(0.202, np.zeros(2)) is not None


def test_a_run_does_not_begin_with_an_absurd_position():
    estimator = MotionEstimator(1)
    estimator.update(0.0, np.array([1e300]))
    assert estimator.reason is Reason.IMPLAUSIBLE_POSITION


def test_stamp_that_is_no_number_is_refused(estimator):
    assert feed(estimator, [math.nan, math.inf]) == [Reason.STAMP_NOT_FINITE] * 2


def test_every_sample_is_accounted_for():
    rng = np.random.default_rng(5)
    estimator = MotionEstimator(1, delay=0.01)
    tally = {'estimate': 0, 'settling': 0, 'refused': 0}
    steps = [PERIOD, 0.0, 0.3, -0.01, -1.0]
    stamps = np.cumsum(rng.choice(steps, 500, p=[.9, .04, .02, .03, .01]))
    for stamp in stamps:
        motion = estimator.update(stamp, rng.choice([0.0, 1.0, np.nan], 1, p=[.9, .05, .05]))
        reason = estimator.reason
        assert (motion is not None) == (reason is None)
        tally['estimate' if reason is None else 'settling' if reason.used else 'refused'] += 1
    assert sum(tally.values()) == 500
    assert tally['refused'] == sum(estimator.refusals.values()) > 0


def test_reset_forgets_the_run(estimator):
    estimator.reset()
    assert feed(estimator, [0.0], position=5.0) == [Reason.SETTLING]
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
    ({'max_gap': 0.0}, 'max_gap is 0.0; allowed: more than 0'),
    ({'max_velocity': [1.0]}, 'max_velocity has 1 values; allowed: one, or 2'),
    ({'continuous': [True]}, 'continuous has 1 values; allowed: 2'),
    ({'continuous': 1}, 'continuous is 1; allowed: 2 values'),
    ({'delay': '0.1'}, "delay is '0.1' s; allowed: 0 to 1 s"),
    ({'max_gap': None}, 'max_gap is None; allowed: more than 0'),
    ({'max_velocity': 'fast'}, "max_velocity is 'fast'; allowed: one, or 2 values"),
    ({'max_velocity': [1.0, 'x']}, "max_velocity is 'x'; allowed: more than 0"),
    ({'patience': '5'}, "patience is '5'; allowed: more than 0"),
    ({'min_samples': 8.5}, 'min_samples is 8.5; allowed: 1 or more'),
])
def test_wrong_settings_are_named(settings, message):
    with pytest.raises(InvalidValueError, match=message):
        MotionEstimator(2, **settings)


def test_unknown_kind_lists_the_known():
    with pytest.raises(UnknownNameError, match="unknown estimator 'magic'; known: 'bank'"):
        make_estimator('magic', 2)


@pytest.mark.parametrize('kind', ['bank', 'kalman', 'savitzky_golay', 'finite_difference'])
@pytest.mark.parametrize('number', [0, -1, '7', None, 7.5, True, [7]])
def test_the_number_of_joints_is_a_whole_one(kind, number):
    with pytest.raises(InvalidValueError, match='n_joints is .*; allowed: 1 or more'):
        make_estimator(kind, number)


@pytest.mark.parametrize('kind', sorted(ESTIMATORS))
def test_a_misspelt_setting_names_the_class(kind):
    with pytest.raises(TypeError, match=ESTIMATORS[kind].__name__ + '.*dealy'):
        ESTIMATORS[kind](2, dealy=0.1)


def test_a_limit_for_each_joint():
    estimator = MotionEstimator(2, max_velocity=[1.0, 100.0], max_jump=0.01)
    feed(estimator, PERIOD * np.arange(200))
    assert estimator.update(PERIOD * 200, [0.0, 0.1]) is not None
    assert estimator.update(PERIOD * 201, [0.05, 0.1]) is None
    assert estimator.reason is Reason.IMPLAUSIBLE_JUMP


def test_pauses_that_begin_anew_are_told():
    estimator = MotionEstimator(1)
    feed(estimator, 0.3 * np.arange(10))
    assert estimator.doubts() == [
        'pauses of up to 0.3 s, longer than max_gap 0.25 s: begun anew 9 times']


@pytest.mark.parametrize('kind', sorted(ESTIMATORS))
@pytest.mark.parametrize('start', [0, 1_700_000_000_123_456_789, -5_000_000_000])
def test_stamps_in_nanoseconds_stay_exact(kind, start):
    delay = 0 if kind == 'finite_difference' else 17_000_000
    estimator = make_estimator(kind, 1, delay=delay * 1e-9)
    for k in range(200):
        stamp = start + 2_000_000 * k + k % 7
        outcome = estimator.step(stamp, [0.001 * k], [0.5])
        if k > 100:
            assert outcome.stamp_ns == stamp - delay
            assert len(outcome.values) == 4
    assert isinstance(estimator.step(stamp, [0.1], None), Reason)


@pytest.mark.parametrize('position', [None, 3.0, [[0.0, 0.0]], [None, 0.0]], ids=str)
def test_positions_that_are_no_numbers_in_a_row(position):
    with pytest.raises(InvalidValueError, match='numbers in a row; got'):
        ESTIMATORS['bank'](2).update(0.0, position)
