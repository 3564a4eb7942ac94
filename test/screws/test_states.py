# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""States of every order against exact differentiation, and their composition."""
import numpy as np
import pytest

from screw_kinematics.errors import InvalidValueError, ShapeError
from screw_kinematics.screws import se3, states
from screw_kinematics.screws.body_components import states_from_body_derivatives
from screw_kinematics.screws.se3 import lie_product
from support import exact, robots

KINDS = [('revolute',) * 6, ('prismatic', 'revolute') * 3, ('helical',) * 5,
         ('revolute', 'prismatic', 'helical', 'revolute', 'helical', 'prismatic', 'revolute'),
         ('prismatic',) * 3, ('helical',)]
RELATIVE = 1e-11


def assert_close(actual, expected, relative=RELATIVE):
    """Compare with a tolerance relative to the whole six-vector."""
    np.testing.assert_allclose(actual, expected, rtol=0,
                               atol=relative * max(np.abs(expected).max(), 1e-300))


def screws_and_motion(kinds, seed=0, order=4, shape=()):
    chain = robots.random_chain(seed, kinds)
    q, *derivatives = robots.random_motion(seed, chain.dof, order, shape)
    screws = list(np.moveaxis(chain.screws(q, pole='tip'), -2, 0))
    return chain, q, derivatives, screws


@pytest.mark.parametrize('kinds', KINDS, ids=lambda kinds: '-'.join(k[0] for k in kinds))
def test_chain_states_are_the_exact_derivatives(kinds):
    chain, q, derivatives, screws = screws_and_motion(kinds)
    found = states.chain_states(screws, derivatives)
    motion = exact.tip_motion(chain, q, *derivatives)
    for n in range(4):
        assert_close(found[n], motion.reduced[n])
    for n, classical in enumerate(states.classical_from_reduced(found)):
        assert_close(classical, motion.classical[n])
    for n, body in enumerate(states.body_derivatives(found)):
        assert_close(body, se3.rotate(motion.pose[:3, :3], motion.body[n]))


def test_the_recursion_holds_beyond_order_four():
    chain, q, derivatives, screws = screws_and_motion(KINDS[3], order=7)
    motion = exact.tip_motion(chain, q, *derivatives)
    found = states.chain_states(screws, derivatives)
    classical = states.classical_from_reduced(found)
    for n in range(7):
        assert_close(found[n], motion.reduced[n])
        assert_close(classical[n], motion.classical[n])


def test_acceleration_has_the_coriolis_lie_term_once():
    _, _, (qd, qdd, *_), screws = screws_and_motion(KINDS[3])
    linear = sum(a * s for a, s in zip(qdd, screws))
    coriolis = sum(qd[i] * qd[j] * lie_product(screws[i], screws[j])
                   for j in range(len(screws)) for i in range(j))
    assert_close(states.chain_states(screws, [qd, qdd])[1], linear + coriolis, 1e-13)


def test_no_joints_no_motion():
    found = states.chain_states([], [np.zeros((5, 0)), np.zeros((5, 0))])
    assert [x.shape for x in found] == [(5, 6), (5, 6)] and not np.any(found)


@pytest.mark.parametrize('shape', [(), (4,)])
def test_classical_and_reduced_are_inverse_to_each_other(shape):
    reduced = np.random.default_rng(1).normal(size=(5, *shape, 6))
    back = states.reduced_from_classical(states.classical_from_reduced(reduced))
    np.testing.assert_allclose(back, reduced, rtol=1e-12, atol=1e-12)


def test_classical_formulas_as_the_literature_writes_them():
    V, A, J, S = np.random.default_rng(2).normal(size=(4, 6))
    w, alpha, rho = V[:3], A[:3], J[:3]
    v = V[3:]
    a = A[3:] + np.cross(w, v)
    j = J[3:] + 2 * np.cross(alpha, v) + np.cross(w, a)
    s = S[3:] + 3 * np.cross(rho, v) + 3 * np.cross(alpha, a) + np.cross(w, j)
    for found, linear in zip(states.classical_from_reduced([V, A, J, S]), (v, a, j, s)):
        np.testing.assert_allclose(found[3:], linear, rtol=1e-12)


def test_every_order_is_a_helicoidal_field():
    """Classical motion of another body point, by rigid-body formulas and by shifting."""
    reduced = np.random.default_rng(3).normal(size=(3, 6))
    r = np.array([0.3, -2.0, 1.1])
    (V, A, J), shifted = states.classical_from_reduced(reduced), \
        states.classical_from_reduced([se3.shift_pole(x, r) for x in reduced])
    w, alpha, rho, cross = V[:3], A[:3], J[:3], np.cross
    np.testing.assert_allclose(shifted[0][3:], V[3:] + cross(w, r), rtol=1e-12)
    np.testing.assert_allclose(
        shifted[1][3:], A[3:] + cross(alpha, r) + cross(w, cross(w, r)), rtol=1e-12)
    np.testing.assert_allclose(
        shifted[2][3:],
        J[3:] + cross(rho, r) + 2 * cross(alpha, cross(w, r)) + cross(w, cross(alpha, r))
        + cross(w, cross(w, cross(w, r))), rtol=1e-12)


def test_composition_as_written_out_to_order_four():
    V1, A1, J1, S1, V2, A2, J2, S2 = np.random.default_rng(4).normal(size=(8, 6))
    b = lie_product
    D1, D2 = b(V1, V2), b(A1, V2) + b(V1, b(V1, V2))
    D3 = (b(J1, V2) + 2 * b(A1, b(V1, V2)) + b(V1, b(A1, V2)) + b(V1, b(V1, b(V1, V2))))
    expected = [
        V1 + V2,
        A1 + A2 + D1,
        J1 + J2 + 2 * b(V1, A2) + D2,
        S1 + S2 + 3 * b(V1, J2) + 3 * (b(A1, A2) + b(V1, b(V1, A2))) + D3]
    found = states.compose([V1, A1, J1, S1], [V2, A2, J2, S2])
    np.testing.assert_allclose(found, expected, rtol=1e-12)


@pytest.mark.parametrize('split', range(8))
def test_a_chain_cut_in_two_composes_to_the_whole(split):
    _, _, derivatives, screws = screws_and_motion(KINDS[3])
    outer = states.chain_states(screws[:split], [d[:split] for d in derivatives])
    inner = states.chain_states(screws[split:], [d[split:] for d in derivatives])
    whole = states.chain_states(screws, derivatives)
    for found, expected in zip(states.compose(outer, inner), whole):
        assert_close(found, expected, 1e-12)


@pytest.mark.parametrize('shape', [(), (4,)])
def test_relative_undoes_compose(shape):
    outer, inner = np.random.default_rng(5).normal(size=(2, 5, *shape, 6))
    seen = states.relative(states.compose(outer, inner), outer)
    np.testing.assert_allclose(seen, inner, rtol=1e-11, atol=1e-11)


def test_composition_is_associative():
    x, y, z = np.random.default_rng(6).normal(size=(3, 4, 6))
    left = states.compose(states.compose(x, y), z)
    right = states.compose(x, states.compose(y, z))
    np.testing.assert_allclose(left, right, rtol=1e-11, atol=1e-12)


def test_body_fixed_components_do_not_differentiate_to_the_jerk():
    """The trap: right to the acceleration, wrong from the jerk on."""
    V, A, J, S = np.random.default_rng(7).normal(size=(4, 6))
    b = lie_product
    twist, first, second, third = states.body_derivatives([V, A, J, S])
    np.testing.assert_array_equal(twist, V)
    np.testing.assert_allclose(first, A, rtol=1e-12)
    np.testing.assert_allclose(second, J - b(V, A), rtol=1e-12)
    np.testing.assert_allclose(third, S - 2 * b(V, J) + b(V, b(V, A)), rtol=1e-12)
    assert np.abs(second - J).max() > 0.1


def test_states_come_back_from_the_components_of_a_body():
    """To any order, and as the fixed axes of the exact motion have them."""
    X = np.random.default_rng(8).normal(size=(6, 3, 6))
    back = states_from_body_derivatives(states.body_derivatives(X))
    np.testing.assert_allclose(back, X, rtol=1e-11, atol=1e-11)
    chain, q, derivatives, _ = screws_and_motion(KINDS[3])
    motion = exact.tip_motion(chain, q, *derivatives)
    for found, known in zip(states_from_body_derivatives(motion.body), motion.reduced):
        assert_close(se3.rotate(motion.pose[:3, :3], found), known)


def test_chain_states_takes_arrays_lists_and_symbols():
    """Screws as chain.screws gives them, rates as people write them."""
    chain, q, derivatives, _ = screws_and_motion(KINDS[3])
    screws = chain.screws(q)
    expected = chain.state(q, *derivatives).reduced
    for rates in (derivatives, [d.tolist() for d in derivatives], [tuple(d) for d in derivatives]):
        for found, known in zip(states.chain_states(screws, rates), expected):
            assert_close(found, known, 1e-13)
    sympy = pytest.importorskip('sympy')
    symbols = sympy.symbols('u1:8')
    (twist,) = states.chain_states(screws, [symbols])
    values = dict(zip(symbols, derivatives[0]))
    assert_close(np.array([float(x.subs(values)) for x in twist]), expected[0], 1e-13)


def test_chain_states_takes_batches_of_screws():
    chain, q, derivatives, _ = screws_and_motion(KINDS[3], shape=(2, 3))
    found = states.chain_states(chain.screws(q), derivatives)
    for state, expected in zip(found, chain.state(q, *derivatives).reduced):
        assert_close(state, expected, 1e-13)


def test_link_states_are_those_of_the_chains_up_to_each_link():
    _, _, derivatives, screws = screws_and_motion(KINDS[3])
    bodies = states.link_states(screws, derivatives)
    for i, body in enumerate(bodies, start=1):
        shorter = states.chain_states(screws[:i], [d[:i] for d in derivatives])
        np.testing.assert_array_equal(body, shorter)
    assert len(bodies) == len(screws)


@pytest.mark.parametrize('screws, rates, message', [
    (np.zeros((2, 6)), [[1.0]], r'derivative 1: expected shape \(\.\.\., 2\), got \(1,\)'),
    (np.zeros((2, 7)), [[1.0, 2.0]], r'screws: expected shape \(\.\.\., N, 6\)'),
    ([np.zeros(5)], [[1.0]], r'screw 1: expected shape \(\.\.\., 6\), got \(5,\)'),
])
def test_screws_and_rates_that_do_not_fit_are_refused(screws, rates, message):
    with pytest.raises(ShapeError, match=message):
        states.chain_states(screws, rates)


def test_body_fixed_derivatives_need_the_states_of_the_body():
    with pytest.raises(InvalidValueError, match='order 3 needs 2 states of the body, got 1'):
        states.body_fixed_derivatives([np.zeros(6)], np.zeros(6), 3)
