# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Reference motions: each derivative is the derivative of the one before."""
import numpy as np
import pytest

from screw_kinematics import Joint, Mimic, SerialChain
from screw_kinematics.errors import ParameterError
from screw_kinematics.tools import robot_options
from screw_kinematics.tools.reference_motions import MinimumJerk, MOTIONS, reference_motion

KINDS = ['revolute', 'prismatic', 'continuous']
# Central difference of order 8.
WEIGHTS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])


@pytest.mark.parametrize('name', MOTIONS)
@pytest.mark.parametrize('order', [1, 2, 3, 4])
def test_derivatives_are_those_of_the_positions(name, order):
    motion = reference_motion(name, KINDS)
    # Instants inside minimum-jerk moves and rests, off their ends.
    t = np.array([0.3, 1.1, 1.7, 2.2, 3.3, 4.1, 4.8])[:, None]
    step = 0.01
    below = motion.derivatives(t + step * np.arange(-4, 5), order)[order - 1]
    slope = np.einsum('k,tkj->tj', WEIGHTS, below) / step
    exact = motion.derivatives(t[:, 0], order)[order]
    scale = np.abs(exact).max() + 1.0
    np.testing.assert_allclose(slope, exact, rtol=0, atol=1e-8 * scale)


@pytest.mark.parametrize('name', MOTIONS)
def test_one_instant_has_the_shape_of_a_posture(name):
    assert [x.shape for x in reference_motion(name, KINDS).derivatives(0.4, 4)] == [(3,)] * 5


def test_minimum_jerk_goes_to_the_goal_rests_and_comes_back():
    motion = MinimumJerk([0.0, 1.0], [1.0, -1.0], duration=2.0, rest=0.5)
    q, qd, qdd = motion.derivatives(np.array([0.0, 2.0, 2.4, 2.5, 4.5, 4.9]), 2)
    np.testing.assert_array_equal(q[:, 0], [0, 1, 1, 1, 0, 0])
    np.testing.assert_array_equal(q[:, 1], [1, -1, -1, -1, 1, 1])
    np.testing.assert_array_equal(qd, 0)
    np.testing.assert_array_equal(qdd, 0)


def test_unknown_motion_names_the_known_ones():
    with pytest.raises(ParameterError, match="'motion' is 'waltz'; allowed: paper, minjerk"):
        reference_motion('waltz', KINDS)


def test_a_revolute_joint_moves_as_one_whatever_follows_it():
    """The amplitude of the paper's first joint, in rad, though a prismatic joint follows."""
    robot = SerialChain([
        Joint('turn', 'revolute', axis=(0, 0, 1)),
        Joint('lift', 'prismatic', axis=(0, 0, 1), mimic=Mimic('turn', 0.1))])
    _, qd = robot_options.motion(robot, 'paper').derivatives(0.0, 1)
    np.testing.assert_allclose(qd, [0.2])
