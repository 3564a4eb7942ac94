# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Orthogonal columns against NumPy's singular values."""
import numpy as np
import pytest

from screw_kinematics.parallel.gram_schmidt import OrthogonalColumns


@pytest.mark.parametrize('shape', [(6, 5), (6, 2), (6, 6), (12, 6), (6, 0)])
def test_least_squares_complement_and_distance(shape):
    rng = np.random.default_rng(shape[1])
    matrix, right = rng.normal(size=shape), rng.normal(size=shape[0])
    columns = OrthogonalColumns(matrix.T)
    expected = np.linalg.lstsq(matrix, right, rcond=None)[0]
    np.testing.assert_allclose(columns.solve(right), expected, atol=1e-12)
    np.testing.assert_allclose(columns.solve_roughly(right), expected, atol=1e-12)
    sizes = np.linalg.svd(matrix, compute_uv=False)
    np.testing.assert_allclose(columns.inverse_square(), np.sum(sizes**-2.0), rtol=1e-12)
    assert columns.inverse_size_square() <= columns.inverse_square() * (1 + 1e-12)
    seeds = rng.normal(size=(shape[0] - shape[1], shape[0]))
    found = np.array(columns.complement(seeds)).reshape(seeds.shape)
    np.testing.assert_allclose(found @ found.T, np.eye(len(found)), atol=1e-12)
    np.testing.assert_allclose(found @ matrix, 0, atol=1e-12)


def test_a_complement_that_is_one_stays():
    q, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(6, 6)))
    found = OrthogonalColumns(q.T[:4] * 3).complement(q.T[4:])
    np.testing.assert_allclose(found, q.T[4:], atol=1e-14)


def test_right_sides_of_nearly_dependent_columns():
    """The solution of a right side that is a combination has its coefficients."""
    rng = np.random.default_rng(3)
    matrix = rng.normal(size=(6, 5))
    matrix[:, 4] = matrix[:, 0] + 1e-5 * rng.normal(size=6)
    solution = rng.normal(size=5)
    found = OrthogonalColumns(matrix.T).solve(matrix @ solution)
    np.testing.assert_allclose(found, solution, atol=1e-9)
