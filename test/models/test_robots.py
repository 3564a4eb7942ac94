# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The shipped robots have the kinematics of their sources."""
import numpy as np
import pytest

from screw_kinematics import models

ROBOTS = 'package://screw_kinematics/config/robots/'


@pytest.mark.parametrize('seed', range(3))
def test_rpr_follows_the_corrected_formulas(seed):
    """Velocity and reduced acceleration of the paper's planar arm about its point Q."""
    a = 0.25
    rpr = models.load(ROBOTS + 'rpr.yaml')
    rng = np.random.default_rng(seed)
    (q1, q2, q3), (w1, v2, w3), (e1, b2, e3) = q, qd, qdd = rng.normal(size=(3, 3))
    c1, s1, c13, s13 = np.cos(q1), np.sin(q1), np.cos(q1 + q3), np.sin(q1 + q3)
    columns = np.array([[1, 0, 1],
                        [-(q2 * s1 + a * s13), c1, -a * s13],
                        [q2 * c1 + a * c13, s1, a * c13]])
    coriolis = np.array([
        0,
        -s1 * w1 * v2 + q2 * c1 * w1 * w3 + s1 * v2 * w3,
        c1 * w1 * v2 + q2 * s1 * w1 * w3 - c1 * v2 * w3])
    state = rpr.state(q, qd, qdd)
    planar = [2, 3, 4]
    np.testing.assert_allclose(
        state.pose[:2, 3], [q2 * c1 + a * c13, q2 * s1 + a * s13], rtol=1e-12)
    np.testing.assert_allclose(state.velocity[planar], columns @ qd, rtol=1e-12)
    np.testing.assert_allclose(
        state.reduced_acceleration[planar], columns @ qdd + coriolis, rtol=1e-12)
    assert not np.any(state.reduced_acceleration[[0, 1, 5]])
