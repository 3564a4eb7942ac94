# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The inverse problem of every order, joint efforts, and manipulability."""
import numpy as np
import pytest

from screw_kinematics import InverseSolver, Joint, SerialChain
from screw_kinematics.chains.inverse import manipulability
from screw_kinematics.errors import (
    InvalidValueError, ShapeError, SingularityError, UnknownNameError)
from screw_kinematics.screws import se3
from support import exact, robots

EXACT = InverseSolver(exact=True)
SQUARE = robots.random_chain(21)
REDUNDANT = robots.random_chain(22, joints=9)
PUMA, RPR = robots.robot('puma560'), robots.robot('rpr')
POLES = ['tip', 'base', np.array([0.1, 0.5, -0.3])]


def in_millimetres(chain):
    """Return the same chain described in mm; prismatic rates are then in mm/s."""
    T = chain.T_base_tool.copy()
    T[:3, 3] *= 1000
    return SerialChain([Joint(j.name, j.kind, j.axis, 1000 * j.point, 1000 * j.pitch)
                        for j in chain.joints], T)


@pytest.mark.parametrize('chain', [SQUARE, REDUNDANT], ids=['square', 'redundant'])
@pytest.mark.parametrize('pole', POLES, ids=['tip', 'base', 'point'])
@pytest.mark.parametrize('axes', ['base', 'tip'])
def test_inverse_velocity_gives_the_twist(chain, pole, axes):
    q, wished = robots.random_motion(1, chain.dof, order=1, shape=(4,))
    twist = np.random.default_rng(2).normal(size=(4, 6))
    solution = chain.inverse_velocity(q, twist, pole, axes, secondary=wished, solver=EXACT)
    found = chain.state(q, solution.rates).about(pole).expressed_in(axes).velocity
    np.testing.assert_allclose(found, twist, rtol=0, atol=1e-11)
    np.testing.assert_allclose(solution.residual, 0, atol=1e-11)
    assert np.all(solution.damping == 0)


@pytest.mark.parametrize('chain', [SQUARE, REDUNDANT], ids=['square', 'redundant'])
@pytest.mark.parametrize('kind', ['classical', 'reduced'])
@pytest.mark.parametrize('pole', POLES, ids=['tip', 'base', 'point'])
@pytest.mark.parametrize('axes', ['base', 'tip'])
def test_inverse_acceleration_gives_the_acceleration(chain, kind, pole, axes):
    q, qd = robots.random_motion(3, chain.dof, order=1)
    wanted = np.random.default_rng(4).normal(size=6)
    solution = chain.inverse_acceleration(q, qd, wanted, kind, pole, axes, solver=EXACT)
    state = chain.state(q, qd, solution.rates).about(pole).expressed_in(axes)
    found = state.classical(2) if kind == 'classical' else state.reduced_acceleration
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-10)


@pytest.mark.parametrize('kind', ['classical', 'reduced'])
@pytest.mark.parametrize('pole', POLES, ids=['tip', 'base', 'point'])
@pytest.mark.parametrize('axes', ['base', 'tip'])
def test_inverse_jerk_and_snap_give_them_back(kind, pole, axes):
    """Against exact differentiation at the tip, against the forward problem elsewhere."""
    motion = robots.random_motion(12, 6)
    state = SQUARE.state(*motion).about(pole).expressed_in(axes)
    wanted = [state.classical(n) if kind == 'classical' else state.reduced[n - 1]
              for n in (3, 4)]
    if isinstance(pole, str) and (pole, axes, kind) == ('tip', 'base', 'classical'):
        wanted = exact.tip_motion(SQUARE, *motion).classical[2:4]
    jerk = SQUARE.inverse_jerk(*motion[:3], wanted[0], kind, pole, axes, solver=EXACT)
    snap = SQUARE.inverse_snap(*motion[:4], wanted[1], kind, pole, axes, solver=EXACT)
    for found, expected in ((jerk, motion[3]), (snap, motion[4])):
        np.testing.assert_allclose(found.rates, expected, rtol=0, atol=1e-8)


@pytest.mark.parametrize('chain', [SQUARE, REDUNDANT], ids=['square', 'redundant'])
@pytest.mark.parametrize('pole', POLES, ids=['tip', 'base', 'point'])
def test_the_coriolis_lie_term_is_the_sum_of_lie_products(chain, pole):
    """The double sum of Theorem 4, written out: each pair of joints once."""
    q, qd = robots.random_motion(13, chain.dof, order=1)
    screws = chain.screws(q, pole)
    expected = sum(qd[i] * qd[j] * se3.lie_product(screws[i], screws[j])
                   for j in range(chain.dof) for i in range(j))
    np.testing.assert_allclose(chain.coriolis_lie(q, qd, pole), expected, rtol=0, atol=1e-11)


def test_joint_efforts_are_klein_forms_of_wrench_and_screws():
    q, qd = robots.random_motion(14, 6, order=1, shape=(3,))
    wrench = np.random.default_rng(15).normal(size=(3, 6))
    for pole in POLES:
        efforts = SQUARE.joint_efforts(q, wrench, pole)
        screws = SQUARE.screws(q, pole)
        np.testing.assert_allclose(
            efforts, se3.klein_form(wrench[:, None], screws), atol=1e-12)
        power = se3.klein_form(wrench, SQUARE.state(q, qd).about(pole).velocity)
        np.testing.assert_allclose(se3.dot(efforts, qd), power, rtol=1e-10)


def test_a_force_along_a_lever():
    """A force of 3 N across an arm of 2 m is a torque of 6 N m about its axis."""
    arm = SerialChain([Joint('q1', 'revolute', axis=(0, 0, 1))],
                      [[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    np.testing.assert_allclose(arm.joint_efforts([0.0], [0, 3, 0, 0, 0, 0]), [6])


def test_redundant_solution_is_the_shortest_and_null_space_does_not_move_the_tip():
    chain = REDUNDANT
    q, wished = robots.random_motion(6, chain.dof, order=1)
    twist = np.random.default_rng(7).normal(size=6)
    solution = chain.inverse_velocity(q, twist, solver=EXACT)
    jacobian, N = chain.jacobian(q), solution.null_space
    np.testing.assert_allclose(jacobian @ N, 0, atol=1e-12)
    np.testing.assert_allclose(N @ N, N, atol=1e-12)
    assert round(np.trace(N)) == chain.dof - 6
    # With L = 1 m and numbers in m the norm is the ordinary one.
    np.testing.assert_allclose(solution.rates, np.linalg.pinv(jacobian) @ twist, rtol=1e-10)
    moved = chain.inverse_velocity(q, twist, secondary=wished, solver=EXACT)
    np.testing.assert_allclose(moved.rates, solution.rates + N @ wished, rtol=1e-12)
    np.testing.assert_allclose(chain.state(q, moved.rates).velocity, twist, atol=1e-11)


@pytest.mark.parametrize('chain', [SQUARE, REDUNDANT], ids=['square', 'redundant'])
def test_the_unit_of_length_does_not_matter(chain):
    """The same arm in mm, with L in mm: the same motion, damping and manipulability."""
    q = robots.random_motion(8, chain.dof, order=0)[0]
    scale = np.array([1, 1, 1, 1000, 1000, 1000])
    unit = np.where(chain.prismatic, 1000, 1)
    twist = np.random.default_rng(9).normal(size=6)
    solver, in_mm = (InverseSolver(length=0.7 * k, threshold=1.0) for k in (1, 1000))
    metres = chain.inverse_velocity(q, twist, solver=solver)
    millimetres = in_millimetres(chain).inverse_velocity(unit * q, scale * twist, solver=in_mm)
    assert metres.damping > 0
    np.testing.assert_allclose(millimetres.rates, unit * metres.rates, rtol=1e-9)
    np.testing.assert_allclose(millimetres.damping, metres.damping, rtol=1e-9)
    np.testing.assert_allclose(millimetres.singular_values, metres.singular_values, rtol=1e-9)
    np.testing.assert_allclose(
        in_millimetres(chain).manipulability(unit * q, length=700).measure,
        chain.manipulability(q, length=0.7).measure, rtol=1e-9)


@pytest.mark.parametrize('q5', [0.0, 1e-12, 1e-6, 1e-3, 0.01])
def test_damped_rates_stay_bounded_near_a_singularity_and_say_so(q5):
    q = np.radians([10, 20, 30, 40, 0, 50]) + [0, 0, 0, 0, q5, 0]
    solver = InverseSolver(threshold=0.05)
    twist = np.random.default_rng(10).normal(size=6)
    solution = PUMA.inverse_velocity(q, twist, solver=solver)
    assert np.linalg.norm(solution.rates) <= np.linalg.norm(twist) / 0.05
    smallest = solution.singular_values[-1]
    assert solution.damping == pytest.approx(np.sqrt(0.05 ** 2 - smallest ** 2))
    np.testing.assert_allclose(solution.residual, twist - PUMA.jacobian(q) @ solution.rates,
                               atol=1e-12)
    # Only the failing direction is given up; L = 1 m, so directions need no scaling.
    failing = np.linalg.svd(PUMA.jacobian(q))[0][:, -1]
    np.testing.assert_allclose(solution.residual, failing * (failing @ solution.residual),
                               atol=1e-12)
    assert abs(failing @ solution.residual) > 0


def test_damping_is_none_where_the_wanted_motion_avoids_the_singular_direction():
    q = np.radians([10, 20, 30, 40, 0, 50])
    possible = PUMA.state(q, np.arange(1.0, 7)).velocity
    solution = PUMA.inverse_velocity(q, possible)
    assert solution.damping == 0
    np.testing.assert_allclose(solution.residual, 0, atol=1e-12)
    PUMA.inverse_velocity(q, possible, solver=EXACT)


def test_damping_sets_in_continuously():
    jacobian = np.diag([1.0, 1, 1, 1, 1, 0.1])
    wanted = np.ones(6)
    below, above = (InverseSolver(threshold=0.1 * (1 + e)).solve(jacobian, wanted).rates
                    for e in (1e-9, -1e-9))
    np.testing.assert_allclose(below, above, rtol=1e-8)


def test_exact_solution_refuses_and_names_the_reciprocal_screw():
    """A planar arm in the plane z = 0 is blocked by forces along z and couples in x, y."""
    q = np.array([0.3, 1.0, 0.2])
    with pytest.raises(SingularityError, match=(
            r'rank 3 at this posture, .*: axis \(0, 0, 1\), through the point '
            r'\(0, 0, 0\) from the pole, pitch 0 m/rad')) as caught:
        RPR.inverse_velocity(q, [0, 0, 0, 0, 0, 1], solver=EXACT)
    np.testing.assert_allclose(caught.value.screw, [0, 0, 1, 0, 0, 0], atol=1e-12)
    with pytest.raises(SingularityError, match=r'axis \(1, 0, 0\), a pure couple'):
        RPR.inverse_velocity(q, [1, 0, 0, 0, 0, 0], solver=EXACT)
    with pytest.raises(SingularityError, match=r'at this posture \(sample \(1,\)\)'):
        RPR.inverse_velocity(q, [[0, 0, 1, 0, 0, 0], [1, 0, 0, 0, 0, 0]], solver=EXACT)
    # What the arm can do is found although it has three joints only.
    qd = np.array([1.0, -2, 0.5])
    found = RPR.inverse_velocity(q, RPR.state(q, qd).velocity, solver=EXACT)
    np.testing.assert_allclose(found.rates, qd, rtol=1e-12)


def test_manipulability_is_the_determinant_and_its_ellipsoid_is_reachable():
    q = robots.random_motion(11, 6, order=0, shape=(5,))[0]
    found = SQUARE.manipulability(q)
    jacobian = SQUARE.jacobian(q)
    np.testing.assert_allclose(found.measure, np.abs(np.linalg.det(jacobian)), rtol=1e-10)
    np.testing.assert_allclose(found.condition_number, np.linalg.cond(jacobian), rtol=1e-9)
    for k in range(6):
        rates = SQUARE.inverse_velocity(q, found.ellipsoid[..., k], solver=EXACT).rates
        np.testing.assert_allclose(np.linalg.norm(rates, axis=-1), 1, rtol=1e-9)


def test_manipulability_vanishes_at_a_singularity():
    found = PUMA.manipulability(np.radians([10, 20, 30, 40, 0, 50]))
    assert found.measure < 1e-15 and found.condition_number == np.inf


def test_ellipsoid_has_units():
    """One prismatic joint, L = 2 m: half a rate, half a twist, the same axis [m/s]."""
    jacobian = np.array([[0.0, 0, 0, 0, 0, 1]]).T
    found = manipulability(jacobian, np.array([True]), length=2.0)
    np.testing.assert_allclose(found.singular_values, [1])
    np.testing.assert_allclose(np.abs(found.ellipsoid[:, 0]), [0, 0, 0, 0, 0, 2])


def test_wrong_arguments_are_refused():
    q, twist = np.zeros(3), np.zeros(6)
    for name, value in (('length', 0.0), ('threshold', -1.0), ('length', np.nan)):
        with pytest.raises(InvalidValueError, match=f'{name} must be positive and finite'):
            InverseSolver(**{name: value})
    with pytest.raises(ShapeError, match=r'wanted six-vector: expected shape \(\.\.\., 6\)'):
        RPR.inverse_velocity(q, np.zeros(5))
    with pytest.raises(InvalidValueError, match='wanted six-vector must be finite'):
        RPR.inverse_velocity(q, np.full(6, np.nan))
    with pytest.raises(ShapeError, match=r'secondary rates: expected shape \(\.\.\., 3\)'):
        RPR.inverse_velocity(q, twist, secondary=np.zeros(2))
    with pytest.raises(InvalidValueError, match='jacobian must be finite'):
        RPR.inverse_velocity(np.full(3, np.nan), twist)
    with pytest.raises(ShapeError, match=r'jacobian: expected shape \(\.\.\., 6, dof\)'):
        manipulability(np.zeros((3, 3)))
    with pytest.raises(ShapeError, match=r'prismatic: expected shape \(2,\), got \(3,\)'):
        manipulability(np.zeros((6, 2)), np.zeros(3, bool))
    with pytest.raises(UnknownNameError, match="unknown kind 'true'; known: 'classical'"):
        RPR.inverse_acceleration(q, q, twist, kind='true')


def test_null_space_of_no_rank_is_everything():
    solution = InverseSolver().solve(np.zeros((6, 2)), np.ones(6))
    np.testing.assert_array_equal(solution.rates, 0)
    np.testing.assert_array_equal(solution.null_space, np.eye(2))
    assert se3.dot(solution.residual, solution.residual) == 6
