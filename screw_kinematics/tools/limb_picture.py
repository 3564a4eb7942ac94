# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A picture in space of a parallel robot's limbs, the forces they hold, and its screw axis."""
from __future__ import annotations

from typing import Any

import numpy as np

from .figures import pyplot
from .screw_picture import bounds, draw_frame, draw_motion, draw_segment, set_limits
from ..parallel import ParallelManipulator
from ..se3 import Array

_WRENCH_COLOUR = '#0077BB'


def draw_limbs(robot: ParallelManipulator, q: Array, qd: Array) -> Any:
    """
    Draw limbs, axes of the actuators' wrenches, and the screw axis of the platform's motion.

    Parameters
    ----------
    robot : ParallelManipulator
        What to draw.
    q, qd : array, shape (dof,)
        Positions [rad, m] and rates [rad/s, m/s] of the actuated joints.

    Returns
    -------
    matplotlib.figure.Figure

    """
    plt = pyplot()
    posture = robot.posture(q)
    (twist,), _ = robot.rates(posture, qd)
    limbs = robot.points(posture)
    tip = posture.pose[:3, 3]
    low, high = bounds(np.vstack([*limbs.values(), np.zeros((1, 3))]))
    size = float((high - low).max())
    figure = plt.figure(figsize=(7.2, 6.4), layout='constrained')
    space = figure.add_subplot(projection='3d')
    for points in limbs.values():
        # Joints of one centre are one point; the platform reaches from the last to its frame.
        space.plot(*points[:-1].T, color='#888888', linewidth=3, marker='o', markersize=4)
        space.plot(*points[-2:].T, color='#CCCCCC', linewidth=3)
    label: str | None = 'wrenches of the actuators'
    for points, wrenches in zip(limbs.values(), robot.wrenches(posture)[0]):
        for force, moment in zip(wrenches[:, :3], wrenches[:, 3:]):
            if force @ force > 0.5:     # a unit force; a couple has no axis
                near = tip + np.cross(force, moment)
                middle = near + force * (force @ (points[:-1].mean(axis=0) - near))
                draw_segment(space, middle, force, 0.3 * size, _WRENCH_COLOUR, '--', label)
                label = None
    draw_frame(space, np.eye(4), 0.14 * size, robot.base_frame)
    draw_frame(space, posture.pose, 0.14 * size, robot.tip_frame)
    title = draw_motion(space, twist, tip, (low + high) / 2, size)
    set_limits(space, low, high)
    space.legend(loc='upper left', fontsize=8)
    figure.suptitle(f'{robot.name}: limbs, and motion of {robot.tip_frame} relative to '
                    f'{robot.base_frame}\n{title}', fontsize=10)
    return figure
