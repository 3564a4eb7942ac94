# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The covariance of a tip is what independent errors of the joints amount to."""
import math

import numpy as np
from screw_kinematics.chains.covariance import through_jacobian


def test_is_the_covariance_of_samples():
    rng = np.random.default_rng(3)
    jacobian, deviations = rng.normal(size=(6, 4)), rng.uniform(0.1, 2.0, 4)
    samples = rng.normal(size=(200_000, 4)) * deviations @ jacobian.T
    expected = np.reshape(through_jacobian(jacobian.ravel(), deviations**2), (6, 6))
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.abs(np.cov(samples.T) - expected).max() < 0.02 * scale.max()
    assert np.allclose(expected, expected.T, rtol=1e-12)


def test_one_unknown_joint_makes_all_unknown():
    jacobian = np.ones((6, 2)).ravel()
    assert through_jacobian(jacobian, [1.0, math.nan]) == [0.0] * 36
    assert through_jacobian(jacobian, [1.0, math.inf]) == [0.0] * 36
