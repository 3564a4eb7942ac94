# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Laws of the Lie algebra, of its forms, and of the adjoint action."""
import numpy as np
import pytest

from screw_kinematics.screws import se3

SHAPES = [(), (5,), (2, 3)]


def sixvectors(count, shape=(), seed=1):
    return np.random.default_rng(seed).normal(size=(count, *shape, 6))


@pytest.mark.parametrize('shape', SHAPES)
def test_lie_product_is_a_lie_bracket(shape):
    x, y, z = sixvectors(3, shape)
    bracket = se3.lie_product
    np.testing.assert_allclose(bracket(x, y), -bracket(y, x), rtol=1e-12)
    np.testing.assert_allclose(bracket(x, x), 0, atol=1e-15)
    np.testing.assert_allclose(bracket(2 * x + y, z), 2 * bracket(x, z) + bracket(y, z),
                               rtol=1e-12, atol=1e-14)
    jacobi = (bracket(x, bracket(y, z)) + bracket(y, bracket(z, x))
              + bracket(z, bracket(x, y)))
    np.testing.assert_allclose(jacobi, 0, atol=1e-12)


@pytest.mark.parametrize('shape', SHAPES)
def test_ad_is_the_lie_product_and_represents_it(shape):
    x, y = sixvectors(2, shape)
    np.testing.assert_allclose(se3.matvec(se3.ad(x), y), se3.lie_product(x, y), rtol=1e-12)
    commutator = se3.ad(x) @ se3.ad(y) - se3.ad(y) @ se3.ad(x)
    np.testing.assert_allclose(se3.ad(se3.lie_product(x, y)), commutator, atol=1e-12)


def test_trace_form_is_minus_four_times_the_killing_form_of_the_paper():
    x, y = sixvectors(2, (10,))
    trace = np.trace(se3.ad(x) @ se3.ad(y), axis1=-2, axis2=-1)
    np.testing.assert_allclose(trace, -4 * se3.killing_form(x, y), rtol=1e-12)


@pytest.mark.parametrize('form', [se3.klein_form, se3.killing_form])
def test_forms_are_symmetric_invariant_and_associative(form):
    x, y, z = sixvectors(3, (10,))
    T = se3.exp(sixvectors(1, seed=7)[0])
    carry = se3.adjoint(T)
    np.testing.assert_allclose(form(x, y), form(y, x), rtol=1e-12)
    np.testing.assert_allclose(form(se3.matvec(carry, x), se3.matvec(carry, y)), form(x, y),
                               rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(form(se3.lie_product(x, y), z), form(x, se3.lie_product(y, z)),
                               rtol=1e-11, atol=1e-13)


@pytest.mark.parametrize('shape', SHAPES)
def test_adjoint_is_a_representation_and_keeps_the_lie_product(shape):
    S, T = se3.exp(sixvectors(2, shape, seed=3))
    x, y = sixvectors(2, shape)
    np.testing.assert_allclose(se3.adjoint(S @ T), se3.adjoint(S) @ se3.adjoint(T),
                               atol=1e-12)
    np.testing.assert_allclose(se3.adjoint(se3.inverse(T)), np.linalg.inv(se3.adjoint(T)),
                               atol=1e-12)
    carry = se3.adjoint(T)
    np.testing.assert_allclose(
        se3.lie_product(se3.matvec(carry, x), se3.matvec(carry, y)),
        se3.matvec(carry, se3.lie_product(x, y)), atol=1e-12)


def test_adjoint_is_conjugation():
    T, x = se3.exp(sixvectors(1, seed=3)[0]), sixvectors(1)[0]
    np.testing.assert_allclose(se3.exp(se3.adjoint(T) @ x),
                               T @ se3.exp(x) @ np.linalg.inv(T), atol=1e-12)


def test_adjoint_of_the_exponential_is_the_exponential_of_ad():
    x = sixvectors(1)[0] * 0.3
    term, total = np.eye(6), np.eye(6)
    for k in range(1, 25):
        term = term @ se3.ad(x) / k
        total = total + term
    np.testing.assert_allclose(se3.adjoint(se3.exp(x)), total, atol=1e-14)


@pytest.mark.parametrize('shape', SHAPES)
def test_adjoint_is_rotation_then_pole_shift(shape):
    T, x = se3.exp(sixvectors(1, shape, seed=3)[0]), sixvectors(1, shape)[0]
    R, p = T[..., :3, :3], T[..., :3, 3]
    np.testing.assert_allclose(se3.matvec(se3.adjoint(T), x),
                               se3.shift_pole(se3.rotate(R, x), -p), rtol=1e-12, atol=1e-14)


def test_power_of_a_wrench_does_not_depend_on_the_frame():
    T, (twist, screw) = se3.exp(sixvectors(1, seed=3)[0]), sixvectors(2)
    covector = np.roll(screw, 3)        # (moment; force) of the wrench (force; moment)
    moved = se3.adjoint(T) @ twist
    np.testing.assert_allclose(se3.klein_form(se3.adjoint(T) @ screw, moved),
                               covector @ twist, rtol=1e-12)
    np.testing.assert_allclose(se3.coadjoint(T) @ covector @ moved, covector @ twist,
                               rtol=1e-12)
    np.testing.assert_allclose(se3.coadjoint(T), np.linalg.inv(se3.adjoint(T)).T, atol=1e-12)


def test_pole_shifts_add_up():
    x = sixvectors(1)[0]
    a, b = np.random.default_rng(5).normal(size=(2, 3))
    np.testing.assert_allclose(se3.shift_pole(se3.shift_pole(x, a), b),
                               se3.shift_pole(x, a + b), rtol=1e-12, atol=1e-14)
