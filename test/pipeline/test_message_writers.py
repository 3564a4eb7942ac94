# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages made of a state: what they say does not depend on the program's axes and point."""
import itertools
from struct import unpack

import numpy as np
import pytest
from screw_kinematics.motion.clock_error import ClockError
from screw_kinematics.pipeline.group_motion import Motion
from screw_kinematics.pipeline.kinematics import Kinematics
from screw_kinematics.pipeline.message_writers import JointColumns, message_writer
from screw_kinematics.pipeline.outputs import KINDS
from screw_kinematics.pipeline.parameter_file import robot_settings
from screw_kinematics.pipeline.robot_program import compile_robot
from support.pipeline_arm import ARM

MOTION = Motion(10**9, [0.3, -0.7, 0.2, 1.1, 0.4, -0.6, 2.0, -3.0, 0.5],
                [1e-8, 2e-8, 3e-8, 1e-6, 5e-6, 2e-6, 3e-4, 1e-4, 2e-4, 1.0, 1.0, 1.0])


def imu(expressed_in, reference_point, motion=MOTION):
    """Return the 37 numbers of the message."""
    settings = robot_settings('arm', {
        'outputs': ['imu'], 'expressed_in': expressed_in, 'reference_point': reference_point,
        'gravity': [0.5, -9.0, 2.0]})
    program = compile_robot(ARM, (KINDS['imu'].needs,), settings)
    state = Kinematics(program, covariance=True).evaluate(motion)
    data = message_writer('imu', program.tips[0], ARM, settings).encode(state)
    return np.array(unpack('<37d', data[-37 * 8:]))


@pytest.mark.parametrize('axes, pole', [*itertools.product(('base', 'tip'), repeat=2)])
def test_imu_is_the_tips_whatever_axes_and_point(axes, pole):
    np.testing.assert_allclose(imu(axes, pole), imu('base', 'tip'), rtol=1e-9, atol=1e-15)


def test_covariances_of_the_imu_are_those_of_the_joints_through_the_jacobian():
    values = imu('base', 'tip')
    q, variances = np.array(MOTION.values[:3]), np.reshape(MOTION.variances, (4, 3))
    R, jacobian = ARM.pose(q)[:3, :3], ARM.jacobian(q, 'tip')
    for start, rows, row in ((4, slice(3), 0), (16, slice(3), 1), (28, slice(3, 6), 2)):
        J = R.T @ jacobian[rows]
        np.testing.assert_allclose(values[start:start + 9].reshape(3, 3),
                                   J @ np.diag(variances[row]) @ J.T, rtol=1e-9, atol=1e-15)


def by_another_instant(output, seconds, axes='base', pole='tip'):
    """Return by how much a program's output differs after some time, to first order."""
    program = ARM.compile(outputs=(output,), axes=axes, pole=pole)
    q, qd, qdd = np.reshape(MOTION.values, (3, -1))
    step = 1e-6
    before, after = (np.array(program.evaluate([*(q + t * qd), *(qd + t * qdd)]))
                     for t in (-step, step))
    return (after - before) / (2 * step) * seconds


def uncertain_motion(late, fast):
    """Return the motion of joints whose clock is off by these deviations."""
    state, variances = (np.reshape(part, (-1, 3)) for part in (MOTION.values, MOTION.variances))
    together = variances + np.square(late * np.vstack([state[1:], np.zeros((2, 3))]))
    together[:3] += np.square(fast * np.arange(3)[:, None] * state)
    return Motion(MOTION.stamp_ns, MOTION.values, together.ravel(), ClockError(late, fast))


def test_the_imu_errs_along_its_motion_where_the_clock_is_uncertain():
    late, fast = 2e-3, 1e-2
    values = imu('base', 'tip', uncertain_motion(late, fast))
    q, qd, _ = np.reshape(MOTION.values, (3, -1))
    variances = np.reshape(MOTION.variances, (4, 3))
    J = ARM.pose(q)[:3, :3].T @ ARM.jacobian(q, 'tip')[:3]
    later = np.stack([late * J @ qd, by_another_instant('twist', late, 'tip')[:3]])
    faster = np.stack([np.zeros(3), fast * J @ qd])
    for start, k in ((4, 0), (16, 1)):
        np.testing.assert_allclose(
            values[start:start + 9].reshape(3, 3),
            J @ np.diag(variances[k]) @ J.T + np.outer(later[k], later[k])
            + np.outer(faster[k], faster[k]), rtol=1e-7, atol=1e-15)


@pytest.mark.parametrize('axes, pole', [*itertools.product(('base', 'tip'), repeat=2)])
def test_a_twist_errs_by_what_it_is_at_another_instant(axes, pole):
    """The posture is another one then, too: the Jacobian's change is part of it."""
    late = 2e-3
    settings = robot_settings('arm', {'outputs': ['twist_with_covariance'],
                                      'expressed_in': axes, 'reference_point': pole})
    program = compile_robot(ARM, (KINDS['twist_with_covariance'].needs,), settings)
    state = Kinematics(program, covariance=True).evaluate(uncertain_motion(late, 0.0))
    data = message_writer('twist_with_covariance', program.tips[0], ARM, settings).encode(state)
    # Messages have the linear part first.
    found = np.roll(np.reshape(unpack('<36d', data[-36 * 8:]), (6, 6)), 3, (0, 1))
    J = np.reshape(ARM.compile(outputs=('jacobian',), axes=axes, pole=pole).evaluate(
        MOTION.values[:3]), (6, 3))
    later = by_another_instant('twist', late, axes, pole)
    np.testing.assert_allclose(found, J @ np.diag(MOTION.variances[3:6]) @ J.T
                               + np.outer(later, later), rtol=1e-6, atol=1e-12)


def test_columns_of_a_tip():
    row = list(range(12))
    assert JointColumns([0, 1, 2], 3).select(row, 2) == [6, 7, 8]
    assert JointColumns([2, 0], 3).select(row, 2) == [8, 6]
