# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Poles, axes, and combinations of motions against exact differentiation."""
import numpy as np
import pytest

from screw_kinematics import BodyState
from screw_kinematics.errors import InvalidValueError, ShapeError, UnknownNameError
from screw_kinematics.screws import se3
from support import exact, robots

FIRST, SECOND = robots.random_chain(11), robots.random_chain(12, joints=5)
FIRST_MOTION = robots.random_motion(11, FIRST.dof)
SECOND_MOTION = robots.random_motion(12, SECOND.dof)


def assert_is(state, motion, relative=1e-11):
    """Compare pose, reduced and classical states of all orders with exact motion."""
    np.testing.assert_allclose(state.pose, motion.pose, rtol=0, atol=1e-12)
    for n in range(1, 5):
        for found, expected in ((state.reduced[n - 1], motion.reduced[n - 1]),
                                (state.classical(n), motion.classical[n - 1])):
            np.testing.assert_allclose(found, expected, rtol=0,
                                       atol=relative * np.abs(expected).max())


def test_moving_base():
    outer, inner = FIRST.state(*FIRST_MOTION), SECOND.state(*SECOND_MOTION)
    pose = (exact.chain_pose(FIRST, *FIRST_MOTION)
            @ exact.chain_pose(SECOND, *SECOND_MOTION))
    assert_is(outer.followed_by(inner), exact.motion_of(pose))
    # Poles and axes of the operands do not matter.
    moved = outer.about('base').expressed_in('tip')
    assert_is(moved.followed_by(inner.expressed_in('tip').about('base')),
              exact.motion_of(pose))


def test_moving_observer():
    hand, camera = FIRST.state(*FIRST_MOTION), SECOND.state(*SECOND_MOTION)
    pose = (exact.inverse(exact.chain_pose(SECOND, *SECOND_MOTION))
            @ exact.chain_pose(FIRST, *FIRST_MOTION))
    seen = hand.relative_to(camera)
    assert_is(seen, exact.motion_of(pose))
    back = camera.followed_by(seen)
    for n in range(4):
        np.testing.assert_allclose(back.reduced[n], hand.reduced[n], rtol=1e-9, atol=1e-9)


def test_the_base_seen_from_the_tip_is_the_inverse_motion():
    state = FIRST.state(*FIRST_MOTION)
    base = BodyState.at_rest(np.eye(4), 4, tip_frame='base')
    assert_is(base.relative_to(state),
              exact.motion_of(exact.inverse(exact.chain_pose(FIRST, *FIRST_MOTION))))


def test_another_frame_of_the_same_body():
    T = se3.exp(np.array([0.3, -1, 2, 0.1, 0.2, -0.7]))
    expected = exact.motion_of(exact.chain_pose(FIRST, *FIRST_MOTION) @ exact.exact(T))
    state = FIRST.state(*FIRST_MOTION).with_tool(T, 'camera')
    assert_is(state, expected)
    assert_is(FIRST.with_tool(T, 'camera').state(*FIRST_MOTION), expected)
    assert state.tip_frame == 'camera'


def test_tip_axes_and_the_derivatives_of_tip_components():
    state = FIRST.state(*FIRST_MOTION)
    motion = exact.tip_motion(FIRST, *FIRST_MOTION)
    in_tip = state.expressed_in('tip')
    for n in range(4):
        np.testing.assert_allclose(in_tip.reduced[n],
                                   se3.rotate(motion.pose[:3, :3].T, motion.reduced[n]),
                                   rtol=0, atol=1e-11 * np.abs(motion.reduced[n]).max())
        np.testing.assert_allclose(state.about('base').body_derivatives()[n], motion.body[n],
                                   rtol=0, atol=1e-11 * np.abs(motion.body[n]).max())
    # Equal to the acceleration, not to the jerk.
    np.testing.assert_allclose(in_tip.reduced_acceleration, motion.body[1], rtol=1e-10)
    assert np.abs(in_tip.reduced_jerk - motion.body[2]).max() > 0.1


@pytest.mark.parametrize('shape', [(), (3,)])
def test_pole_and_axes_commute_and_return(shape):
    state = FIRST.state(*robots.random_motion(1, FIRST.dof, shape=shape))
    point = np.array([0.4, -0.2, 1.5])
    one = state.about(point).expressed_in('tip')
    other = state.expressed_in('tip').about(point)
    back = one.about('base').expressed_in('base').about('tip')
    for n in range(4):
        np.testing.assert_allclose(one.reduced[n], other.reduced[n], rtol=1e-10, atol=1e-10)
        np.testing.assert_allclose(back.reduced[n], state.reduced[n], rtol=1e-10, atol=1e-9)
    assert (one.pole, one.axes, back.pole, back.axes) == ('point', 'tip', 'tip', 'base')


def test_orders_have_names_and_missing_ones_are_refused():
    state = FIRST.state(*FIRST_MOTION[:4])
    assert state.velocity is state.reduced[0] and state.reduced_acceleration is state.reduced[1]
    assert state.reduced_jerk is state.reduced[2]
    with pytest.raises(InvalidValueError, match='snap needs the joint derivatives of order '
                                                '1 to 4; this state was computed with 3'):
        state.reduced_snap
    with pytest.raises(InvalidValueError, match='order 0 of a state; allowed: 1'):
        state.classical(0)


@pytest.mark.parametrize('name, n', [('acceleration', 2), ('jerk', 3), ('snap', 4)])
def test_classical_motion_by_name_is_the_derivative_of_the_tip(name, n):
    state, motion = FIRST.state(*FIRST_MOTION), exact.tip_motion(FIRST, *FIRST_MOTION)
    np.testing.assert_allclose(getattr(state, f'classical_{name}'), motion.classical[n - 1],
                               rtol=0, atol=1e-11 * np.abs(motion.classical[n - 1]).max())
    np.testing.assert_array_equal(getattr(state, f'reduced_{name}'), state.reduced[n - 1])


def test_the_lower_order_of_two_states_counts():
    outer = FIRST.state(*FIRST_MOTION[:3])
    inner = SECOND.state(*SECOND_MOTION)
    assert len(outer.followed_by(inner).reduced) == len(inner.relative_to(outer).reduced) == 2


def test_wrong_poles_and_axes_are_refused():
    state = FIRST.state(*FIRST_MOTION[:2])
    with pytest.raises(UnknownNameError, match="unknown pole 'hand'; known: 'base', 'tip'"):
        state.about('hand')
    with pytest.raises(ShapeError, match=r'pole: expected shape \(\.\.\., 3\), got \(2,\)'):
        state.about(np.zeros(2))
    with pytest.raises(UnknownNameError, match="unknown axes 'world'; known: 'base', 'tip'"):
        state.expressed_in('world')
