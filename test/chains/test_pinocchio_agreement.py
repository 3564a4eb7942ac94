# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Kinematic states agree with Pinocchio's on robots as manufacturers describe them."""
import numpy as np
import pytest

from screw_kinematics import models
from screw_kinematics.errors import ModelError
from support.pinocchio_reference import example_robot, followers, pin, Reference

TOLERANCE = 1e-12
SAMPLES = 20

CASES = {
    'panda': ('panda', 'panda_link0', 'panda_link8'),
    'panda, tool': ('panda', 'panda_link0', 'panda_hand_tcp'),
    'panda, prismatic and mimic': ('panda', 'panda_link0', 'panda_leftfinger'),
    'panda, mimic whose source is elsewhere': ('panda', 'panda_link0', 'panda_rightfinger'),
    'panda, base inside the arm': ('panda', 'panda_link3', 'panda_link8'),
    'panda, upwards only': ('panda', 'panda_link8', 'panda_link0'),
    'panda, finger to finger': ('panda', 'panda_rightfinger', 'panda_leftfinger'),
    'ur5': ('ur5_robot', 'world', 'tool0'),
    'ur5, base beside the arm': ('ur5_robot', 'base', 'ee_link'),
    'baxter, hand to hand': ('baxter', 'left_gripper', 'right_gripper'),
    'baxter, mimic fingers': ('baxter', 'torso', 'l_gripper_r_finger'),
    'tiago, lift and arm': ('tiago', 'base_footprint', 'arm_7_link'),
    'pr2, continuous joints and gripper': (
        'pr2', 'base_footprint', 'r_gripper_l_finger_tip_link'),
    'pr2, hand to hand': ('pr2', 'l_gripper_r_finger_tip_link', 'r_gripper_palm_link'),
}


def build(case):
    robot, base, tip = CASES[case]
    path = example_robot(robot)
    chain = models.load(path, base, tip)
    return chain, Reference(pin.buildModelFromUrdf(str(path)), base, tip, chain.joint_names,
                            followers(path))


def relative_errors(actual, expected):
    """Return the largest error of each array of a batch, relative to its largest entry."""
    axes = tuple(range(1, expected.ndim))
    return np.max(np.abs(actual - expected), axes) / np.max(np.abs(expected), axes)


def check_states(chain, reference, rng):
    q, qd, qdd = rng.uniform(-2, 2, size=(3, SAMPLES, chain.dof))
    expected = [np.array(x) for x in zip(*map(reference.motion, q, qd, qdd))]
    state = chain.state(q, qd, qdd)
    actual = [state.pose, state.velocity, state.reduced_acceleration, state.classical(2)]
    for name, a, e in zip(('pose', 'twist', 'reduced', 'classical'), actual, expected):
        assert np.max(relative_errors(a, e)) < TOLERANCE, name


@pytest.mark.parametrize('case', CASES)
def test_states_agree(case):
    chain, reference = build(case)
    check_states(chain, reference, np.random.default_rng(sum(case.encode())))


def random_tree(rng, count):
    """Return the URDF of a random tree: all kinds, arbitrary axes, origins and branches."""
    def numbers(scale):
        return ' '.join(map(repr, rng.uniform(-scale, scale, 3).tolist()))

    parts = ['<link name="l0"/>']
    for i in range(1, count + 1):
        kind = rng.choice(['revolute', 'revolute', 'continuous', 'prismatic', 'fixed'])
        parts.append(
            f'<link name="l{i}"/><joint name="j{i}" type="{kind}">'
            f'<parent link="l{rng.integers(max(0, i - 3), i)}"/><child link="l{i}"/>'
            f'<origin xyz="{numbers(1)}" rpy="{numbers(3)}"/><axis xyz="{numbers(5)}"/>'
            f'<limit lower="-9" upper="9" effort="1" velocity="1"/></joint>')
    return '<robot name="tree">' + ''.join(parts) + '</robot>'


@pytest.mark.parametrize('seed', range(8))
def test_states_agree_between_any_two_links(seed):
    """Of a random tree; most paths go up first, then down."""
    rng = np.random.default_rng(seed)
    text = random_tree(rng, 15)
    model = pin.buildModelFromXML(text)
    for base, tip in rng.integers(0, 15, size=(4, 2)):
        frames = f'l{base}', f'l{tip}'
        try:
            chain = models.load_urdf(text, *frames)
        except ModelError as error:
            assert 'nothing moves' in str(error)
            continue
        check_states(chain, Reference(model, *frames, chain.joint_names), rng)


def test_panda_model_file_is_the_urdf_arm():
    """The manufacturer's DH figures and its URDF are the same arm, to rounding."""
    urdf = models.load(example_robot('panda'), 'panda_link0', 'panda_link8')
    rows = models.load('package://screw_kinematics/config/robots/panda.yaml')
    assert rows.joint_names == urdf.joint_names
    assert (rows.base_frame, rows.tip_frame) == (urdf.base_frame, urdf.tip_frame)
    q, qd, qdd = np.random.default_rng(4).uniform(-2, 2, size=(3, 50, 7))
    ours, theirs = rows.state(q, qd, qdd), urdf.state(q, qd, qdd)
    np.testing.assert_allclose(ours.pose, theirs.pose, rtol=0, atol=1e-14)
    np.testing.assert_allclose(ours.reduced_acceleration, theirs.reduced_acceleration, rtol=0,
                               atol=1e-12)
