# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Newton-Raphson on the loop closure of a parallel manipulator.

The unknowns are the passive joints and the platform's pose; the residual of each limb is
the displacement from its tip to the platform; the Jacobian is made of the limbs' screws.
Where measurements are redundant it is the Gauss-Newton method of least squares.
"""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
import math

import numpy as np

from .limbs import Limbs
from .screw_system import Ranks, ScrewSystem
from ..screws.rotations import pose
from ..screws.se3 import Array

MAX_ITERATIONS = 12
CONVERGED = 1e-12
"""Size of the last step [rad, or lengths by the characteristic length]."""
ROUNDING = 1e-9
"""Size of steps that are rounding errors once they shrink no more, near singularities."""
MAX_STEP = 0.5
"""Longest step; a longer one is shortened, since the loops are far from linear there."""
SMALLEST_SHARE = 1 / 32
"""Part of a step that must make the misfit smaller."""


@dataclass(frozen=True, eq=False)
class Solution:
    """
    Where the iteration ended.

    Where the limbs disagree, the pose is the one nearest to all; the screws are those one step
    before. The misfit is how far each limb's tip is from the platform (from the tips' mean, where
    its pose is unknown): rotation [rad] and displacement by the characteristic length. Converged
    is what came to rest, be it with the loops closed or not.
    """

    joints: Array
    pose: Array
    system: ScrewSystem
    misfit: Array
    iterations: int
    converged: bool


def close_loops(limbs: Limbs, joints: Array, ranks: Ranks | None = None,
                iterations: int = MAX_ITERATIONS) -> Solution:
    """
    Move the passive joints until the limbs agree about the platform.

    Ranks are those of the limbs' passive screws in general posture.
    """
    rest = np.zeros(len(limbs.actuated))

    def step(system: ScrewSystem, error: Array) -> tuple[Array, Array]:
        platform, passive = system.solve_platform(-error)
        return np.concatenate([rest, passive[limbs.slot_of]]), platform

    return _iterate(limbs, joints, None, ranks, step, iterations)


def close_at_pose(limbs: Limbs, joints: Array, pose: Array,
                  ranks: Ranks | None = None) -> Solution:
    """Move all joints until every limb has the platform at a pose in the base frame."""
    def step(system: ScrewSystem, error: Array) -> tuple[Array, Array]:
        actuated, passive = system.solve_joints(error)
        return np.concatenate([actuated, passive[limbs.slot_of]]), np.zeros(6)

    return _iterate(limbs, joints, pose, ranks, step)


def _iterate(limbs: Limbs, joints: Array, target: Array | None, ranks: Ranks | None,
             step: Callable[[ScrewSystem, Array], tuple[Array, Array]],
             iterations: int = MAX_ITERATIONS) -> Solution:
    before, change, smallest, share = joints, 0.0 * joints, np.inf, 1.0
    last = np.inf
    for iteration in range(1, iterations + 1):
        rotations, positions, screws = limbs.kinematics(joints.tolist())
        system = ScrewSystem(screws, limbs.length, ranks)
        # Any limb's tip will do as the pose to linearise at.
        near = pose(rotations[0], positions[0]) if target is None else target
        error = _displacement(rotations, positions, near)
        misfit = system.size(
            error if target is not None else error - error.sum(axis=0) / len(error))
        step_here, platform = step(system, error)
        size = float((np.abs(step_here) * limbs.scale).max())
        if not math.isfinite(size):
            break
        if size <= CONVERGED or last / 4 < size <= ROUNDING:
            return Solution(joints + step_here, _moved(near, platform), system, misfit,
                            iteration, True)
        last, total = size, math.sqrt(misfit @ misfit)
        if total < smallest:
            before, change, smallest = joints, step_here * min(1.0, MAX_STEP / size), total
            share = 1.0
        elif share > SMALLEST_SHARE:
            share /= 4
        else:
            break
        joints = before + share * change
    return Solution(joints, _moved(near, platform), system, misfit, iteration, False)


def _displacement(rotations: Array, positions: Array, goal: Array) -> Array:
    """
    Return the motion from poses to a goal, shape (..., 6), exact to first order.

    The angular part is twice the Gibbs vector, 2 tan(angle / 2) about the axis: it needs no
    branches, and vanishes only where the orientations agree.
    """
    turn = goal[:3, :3] @ np.swapaxes(rotations, -1, -2)
    twice_axis = (turn - np.swapaxes(turn, -1, -2))[..., (2, 0, 1), (1, 2, 0)]
    trace = np.einsum('...ii', turn)
    angular = 2 * twice_axis / np.maximum(1 + trace, 1e-9)[..., None]
    if np.min(trace) < -1 + 1e-9:   # half a turn, where the axis above vanishes
        angular = np.where(trace[..., None] < -1 + 1e-9, np.pi, angular)
    return np.concatenate([angular, goal[:3, 3] - positions], axis=-1)


def _moved(start: Array, displacement: Array) -> Array:
    """Return a pose moved by a displacement about its own origin."""
    x, y, z = displacement[:3].tolist()
    angle = math.sqrt(x * x + y * y + z * z)
    turn = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    if angle > 0:
        half = math.sin(angle / 2) / angle
        turn = math.sin(angle) / angle * turn + 2 * half * half * (turn @ turn)
    return pose(start[:3, :3] + turn @ start[:3, :3], start[:3, 3] + displacement[3:])
