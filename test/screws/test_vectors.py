# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from screw_kinematics.screws import vectors


@pytest.mark.parametrize('shape', [(), (4,), (2, 3)])
def test_cross_and_skew_agree_with_numpy(shape):
    a, b = np.random.default_rng(1).normal(size=(2, *shape, 3))
    np.testing.assert_allclose(vectors.cross(a, b), np.cross(a, b), rtol=1e-15)
    np.testing.assert_allclose(vectors.matvec(vectors.skew(a), b), np.cross(a, b), rtol=1e-14)
    np.testing.assert_allclose(vectors.dot(a, b), np.einsum('...i,...i', a, b), rtol=1e-14)


def test_cross_broadcasts():
    a, b = np.arange(3.0), np.random.default_rng(2).normal(size=(5, 3))
    np.testing.assert_allclose(vectors.cross(a, b), np.cross(a, b), rtol=1e-15)


def test_integers_stay_integers():
    for value in (vectors.cross(np.array([1, 2, 3]), np.array([4, 5, 6])),
                  vectors.skew(np.array([1, 2, 3]))):
        assert value.dtype.kind == 'i'
