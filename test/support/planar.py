# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Planar closed loops whose singular and mirrored postures are known in closed form."""
from functools import cache

import numpy as np

from screw_kinematics import Joint, SerialChain
from screw_kinematics.parallel import ParallelManipulator

from . import parallel_geometry as geometry
from .exact import exact
from .robots import robot

load = cache(robot)


def pose_of(x=0.0, y=0.0, yaw=0.0):
    """Return a pose of the planar platform."""
    T = np.eye(4)
    T[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    T[:2, 3] = x, y
    return T


def with_endless_joints(planar):
    """Return the planar robot with joints whose whole turns do not count."""
    return ParallelManipulator(
        [SerialChain([Joint(j.name, 'continuous', j.axis, j.point) for j in limb.joints],
                     limb.T_base_tool, name=limb.name) for limb in planar.limbs],
        planar.joint_names, dict(zip(
            planar.joint_names + planar.passive_joint_names, planar.home.joints)))


def planar_joints(pose):
    """Return the motors' angles of the planar robot in closed form."""
    q = np.array(geometry.planar_3rrr(exact(pose[:3, :3]), exact(pose[:3, 3])), dtype=float)
    whole_turns = np.round((q - load('planar_3rrr').home.actuated) / (2 * np.pi))
    return q - 2 * np.pi * whole_turns


def forearm_moment(yaw):
    """Return the moment of a forearm's line about the middle, from triangles alone."""
    tip = 0.15 * np.exp(1j * yaw)
    reach = tip - 0.5
    angle = np.angle(reach) + np.arccos(
        (0.3**2 + abs(reach)**2 - 0.25**2) / (2 * 0.3 * abs(reach)))
    elbow = 0.5 + 0.3 * np.exp(1j * angle)
    return (np.conj(tip) * (tip - elbow)).imag


def singular_yaw():
    """Return the turn at which all forearms point at the middle of the platform."""
    low, high = 0.0, -1.0
    assert forearm_moment(low) * forearm_moment(high) < 0
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if forearm_moment(low) * forearm_moment(middle) > 0 \
            else (low, middle)
    return low


def parallelogram():
    """Return a four-bar linkage with cranks of 1 m, 2 m apart, driven on the left."""
    T = np.eye(4)
    T[:2, 3] = 1, 1
    return ParallelManipulator([
        SerialChain([Joint(f'{side}_base', 'revolute', (0, 0, 1), (x, 0, 0)),
                     Joint(f'{side}_tip', 'revolute', (0, 0, 1), (x, 1, 0))], T, name=side)
        for side, x in (('left', 0), ('right', 2))], ['left_base'])


def stretched():
    """Return a pose of the planar robot with limb 3 stretched, and the motors' angles."""
    pose = pose_of(y=-0.2 + 1e-14)
    return pose, planar_joints(pose)
