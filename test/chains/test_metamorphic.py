# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What must not change where a chain is described otherwise: frames moved, joints inserted."""
from hypothesis import given, settings, strategies as st
import numpy as np
from screw_kinematics import Joint, SerialChain
from screw_kinematics.screws.rotations import pose, rotation_rpy

KINDS = ('revolute', 'prismatic', 'helical', 'continuous')
PLAIN = settings(max_examples=25, deadline=None, derandomize=True)
SEEDS = st.integers(0, 10**6)


def random_pose(rng):
    return pose(rotation_rpy(*rng.uniform(-3, 3, 3)), rng.normal(size=3))


def random_joints(rng, n=4):
    kinds = rng.choice(KINDS, n)
    return [Joint(f'q{k}', kind, rng.normal(size=3), rng.normal(size=3),
                  pitch=0.1 if kind == 'helical' else None) for k, kind in enumerate(kinds)]


def moved(joint, T):
    """Return a joint of a base that is seen from elsewhere."""
    return Joint(joint.name, joint.kind, T[:3, :3] @ joint.axis,
                 T[:3, :3] @ joint.point + T[:3, 3], joint.pitch)


def classical(chain, motion):
    """Return twist, acceleration and jerk, by the recursion and by the compiled program."""
    state = chain.state(*motion)
    program = chain.compile(('twist', 'accel', 'jerk'))(*motion)
    found = np.array([state.classical(n) for n in (1, 2, 3)])
    np.testing.assert_allclose(list(program.values()), found, rtol=1e-9, atol=1e-9)
    return state.pose, found


@PLAIN
@given(SEEDS)
def test_the_base_may_be_seen_from_elsewhere(seed):
    rng = np.random.default_rng(seed)
    joints, tool, T = random_joints(rng), random_pose(rng), random_pose(rng)
    motion = rng.normal(size=(4, 4))
    where, seen = classical(SerialChain(joints, tool), motion)
    there, other = classical(
        SerialChain([moved(joint, T) for joint in joints], T @ tool), motion)
    np.testing.assert_allclose(there, T @ where, atol=1e-9)
    turned = seen.reshape(3, 2, 3) @ T[:3, :3].T
    np.testing.assert_allclose(other.reshape(3, 2, 3), turned, rtol=1e-8, atol=1e-8)


@PLAIN
@given(SEEDS, st.integers(0, 4))
def test_a_joint_that_rests_is_no_joint(seed, place):
    rng = np.random.default_rng(seed)
    joints, tool = random_joints(rng), random_pose(rng)
    motion = rng.normal(size=(4, 4))
    more = [*joints[:place], Joint('resting', 'revolute', rng.normal(size=3),
                                   rng.normal(size=3)), *joints[place:]]
    where, seen = classical(SerialChain(joints, tool), motion)
    there, other = classical(SerialChain(more, tool), np.insert(motion, place, 0.0, axis=1))
    np.testing.assert_allclose(there, where, atol=1e-9)
    np.testing.assert_allclose(other, seen, rtol=1e-8, atol=1e-8)


@PLAIN
@given(SEEDS, st.integers(0, 3), st.floats(0.1, 0.9))
def test_a_joint_may_be_two_on_one_axis(seed, place, share):
    rng = np.random.default_rng(seed)
    joints, tool = random_joints(rng), random_pose(rng)
    motion = rng.normal(size=(4, 4))
    one = joints[place]
    twin = Joint('twin', one.kind, one.axis, one.point, one.pitch)
    shared = np.insert(motion, place, share * motion[:, place], axis=1)
    shared[:, place + 1] *= 1 - share
    where, seen = classical(SerialChain(joints, tool), motion)
    there, other = classical(
        SerialChain([*joints[:place], twin, *joints[place:]], tool), shared)
    np.testing.assert_allclose(there, where, atol=1e-9)
    np.testing.assert_allclose(other, seen, rtol=1e-8, atol=1e-8)
