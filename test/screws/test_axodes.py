# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Axodes are one line seen twice, and roll on each other."""
import numpy as np
import pytest

from screw_kinematics.errors import InvalidValueError
from screw_kinematics.screws import axodes, lines, se3
from support import robots


def sinusoids(chain, time, order=1):
    """Return a smooth motion of the joints."""
    rates = 1 + 0.3 * np.arange(chain.dof)
    phase = time[:, None] * rates + np.arange(chain.dof)
    return [0.4 * np.sin(phase), 0.4 * rates * np.cos(phase)][:order + 1]


@pytest.mark.parametrize('name', ['puma560', 'panda'])
def test_the_moving_axode_lies_on_the_fixed_one(name):
    chain = robots.robot(name)
    state = chain.state(*sinusoids(chain, np.linspace(0, 3, 20)))
    fixed, moving = axodes(state)
    R, p = state.pose[:, :3, :3], state.pose[:, :3, 3]
    np.testing.assert_allclose(se3.matvec(R, moving.axis), fixed.axis, atol=1e-12)
    np.testing.assert_allclose(moving.pitch, fixed.pitch, atol=1e-12)
    carried = lines.line(se3.matvec(R, moving.point) + p, fixed.axis)
    np.testing.assert_allclose(carried, lines.line(fixed.point, fixed.axis), atol=1e-10)


def test_centrodes_roll_without_slipping():
    """In a plane the contact point runs along both curves with the same velocity."""
    chain = robots.robot('rpr')
    h = 1e-5
    time = np.linspace(0.2, 2, 15)

    def curves(at):
        state = chain.state(*sinusoids(chain, at))
        return state.pose[:, :3, :3], *(screw.point for screw in axodes(state))

    (_, fixed_before, moving_before), (R, _, _), (_, fixed_after, moving_after) = map(
        curves, (time - h, time, time + h))
    along_fixed = (fixed_after - fixed_before) / (2 * h)
    along_moving = se3.matvec(R, moving_after - moving_before) / (2 * h)
    np.testing.assert_allclose(along_moving, along_fixed, rtol=0,
                               atol=1e-5 * np.abs(along_fixed).max())
    assert np.abs(along_fixed).max() > 0.1


def test_the_axodes_of_a_screw_joint_are_its_axis():
    chain = robots.random_chain(3, ('helical',))
    fixed, moving = axodes(chain.state(np.linspace(-1, 1, 5)[:, None], np.ones((5, 1))))
    np.testing.assert_allclose(fixed.pitch, chain.joints[0].pitch, rtol=1e-12)
    np.testing.assert_allclose(np.ptp(fixed.point, axis=0), 0, atol=1e-12)
    np.testing.assert_allclose(np.ptp(moving.point, axis=0), 0, atol=1e-12)


def test_what_is_no_motion_is_named():
    with pytest.raises(InvalidValueError, match=r'motion must be a BodyState, got \[\]'):
        axodes([])
