# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Postures and states of the shipped robots, against their geometry in closed form."""
from functools import cache

import numpy as np
import pytest
from support.parallel_geometry import moment, ROBOTS
from support.robots import robot

load = cache(robot)
instant = cache(moment)
cases = pytest.mark.parametrize(('name', 'seed'), [(n, s) for n in ROBOTS for s in range(4)])


def close(actual, expected, tolerance=1e-12):
    scale = max(1.0, float(np.max(np.abs(expected))))
    np.testing.assert_allclose(actual, expected, rtol=0, atol=tolerance * scale)


@cases
def test_pose_is_that_of_the_geometry(name, seed):
    """From home, whatever way the actuators take."""
    exact = instant(name, seed)
    close(load(name).state(exact.joints[0]).pose, exact.platform.pose)


@cases
def test_inverse_posture_is_that_of_the_geometry(name, seed):
    exact = instant(name, seed)
    close(load(name).posture_at(exact.platform.pose).actuated, exact.joints[0])


@cases
def test_states_of_every_order_are_exact(name, seed):
    """Reduced and classical, from velocity to jounce."""
    exact = instant(name, seed)
    state = load(name).state(*exact.joints)
    for n in range(1, 5):
        close(state.reduced[n - 1], exact.platform.reduced[n - 1], 1e-11)
        close(state.classical(n), exact.platform.classical[n - 1], 1e-11)


@cases
def test_inverse_rates_of_every_order_are_exact(name, seed):
    manipulator, exact = load(name), instant(name, seed)
    actuated, _ = manipulator.inverse_rates(
        manipulator.posture(exact.joints[0]), *exact.platform.reduced[:4])
    for n in range(1, 5):
        close(actuated[n - 1], exact.joints[n], 1e-11)


@cases
def test_every_limb_moves_the_platform_alike(name, seed):
    """With passive positions and rates each limb is an open chain with the same tip."""
    manipulator, exact = load(name), instant(name, seed)
    posture = manipulator.posture(exact.joints[0])
    states, passive = manipulator.rates(posture, *exact.joints[1:])
    names = manipulator.joint_names + manipulator.passive_joint_names
    motion = [dict(zip(names, [*a, *p])) for a, p in zip(
        exact.joints, [posture.passive, *passive])]
    for limb in manipulator.limbs:
        state = limb.state(*[[values[n] for n in limb.joint_names] for values in motion])
        close(state.pose, posture.pose)
        for n in range(4):
            close(state.reduced[n], states[n], 1e-11)


@pytest.mark.parametrize('name', ROBOTS)
def test_samples_one_after_the_other(name):
    """A batch is what its samples are one by one."""
    manipulator, exact = load(name), instant(name, 0)
    q = np.linspace(manipulator.home.actuated, exact.joints[0], 5)
    qd = np.tile(exact.joints[1], (5, 1))
    state = manipulator.state(q, qd)
    for k in range(5):
        single = manipulator.state(q[k], qd[k])
        close(state.pose[k], single.pose)
        close(state.velocity[k], single.velocity)
