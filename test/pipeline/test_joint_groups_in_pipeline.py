# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joints that come in any order, in several messages, late, or no more."""
import numpy as np
import pytest
from screw_kinematics.errors import Reason
from screw_kinematics.pipeline.settings import MotionSettings
from support.pipeline_arm import (
    ARM, assert_balanced, feed, joints, make, MS, NAMES, START, take)


def test_joints_in_several_messages_are_merged_at_one_instant():
    parts = make(MotionSettings(), ('twist', 'accel'))
    for k in range(300):
        q, qd, _ = joints(k * 2e-3)
        t = START + k * 2 * MS
        assert isinstance(take(parts, t, ('q3',), [q[2]], [qd[2]]), Reason)
        state = take(parts, t, ('q2', 'q1'), [q[1], q[0]], [qd[1], qd[0]])
    truth = ARM.state(*joints(299 * 2e-3))
    assert state.stamp_ns == t
    assert np.allclose(state.values[6:], truth.classical(2), atol=2e-3)
    assert parts.account.used_later[Reason.MERGED] == 300 - 8
    assert parts.account.refused == {Reason.JOINTS_MISSING: 1}
    assert_balanced(parts)


@pytest.mark.parametrize('source', ['auto', 'measured'])
def test_a_slow_message_is_carried_on_by_its_jerk(source):
    """At 50 Hz for up to 20 ms: without the jerk accelerations are wrong by 1.2 m/s2."""
    pipeline = make(MotionSettings(velocity_source=source), ('accel',))
    w, errors = 6.0, []
    for k in range(1500):
        t = 2e-3 * k
        for names in ([('q3',)] if k % 10 == 0 else []) + [('q1', 'q2')]:
            q, qd, _ = sine(t, w)
            pick = [NAMES.index(name) for name in names]
            state = take(pipeline, START + 2 * MS * k, names, q[pick], qd[pick])
        if k > 1000 and not isinstance(state, Reason):
            truth = ARM.state(*sine((state.stamp_ns - START) * 1e-9, w))
            errors.append(np.abs(state.values - truth.classical(2)).max())
    assert len(errors) > 400 and max(errors) < 0.4
    assert_balanced(pipeline)


@pytest.mark.parametrize('source', ['auto', 'estimated', 'measured'])
def test_what_is_carried_states_how_far_off_it_may_be_by_then(source):
    """Of a joint at 50 Hz, 10 ms and more after its message, beside others at 500 Hz."""
    pipeline = make(MotionSettings(velocity_source=source), ('accel',), covariance=True)
    rng, w, errors = np.random.default_rng(9), 6.0, []
    for k in range(6000):
        for names in ([('q3',)] if k % 10 == 0 else []) + [('q1', 'q2')]:
            q, qd, _ = sine(2e-3 * k, w) + rng.normal(0, 1, (3, 3)) * [[1e-4], [1e-3], [0]]
            pick = [NAMES.index(name) for name in names]
            state = take(pipeline, START + 2 * MS * k, names, q[pick],
                         qd[pick] if source != 'estimated' else ())
        if k > 1000 and k % 10 >= 5 and not isinstance(state, Reason):
            truth = np.array(sine((state.stamp_ns - START) * 1e-9, w))[:, 2]
            values, variances = (np.reshape(part, (4, 3))[:3, 2] for part in (
                state.motion.values, state.motion.variances))
            errors.append((values - truth) / np.sqrt(variances))
    score = np.sqrt(np.mean(np.square(errors), axis=0))
    told = slice(2, 3) if source == 'measured' else slice(0, 3)
    assert len(errors) > 2000 and (0.2 < score[told]).all() and (score[told] < 1.2).all(), score


def sine(t, w):
    """Return positions, velocities and accelerations of a fast motion."""
    a = np.array([0.3, 0.3, 0.3])
    return a * np.sin(w * t), a * w * np.cos(w * t), -a * w * w * np.sin(w * t)


def test_silent_joints_are_missing_after_the_timeout_and_may_come_from_elsewhere():
    pipeline = make(MotionSettings(), ('pose',))
    assert pipeline.missing() == list(NAMES)
    feed(pipeline, 5, names=('q1', 'q2'))
    assert pipeline.missing() == ['q3']
    pipeline.release_stale(0.0, 0.5)
    feed(pipeline, 5, START + 10 * MS, names=('q1', 'q2'))
    pipeline.release_stale(0.1, 0.5)
    for now in (0.2, 0.4, 0.6):
        pipeline.release_stale(now, 0.5)
    assert pipeline.missing() == ['q3']
    pipeline.release_stale(0.7, 0.5)
    assert pipeline.missing() == list(NAMES)
    assert len(feed(pipeline, 20, START + 900 * MS)) == 20


def test_late_delivery_of_a_steady_stream_costs_no_sample():
    pipeline = make(MotionSettings(), ('accel',))
    feed(pipeline, 50)
    for now in (0.0, 0.2, 0.4, 0.6):
        pipeline.release_stale(now, 0.3)
    assert pipeline.missing() == list(NAMES)
    assert len(feed(pipeline, 50, START + 100 * MS)) == 50


def test_a_larger_message_takes_the_place_of_its_parts():
    pipeline = make(MotionSettings(), ('pose',))
    feed(pipeline, 3, names=('q1',))
    feed(pipeline, 3, names=('q3', 'q2'))
    outputs = feed(pipeline, 20, START + 10 * MS)
    assert len(outputs) == 20
    for stamp, values in outputs:
        q = joints((stamp - START - 10 * MS) * 1e-9)[0]
        assert np.allclose(values[:3], ARM.pose(q)[:3, 3], rtol=1e-12)
    assert feed(pipeline, 3, names=('q1',)) == []


def test_a_node_that_was_held_up_does_not_take_its_queue_for_silence():
    pipeline = make(MotionSettings(), ('twist',))
    feed(pipeline, 50)
    pipeline.release_stale(0.0, 0.5)
    pipeline.release_stale(0.1, 0.5)
    pipeline.release_stale(5.0, 0.5)
    assert pipeline.missing() == []
    assert len(feed(pipeline, 50, START + 100 * MS)) == 50
