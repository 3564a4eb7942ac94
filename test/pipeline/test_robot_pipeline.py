# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The logic of one robot: every sample is used or refused, and outputs are the chain's."""
import math

import numpy as np
import pytest
from screw_kinematics import Joint, SerialChain
from screw_kinematics.errors import Reason, SingularityError
from screw_kinematics.pipeline.kinematics import Kinematics
from screw_kinematics.pipeline.robot_model import plausible_velocities
from screw_kinematics.pipeline.robot_pipeline import RobotPipeline
from screw_kinematics.pipeline.robot_program import OneTip
from screw_kinematics.pipeline.settings import MotionSettings
from support.pipeline_arm import (
    ARM, assert_balanced, feed, joints, make, MEASURED, MS, NAMES, START, take)


def test_measured_twist_is_the_chains_at_every_sample():
    outputs = feed(make(), 50)
    assert [stamp for stamp, _ in outputs] == [START + 2 * MS * k for k in range(50)]
    for stamp, values in outputs:
        q, qd, _ = joints((stamp - START) * 1e-9)
        assert np.allclose(values, ARM.state(q, qd).velocity, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize('delay', [0.0, 0.02])
def test_estimated_acceleration_describes_the_instant_it_is_stamped_with(delay):
    pipeline = make(MotionSettings(delay=delay), ('twist', 'accel'))
    outputs = feed(pipeline, 500)
    last = START + 499 * 2 * MS
    assert abs(outputs[-1][0] - (last - round(delay * 1e9))) <= 1
    for stamp, values in outputs[300:]:
        q, qd, qdd = joints((stamp - START) * 1e-9)
        truth = ARM.state(q, qd, qdd)
        assert np.allclose(values[:6], truth.classical(1), atol=1e-4)
        assert np.allclose(values[6:], truth.classical(2), atol=2e-3)
    assert_balanced(pipeline)


def bad_samples():
    """Return samples that must not be used, and the reason."""
    good = [0.1, 0.2, 0.3]
    return [
        (NAMES, good[:2], [], 'position_of_wrong_length'),
        (NAMES, [], [], 'position_of_wrong_length'),
        (NAMES, [*good, 0.0], [], 'position_of_wrong_length'),
        (NAMES, [0.1, math.nan, 0.3], good, 'position_not_finite'),
        (NAMES, [0.1, math.inf, -math.inf], good, 'position_not_finite'),
        (NAMES, [1e300, -1e300, 0.3], good, 'position_not_finite'),
        (('lamp',), [0.1], [0.1], Reason.NO_JOINT),
        ((), [], [], Reason.NO_JOINT),
        (('q1', 'q2', 'q3', 'q1'), [*good, 0.1], [], 'joint_named_twice'),
        (NAMES, good, [], 'velocity_not_measured'),
        (NAMES, good, [0.0, math.nan, 0.0], 'velocity_not_measured'),
        (NAMES, good, [0.0, 1e300, 0.0], 'velocity_not_measured'),
        (NAMES, good, good[:2], 'velocity_not_measured')]


@pytest.mark.parametrize('names, position, velocity, reason', bad_samples())
def test_a_bad_sample_is_refused_with_its_reason_and_leaves_no_trace(
        names, position, velocity, reason):
    pipeline, undisturbed = make(), make()
    feed(pipeline, 3)
    assert take(pipeline, START + 6 * MS, names, position, velocity) == reason
    assert pipeline.account.refused == {reason: 1}
    assert_balanced(pipeline)
    feed(undisturbed, 3)
    later = START + 100 * MS
    assert feed(pipeline, 3, later) == feed(undisturbed, 3, later)


@pytest.mark.parametrize('settings', [MEASURED, MotionSettings()])
def test_stamps_that_do_not_advance_are_refused(settings):
    pipeline = make(settings)
    feed(pipeline, 20)
    n = pipeline.account.outputs
    q, qd, _ = joints(0.04)
    for stamp in (START + 38 * MS, START + 30 * MS, START):
        assert take(pipeline, stamp, NAMES, q, qd) is Reason.STAMP_NOT_INCREASING
    assert pipeline.account.refused == {'stamp_not_increasing': 3}
    assert not isinstance(take(pipeline, START + 40 * MS, NAMES, q, qd), Reason)
    assert pipeline.account.outputs == n + 1


@pytest.mark.parametrize('settings', [MEASURED, MotionSettings()])
def test_a_loop_in_time_begins_anew(settings):
    pipeline = make(settings)
    first = feed(pipeline, 400)
    again = feed(pipeline, 400)
    assert len(again) == len(first)
    assert np.allclose([v for _, v in again[100:]], [v for _, v in first[100:]], atol=1e-6)


def test_a_reset_forgets_the_samples_and_keeps_the_counts():
    pipeline = make()
    feed(pipeline, 10)
    pipeline.reset()
    assert len(feed(pipeline, 10)) == 10
    assert pipeline.account.outputs == 20


@pytest.mark.parametrize('velocity', [False, True])
def test_estimation_needs_no_measured_velocity(velocity):
    outputs = feed(make(MotionSettings(velocity_source='estimated')), 300, velocity=velocity)
    q, qd, _ = joints(299 * 2e-3)
    assert np.allclose(outputs[-1][1], ARM.state(q, qd).velocity, atol=1e-4)


@pytest.mark.parametrize('told, incomplete', [(1, False), (2, True)])
def test_what_a_covariance_is_made_from_alone_is_not_missed(told, incomplete):
    """With measured velocities twists come from the first message on, accelerations later."""
    pipeline = RobotPipeline(ARM.joint_names, MEASURED)
    program = OneTip(ARM.compile(outputs=('twist', 'reduced_accel')))
    pipeline.activate(Kinematics(program, covariance=True, order=told))
    assert len(feed(pipeline, 50)) == 50
    assert bool(pipeline.account.incomplete) == incomplete


def test_nothing_wanted_is_nothing_computed_and_still_accounted_for():
    pipeline = RobotPipeline(ARM.joint_names, MotionSettings())
    assert feed(pipeline, 5) == []
    assert pipeline.account.used_later == {Reason.NOTHING_WANTED: 5}
    assert pipeline.estimators() == [] or pipeline.estimators()[0].reason is Reason.SETTLING
    assert pipeline.missing() == []


def test_other_outputs_go_on_with_the_same_estimator():
    pipeline = make(MotionSettings(), ('twist',))
    feed(pipeline, 50)
    before = pipeline.estimators()
    pipeline.activate(Kinematics(OneTip(ARM.compile(outputs=('accel', 'pose')))))
    q, qd, _ = joints(0.1)
    assert len(take(pipeline, START + 100 * MS, NAMES, q, qd).values) == 18
    assert pipeline.estimators() == before


def test_variances_are_those_of_the_estimator_and_unknown_where_measured():
    def latest(settings, outputs):
        pipeline = make(settings, outputs, covariance=True)
        feed(pipeline, 100)
        q, qd, _ = joints(0.2)
        return np.reshape(take(pipeline, START + 200 * MS, NAMES, q, qd).motion.variances, (4, 3))

    assert np.all(latest(MotionSettings(), ('twist', 'jacobian')) > 0)
    measured = latest(MEASURED, ('twist', 'accel'))
    assert np.all(np.isnan(measured[:2])) and np.all(measured[2:] > 0)


def test_nobody_pays_for_variances_that_are_not_wanted():
    pipeline = make(MotionSettings(), ('accel',))
    feed(pipeline, 100)
    q, qd, _ = joints(0.2)
    assert take(pipeline, START + 200 * MS, NAMES, q, qd).motion.variances == ()


def test_measured_velocities_are_published_however_slowly_they_come():
    """No acceleration can be told from samples a second apart, so the state ends before it."""
    pipeline = make(MEASURED, ('twist', 'accel'))
    for k in range(5):
        q, qd, _ = joints(k)
        state = take(pipeline, START + k * 1000 * MS, NAMES, q, qd)
        assert state.order == 1
        assert np.allclose(state.values[:6], ARM.state(q, qd).velocity, rtol=1e-12, atol=1e-14)
    outputs = feed(pipeline, 50, START + 6000 * MS)
    assert len(outputs) == 50
    q, qd, _ = joints(0.1)
    assert take(pipeline, START + 6100 * MS, NAMES, q, qd).order == 2


@pytest.mark.parametrize('failure, reason', [
    (SingularityError('legs do not reach'), Reason.NO_SOLUTION),
    (ZeroDivisionError(), Reason.NO_SOLUTION),
    (math.inf, Reason.STATE_NOT_FINITE), (math.nan, Reason.STATE_NOT_FINITE)])
def test_a_posture_without_a_state_is_refused_and_the_next_one_used(failure, reason):
    class Fails:
        order, dof, fails = 0, 3, True
        moving_base, standing_base = False, True

        def evaluate(self, values):
            if self.fails and isinstance(failure, Exception):
                raise failure
            return (failure if self.fails else values[0],)

    program = Fails()
    pipeline = RobotPipeline(NAMES, MotionSettings())
    pipeline.activate(Kinematics(program))
    assert take(pipeline, START, NAMES, [0.5, 0, 0]) is reason
    assert pipeline.account.refused == {reason: 1}
    assert pipeline.account.details[reason] == (
        str(failure) if isinstance(failure, Exception) else '')
    program.fails = False
    assert take(pipeline, START + MS, NAMES, [0.5, 0, 0]).values == (0.5,)
    assert_balanced(pipeline)


def test_snap_of_a_smooth_motion():
    def derivative(k, t):
        w, a = np.array([1.0, 1.5, 0.7]), np.array([0.4, 0.3, 0.1])
        return a * w**k * np.sin(w * t + k * math.pi / 2)

    outputs = feed(make(MotionSettings(delay=0.02), ('snap',)), 1000)[500:]
    truth = [ARM.state(*(derivative(k, (stamp - START) * 1e-9) for k in range(5))).classical(4)
             for stamp, _ in outputs]
    assert np.allclose([v for _, v in outputs], truth, atol=0.03)    # of 0.4 to 1.8


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize('source', ['auto', 'measured', 'estimated'])
@pytest.mark.parametrize('seed', range(4))
def test_hostile_samples_never_raise_nor_lead_to_numbers_that_are_none(source, seed):
    rng = np.random.default_rng(seed)
    strange = [0.0, 5e-324, 1e6, 1e155, -1e308, math.nan, math.inf, -math.inf]
    delay = 0.02 if seed % 2 and source != 'measured' else 0.0
    pipeline = make(MotionSettings(source, delay=delay), ('pose', 'accel', 'snap', 'jacobian'),
                    covariance=True)
    t = START
    for _ in range(400):
        names = [*NAMES, 'lamp'] if rng.random() < 0.9 else [*NAMES, 'q1']
        rng.shuffle(names)
        names = names[:rng.integers(5)] if rng.random() < 0.1 else names
        q, qd = (dict(zip((*NAMES, 'lamp'), (*x, 0.0))) for x in joints((t - START) * 1e-9)[:2])
        position, velocity = ([x[n] if rng.random() < 0.98 else rng.choice(strange)
                               for n in names] for x in (q, qd))
        velocity = velocity if rng.random() < 0.9 else []
        step = rng.choice([0, 1, -5, -10**9, 10**9, 10**17]) if rng.random() < 0.05 else 2 * MS
        t = max(1, t + int(step))
        state = take(pipeline, t, names, position, velocity)
        if not isinstance(state, Reason):
            assert np.all(np.isfinite(state.values))
    assert pipeline.account.outputs > 50
    assert_balanced(pipeline)


def test_a_step_that_the_description_does_not_allow_is_refused():
    """A joint of at most 0.5 rad/s does not jump by 0.1 rad in 2 ms, though 20 rad/s would."""
    chain = SerialChain([Joint('q1', 'revolute', axis=(0, 0, 1), velocity_limit=0.5)])
    for limits, refused in ((plausible_velocities(MotionSettings(), chain), 1), (None, 0)):
        pipeline = RobotPipeline(chain.joint_names, MotionSettings(), max_velocity=limits)
        pipeline.activate(Kinematics(OneTip(chain.compile(outputs=('twist',)))))
        for k in range(50):
            take(pipeline, START + k * 10 * MS, ('q1',), [0.1 * math.sin(k / 100)])
        take(pipeline, START + 500 * MS, ('q1',), [0.15])
        assert pipeline.account.refused[Reason.IMPLAUSIBLE_JUMP] == refused
        assert not refused or pipeline.account.details == {
            Reason.IMPLAUSIBLE_JUMP: f'q1 by {0.15 - 0.1 * math.sin(0.49):.3g}'}
    assert plausible_velocities(MotionSettings(options={'max_velocity': 0.3}), chain) == (0.3,)


@pytest.mark.parametrize('rate', [100, 1000])
def test_stamps_rounded_as_floats_of_seconds_are_raise_no_doubt(rate):
    """Of 1.7e9 s a float resolves 238 ns; the velocities are exact."""
    pipeline = make(MotionSettings(), ('twist', 'accel'))
    for k in range(4 * rate):
        q, qd, _ = joints(k / rate)
        take(pipeline, (START + k * 10**9 // rate) // 238 * 238, NAMES, q, qd)
    assert pipeline.doubts() == []
    assert list(pipeline.estimators()[0].velocity_used) == [True] * 3
