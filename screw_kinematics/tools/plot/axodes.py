# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The axodes of a motion in space: the fixed one, and the moving one as it lies at the start."""
from __future__ import annotations

from typing import Any

import numpy as np

from .histories import COLOURS, pyplot
from .space import show_cube
from ..reference_motions import ReferenceMotion
from ...chains.manipulator import Manipulator
from ...screws.axodes import axodes
from ...screws.screw import Screw
from ...screws.se3 import Array, matvec

# Axes farther away than this, in sizes of the tip's path and the robot, are left out.
_FARTHEST = 3.0


def draw_axodes(robot: Manipulator, motion: ReferenceMotion, time: Array) -> Any:
    """Draw the axodes of a robot's tip in a motion, from lines at some instants [s]."""
    state = robot.state(*motion.derivatives(time, 1))
    found = axodes(state)
    pose, path = np.asarray(state.pose[0], float), np.asarray(state.pose[:, :3, 3], float)
    seen = np.vstack([path, np.zeros((1, 3))])
    middle = (seen.max(axis=0) + seen.min(axis=0)) / 2
    size = float(np.ptp(seen, axis=0).max())
    figure = pyplot().figure(figsize=(7.2, 6.4), layout='constrained')
    space: Any = figure.add_subplot(projection='3d')
    fixed = found.fixed.axis, found.fixed.point
    moving = (matvec(pose[:3, :3], found.moving.axis),
              matvec(pose[:3, :3], found.moving.point) + pose[:3, 3])
    for (axis, point), colour, label in ((fixed, COLOURS[0], 'fixed axode'),
                                         (moving, COLOURS[1], 'moving axode, at the start')):
        _draw_lines(space, axis, point, found.fixed, middle, size, colour, label)
    space.plot(*path.T, color='#555555', linewidth=1.5, label=f'path of {robot.tip_frame}')
    show_cube(space, middle, size)
    figure.suptitle(f'{getattr(robot, "name", "")}: axodes of {robot.tip_frame} relative to '
                    f'{robot.base_frame}\nthe moving one rolls on the fixed one, and slides by '
                    'the pitch', fontsize=10)
    return figure


def _draw_lines(space: Any, axis: Array, point: Array, screw: Screw, middle: Array, size: float,
                colour: str, label: str | None) -> None:
    """Draw the part of each line of a ruled surface that is nearest to the middle."""
    # A point of each line that is nearest to the middle.
    near = point + axis * ((middle - point) * axis).sum(axis=-1, keepdims=True)
    shown = (screw.amplitude > 0) & np.isfinite(screw.pitch) & (
        np.linalg.norm(near - middle, axis=-1) < _FARTHEST * size)
    for k in np.nonzero(shown)[0]:
        ends = near[k] + 0.5 * size * axis[k] * np.array([[-1.0], [1.0]])
        space.plot(*ends.T, color=colour, linewidth=0.6, alpha=0.7, label=label)
        label = None
