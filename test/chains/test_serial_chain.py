# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Chains against exact differentiation."""
import numpy as np
import pytest

from screw_kinematics import Joint, Mimic, SerialChain
from screw_kinematics.errors import InvalidValueError, ShapeError, UnknownNameError
from screw_kinematics.screws import se3
from support import exact, robots

GRIPPER = SerialChain([
    Joint('turn', 'helical', axis=(1, 2, 2), point=(0.1, 0, 0.3), pitch=0.2),
    Joint('left', 'prismatic', axis=(0, 1, 0)),
    Joint('right', 'revolute', axis=(0, 1, 1), point=(0, 0, 1), mimic=Mimic('left', -2, 0.5)),
    Joint('third', 'prismatic', axis=(1, 0, 0), mimic=Mimic('motor', 0.5, 0.1)),
], np.array([[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]))


def assert_exact(chain, motion):
    state, expected = chain.state(*motion), exact.tip_motion(chain, *motion)
    np.testing.assert_allclose(state.pose, expected.pose, rtol=0, atol=1e-12)
    for n in range(1, len(motion)):
        for found, exact_value in ((state.reduced[n - 1], expected.reduced[n - 1]),
                                   (state.classical(n), expected.classical[n - 1])):
            np.testing.assert_allclose(found, exact_value, rtol=0,
                                       atol=1e-11 * np.abs(exact_value).max())


@pytest.mark.parametrize('seed', range(15))
def test_mixed_chains_are_exact_to_order_four(seed):
    chain = robots.random_chain(seed, joints=1 + seed % 8)
    assert_exact(chain, robots.random_motion(seed, chain.dof))


@pytest.mark.parametrize('name', ['puma560', 'panda', 'rpr'])
def test_robots_are_exact_to_order_four(name):
    chain = robots.robot(name)
    assert_exact(chain, robots.random_motion(3, chain.dof))


def test_mimic_joints_are_exact_to_order_four():
    assert GRIPPER.joint_names == ('turn', 'left', 'motor')
    assert_exact(GRIPPER, robots.random_motion(4, 3))


@pytest.mark.parametrize('chain', [GRIPPER, robots.random_chain(5)], ids=['mimic', 'mixed'])
@pytest.mark.parametrize('pole', ['tip', 'base', np.array([0.2, -0.4, 1.0])],
                         ids=['tip', 'base', 'point'])
@pytest.mark.parametrize('axes', ['base', 'tip'])
def test_jacobian_times_rates_is_the_twist(chain, pole, axes):
    q, qd = robots.random_motion(5, chain.dof, order=1, shape=(3,))
    twist = chain.state(q, qd).about(pole).expressed_in(axes).velocity
    np.testing.assert_allclose(se3.matvec(chain.jacobian(q, pole, axes), qd), twist,
                               rtol=1e-12, atol=1e-13)


def test_screws_move_with_their_joints():
    """The present screw is the home screw carried along by the joints before it."""
    chain = robots.random_chain(6)
    q = robots.random_motion(6, chain.dof, order=0)[0]
    home = chain.screws(0 * q, pole='base')
    T = np.eye(4)
    for i, screw in enumerate(chain.screws(q, pole='base')):
        np.testing.assert_allclose(screw, se3.adjoint(T) @ home[i], rtol=0, atol=1e-12)
        T = T @ se3.exp(home[i] * q[i])
    np.testing.assert_allclose(chain.pose(q), T @ chain.T_base_tool, rtol=0, atol=1e-12)


@pytest.mark.parametrize('shape', [(), (0,), (4,), (2, 3)])
@pytest.mark.parametrize('chain', [GRIPPER, robots.robot('rpr'), SerialChain([])],
                         ids=['mimic', 'rpr', 'empty'])
def test_shapes(chain, shape):
    motion = robots.random_motion(7, chain.dof, shape=shape)
    state = chain.state(*motion)
    assert state.pose.shape == (*shape, 4, 4)
    assert [x.shape for x in state.reduced] == [(*shape, 6)] * 4
    for pole in ('tip', 'base'):
        assert chain.jacobian(motion[0], pole).shape == (*shape, 6, chain.dof)
        assert chain.screws(motion[0], pole).shape == (*shape, len(chain.joints), 6)


def test_batches_are_single_samples_side_by_side():
    motion = robots.random_motion(8, GRIPPER.dof, shape=(2, 3))
    batch, single = GRIPPER.state(*motion), GRIPPER.state(*motion[:, 1, 2])
    np.testing.assert_allclose(batch.pose[1, 2], single.pose, rtol=0, atol=1e-15)
    np.testing.assert_allclose(batch.reduced_snap[1, 2], single.reduced_snap, rtol=1e-13)


@pytest.mark.parametrize('call, message', [
    (lambda c, q: c.pose(q[0, :2]), r'q of SerialChain\(rpr.*\(\.\.\., 3\), got \(2,\)'),
    (lambda c, q: c.state(*[q] * 6), 'up to order 4 are supported, got 5'),
    (lambda c, q: c.jacobian(q, axes='tool'), "unknown axes 'tool'; known: 'base', 'tip'"),
    (lambda c, q: c.screws(q, pole='tool'), "unknown pole 'tool'; known: 'base', 'tip'"),
    (lambda c, q: c.state(q, q[:2]), r'derivative 1 of q of .*expected .*\(4, 3\), as q, got'),
    (lambda c, q: c.state(q, q, q[:3]), r'derivative 2 of q of .*got \(3, 3\)'),
    (lambda c, q: c.link_states(q, q[:2]), 'derivative 1 of q of'),
    (lambda c, q: c.state(q[0], q[0, :2]), r'derivative 1 of q of .*, 3\), got \(2,\)'),
    (lambda c, q: c.pose(['0'] * 3), 'q of .*must be numbers'),
    (lambda c, q: c.pose('abc'), 'q of .*must be numbers'),
    (lambda c, q: c.state(q, None), 'derivative 1 of q of .*expected'),
    (lambda c, q: c.inverse_velocity(q, ['a'] * 6), 'wanted six-vector must be numbers'),
    (lambda c, q: c.inverse_acceleration(q, q[:, :2], np.zeros(6)), 'derivative 1 of q of'),
    (lambda c, q: c.joint_efforts(q, np.zeros(5)), r'wrench: expected shape \(\.\.\., 6\)'),
    (lambda c, q: c.manipulability(q, length=0.0), 'length must be positive and finite'),
    (lambda c, q: c.screws(q, pole=[1, 2]), r'pole: expected shape \(\.\.\., 3\)'),
    (lambda c, q: c.pose([True] * 3), 'q of .*must be numbers'),
    (lambda c, q: c.pose([1j] * 3), 'q of .*must be numbers'),
    (lambda c, q: c.state([None] * 3), 'q of .*must be numbers'),
    (lambda c, q: c.jacobian([{}] * 3), 'q of .*must be numbers'),
    (lambda c, q: c.compile()(q[0], q[0], ['a'] * 3), 'qdd must be numbers'),
    (lambda c, q: SerialChain([1]), 'made of Joint objects, got 1'),
    (lambda c, q: Joint('a', 'helical', (0, 0, 1), pitch='x'), "joint 'a': pitch must be numbers"),
    (lambda c, q: Joint('a', 'revolute', (0, 0, 1), velocity_limit='x'),
     "joint 'a': velocity_limit must be numbers"),
    (lambda c, q: Joint('a', 'revolute', None), r"joint 'a': axis: expected shape \(3,\)"),
])
def test_arguments_are_refused_by_name(call, message):
    with pytest.raises((ShapeError, InvalidValueError, UnknownNameError), match=message):
        call(robots.robot('rpr'), np.zeros((4, 3)))


def test_link_states_are_those_of_the_chains_that_end_there():
    chain = robots.random_chain(10)
    motion = robots.random_motion(10, chain.dof, shape=(2,))
    found = chain.link_states(*motion, pole='base')
    assert found.shape == (chain.dof, 4, 2, 6)
    for k in range(chain.dof):
        shorter = SerialChain(chain.joints[:k + 1])
        state = shorter.state(*motion[..., :k + 1]).about('base')
        np.testing.assert_allclose(found[k], state.reduced, rtol=0,
                                   atol=1e-11 * np.abs(found[k]).max())
    whole = chain.state(*motion)
    np.testing.assert_allclose(chain.link_states(*motion)[-1], whole.reduced, rtol=1e-11,
                               atol=1e-11)
    assert SerialChain([]).link_states([], []).shape == (0, 1, 6)


@pytest.mark.parametrize('T, message', [
    (np.eye(3), r'T_base_tool: expected shape \(4, 4\), got \(3, 3\)'),
    (2 * np.eye(4), 'T_base_tool is no rigid displacement'),
    (np.diag([1, 1, -1, 1]), 'T_base_tool is no rigid displacement'),
    (np.full((4, 4), np.nan), 'T_base_tool is no rigid displacement'),
    ([['a'] * 4] * 4, 'T_base_tool must be numbers'),
])
def test_what_is_no_pose_is_refused(T, message):
    with pytest.raises((ShapeError, InvalidValueError), match=message):
        SerialChain([], T)


def test_joints_must_have_names_of_their_own_and_follow_measured_ones():
    a = Joint('a', 'revolute', axis=(0, 0, 1))
    b = Joint('b', 'revolute', axis=(0, 0, 1), mimic=Mimic('a'))
    with pytest.raises(InvalidValueError, match="joint 'a' occurs more than once"):
        SerialChain([a, a])
    with pytest.raises(InvalidValueError, match="joint 'c' follows 'b', which follows another"):
        SerialChain([a, b, Joint('c', 'revolute', axis=(0, 0, 1), mimic=Mimic('b'))])


@pytest.mark.parametrize('joints, kinds', [
    ([Joint('a', 'continuous', (0, 0, 1)), Joint('b', 'revolute', (0, 0, 1))],
     ('continuous', 'revolute')),
    ([Joint('a', 'revolute', (0, 0, 1)), Joint('b', 'prismatic', (0, 0, 1), mimic=Mimic('a'))],
     ('revolute',)),
    ([Joint('b', 'prismatic', (0, 0, 1), mimic=Mimic('a')),
      Joint('a', 'helical', (0, 0, 1), pitch=0.1)],
     ('helical',)),
    ([Joint('b', 'prismatic', (0, 0, 1), mimic=Mimic('a', kind='continuous'))], ('continuous',)),
    ([Joint('b', 'continuous', (0, 0, 1), mimic=Mimic('elsewhere'))], ('continuous',))])
def test_a_measured_joint_is_of_its_own_kind(joints, kinds):
    """A follower's kind counts only where nobody says that of the joint it follows."""
    chain = SerialChain(joints)
    assert chain.joint_kinds == kinds
    assert chain.prismatic.tolist() == [kind == 'prismatic' for kind in kinds]


def test_velocity_limits_are_those_of_the_measured_joints():
    chain = SerialChain([
        Joint('a', 'revolute', (0, 0, 1), velocity_limit=2.0), Joint('b', 'revolute', (0, 1, 0)),
        Joint('c', 'revolute', (0, 0, 1), mimic=Mimic('a', 3), velocity_limit=1.0)])
    assert chain.velocity_limits.tolist() == [2.0, np.inf]
    with pytest.raises(InvalidValueError, match="joint 'a': velocity_limit must be positive"):
        Joint('a', 'revolute', (0, 0, 1), velocity_limit=0.0)


@pytest.mark.parametrize('seed', range(6))
def test_the_skeleton_goes_through_the_joint_axes_to_the_tip(seed):
    """Each point is on its joint's axis, nearest to the one before; batches broadcast."""
    chain = robots.random_chain(seed, joints=5)
    batch = np.random.default_rng(seed).normal(size=(3, chain.dof))
    line, = chain.skeleton(batch)
    assert line.shape == (3, len(chain.joints) + 2, 3)
    np.testing.assert_array_equal(line[:, 0], 0)
    np.testing.assert_allclose(line[:, -1], chain.pose(batch)[:, :3, 3], rtol=1e-12)
    for i, joint in enumerate(chain.joints):
        screws = chain.screws(batch, pole='base')[:, i]
        step = line[:, i + 1] - line[:, i]
        if joint.kind == 'prismatic':
            np.testing.assert_array_equal(step, 0)
        else:
            moment = screws[:, 3:] - joint.pitch * screws[:, :3]
            np.testing.assert_allclose(np.cross(line[:, i + 1], screws[:, :3]), moment,
                                       atol=1e-12)
            np.testing.assert_allclose((step * screws[:, :3]).sum(axis=1), 0, atol=1e-12)
