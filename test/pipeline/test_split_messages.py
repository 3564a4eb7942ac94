# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joints split over several messages give the same as joined in one: a law without a truth."""
from hypothesis import given, HealthCheck, settings, strategies as st
import numpy as np
from screw_kinematics.errors import Reason
from screw_kinematics.pipeline.settings import MotionSettings
from support.pipeline_arm import assert_balanced, joints, make, MS, NAMES, START, take

COUNT = 150
PLAIN = settings(max_examples=12, deadline=None, derandomize=True,
                 suppress_health_check=list(HealthCheck))


@st.composite
def splits(draw):
    """Return for each round which joints come in which message, in the order of the messages."""
    group_of = draw(st.lists(st.integers(0, 2), min_size=3, max_size=3))
    groups = [[j for j in range(3) if group_of[j] == g] for g in sorted(set(group_of))]
    mixed = draw(st.booleans())
    return [draw(st.permutations([draw(st.permutations(group)) for group in groups]))
            if mixed or not k else groups for k in range(12)]


def outputs(parts_of_round, motion, noise, velocity, **options):
    """Return stamps and values of the states that a stream leads to."""
    pipeline = make(motion, ('pose', 'twist', 'accel'), **options)
    found = {}
    for k in range(COUNT):
        q, qd, _ = joints(k * 4e-3)
        for own in parts_of_round[k % len(parts_of_round)]:
            state = take(pipeline, START + k * 4 * MS, [NAMES[j] for j in own],
                         (q + noise[k])[own], qd[own] if velocity else ())
            if not isinstance(state, Reason):
                found[state.stamp_ns] = state.values
    assert_balanced(pipeline)
    return found


@PLAIN
@given(splits(), st.sampled_from([0.0, 0.02]), st.booleans(),
       st.sampled_from(['auto', 'estimated', 'measured']), st.integers(0, 1000))
def test_joints_split_over_messages_give_the_same_as_joined(split, delay, velocity, source, seed):
    velocity = velocity or source == 'measured'
    motion = MotionSettings(velocity_source=source, delay=0.0 if source == 'measured' else delay)
    noise = np.random.default_rng(seed).normal(0, 1e-5, (COUNT, 3))
    joined = outputs([[[0, 1, 2]]], motion, noise, velocity)
    parts = outputs(split, motion, noise, velocity)
    # What is first told of a run, and when, depends on the joint that is mostly noise for longest.
    common = [stamp for stamp in joined if stamp >= START + 250 * MS]
    assert len(common) > COUNT / 2
    sizes = np.abs([joined[stamp] for stamp in common]).max(axis=0) + 1e-9
    # Estimates know the clock of their own messages only, so they may differ by some noise.
    tolerance = np.full(24, 2e-2)
    if source == 'measured':
        tolerance[:18] = 1e-12      # pose and twist, which are nobody's estimates
    for stamp in common:
        assert (np.abs(np.subtract(parts[stamp], joined[stamp])) <= tolerance * sizes).all()
