# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A program goes on from the last posture of the one that it replaces."""
from functools import cache

import numpy as np
import pytest

from screw_kinematics.errors import AssemblyModeError
from support.parallel_geometry import moment, ROBOTS
from support.robots import robot

load = cache(robot)


def planar_pose(x, y, yaw):
    """Return a pose of the planar platform."""
    T = np.eye(4)
    T[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    T[:2, 3] = x, y
    return T


@cache
def another_mode():
    """Return a posture whose motors lead from home to another one: beyond a singularity."""
    planar = load('planar_3rrr')
    posture = planar.home
    for yaw in np.linspace(0, -1, 11):
        posture = planar.posture_at(planar_pose(0, 0, yaw), posture)
    with pytest.raises(AssemblyModeError, match='another assembly mode than at home'):
        planar.check_assembly_mode(posture)
    return posture


def test_the_assembly_mode_is_kept():
    planar, start = load('planar_3rrr'), another_mode()
    old, new = (planar.compile(outputs) for outputs in (('pose',), ('pose', 'twist')))
    old.posture = start
    q = start.actuated + [0.01, -0.01, 0.02]
    expected = planar.posture(q, start).pose
    new.continue_from(old)
    for program in (old, new):
        np.testing.assert_allclose(program(q, 0 * q)['pose'][:3], expected[:3, 3], atol=1e-12)
    alone = planar.compile(('pose',))
    assert np.abs(alone(q)['pose'] - new(q, 0 * q)['pose']).max() > 0.1


@pytest.mark.parametrize('name', ROBOTS)
def test_a_platform_far_from_home_has_no_way_to_go(name):
    q = moment(name, 0).joints[0]
    old, new, alone = (load(name).compile(('pose',)) for _ in range(3))
    old(q)
    new.continue_from(old)
    np.testing.assert_allclose(new(q)['pose'], alone(q)['pose'], atol=1e-12)
    assert new.posture.iterations <= 2 < alone.posture.iterations


def test_a_tool_goes_on_with_its_platform():
    stewart, joints = load('stewart_6ups'), moment('stewart_6ups', 0).joints
    offset = np.eye(4)
    offset[:3, 3] = 0.1, -0.2, 0.3
    old = stewart.compile(('pose',))
    old(joints[0])
    new = stewart.with_tool(offset).compile(('pose',))
    new.continue_from(old)
    np.testing.assert_allclose(new.posture.pose, old.posture.pose @ offset, atol=1e-12)
    np.testing.assert_allclose(new.posture.passive, old.posture.passive, atol=1e-12)


def test_postures_of_other_robots_are_ignored():
    stewart, delta = load('stewart_6ups'), load('delta')
    program = stewart.compile(('pose',))
    for other in (delta.compile(('pose',)), robot('rpr').compile(('pose',))):
        program.continue_from(other)
        assert program.posture is stewart.home
    robot('rpr').compile(('pose',)).continue_from(program)
