# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What the clock adds is the same for who asks for matrices, variances or single deviations."""
import numpy as np
import pytest
from screw_kinematics.core.tables import TRIANGLE
from screw_kinematics.motion.bank_covariance import BankCovariance
from screw_kinematics.motion.clock_error import ClockError, EXACT

JOINTS = 3


def told(error):
    """Return a covariance of made-up numbers, its matrices without a clock, and the state."""
    rng = np.random.default_rng(1)
    factor = rng.normal(size=(JOINTS, 4, 4))
    own, state = factor @ factor.transpose(0, 2, 1), rng.normal(size=(4, JOINTS))
    rows = [number for i, j in TRIANGLE for number in own[:, i, j].tolist()]
    return BankCovariance(rows, state.ravel().tolist(), error), own, state


@pytest.mark.parametrize('error', [EXACT, ClockError(0.1), ClockError(0.0, 0.2),
                                   ClockError(0.1, 0.2)])
def test_joints_err_along_their_motion_as_the_clock_does(error):
    covariance, own, state = told(error)
    matrices = covariance()
    for joint in range(JOINTS):
        x = state[:, joint]
        instant, rate = np.append(x[1:], 0.0), np.arange(4) * x
        expected = (own[joint] + error.time**2 * np.outer(instant, instant)
                    + error.rate**2 * np.outer(rate, rate))
        np.testing.assert_allclose(matrices[joint], expected, rtol=1e-12)
    diagonals = np.diagonal(matrices, axis1=1, axis2=2).T.ravel()
    np.testing.assert_allclose(covariance.variances(), diagonals, rtol=1e-12)


def test_arrays_have_what_lists_have():
    error, (_, _, state) = ClockError(0.1, 0.2), told(EXACT)
    for order in (1, 2):
        np.testing.assert_allclose(error.of_state(state)[:, order],
                                   error.deviations(order, state[order], state[order + 1]))
