# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from screw_kinematics import se3


@pytest.mark.parametrize('shape', [(), (5,), (2, 3)])
def test_lie_product_is_a_lie_bracket(shape):
    rng = np.random.default_rng(1)
    x, y, z = rng.normal(size=(3, *shape, 6))
    bracket = se3.lie_product
    np.testing.assert_allclose(bracket(x, y), -bracket(y, x), rtol=1e-12)
    jacobi = (bracket(x, bracket(y, z)) + bracket(y, bracket(z, x))
              + bracket(z, bracket(x, y)))
    np.testing.assert_allclose(jacobi, 0, atol=1e-12)
