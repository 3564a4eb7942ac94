# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A picture in space of a parallel robot's limbs, the forces they hold, and its screw axis."""
from __future__ import annotations

from typing import Any

import numpy as np

from .space import SpacePicture
from ...parallel import ParallelManipulator
from ...screws.se3 import Array

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
    posture = robot.posture(q)
    (twist,), _ = robot.rates(posture, qd)
    limbs = robot.points(posture)
    tip = posture.pose[:3, 3]
    picture = SpacePicture(np.vstack([*limbs.values(), np.zeros((1, 3))]))
    for points in limbs.values():
        # Joints of one centre are one point; the platform reaches from the last to its frame.
        picture.space.plot(*points[:-1].T, color='#888888', linewidth=3, marker='o',
                           markersize=4)
        picture.space.plot(*points[-2:].T, color='#CCCCCC', linewidth=3)
    label: str | None = 'wrenches of the actuators'
    for points, wrenches in zip(limbs.values(), robot.wrenches(posture)[0]):
        for force, moment in zip(wrenches[:, :3], wrenches[:, 3:]):
            if force @ force > 0.5:     # a unit force; a couple has no axis
                near = tip + np.cross(force, moment)
                middle = near + force * (force @ (points[:-1].mean(axis=0) - near))
                picture.draw_segment(
                    middle, force, 0.3 * picture.size, _WRENCH_COLOUR, '--', label)
                label = None
    picture.finish(robot, 'limbs', posture.pose, twist)
    return picture.figure
