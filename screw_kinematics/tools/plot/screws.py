# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A picture in space of an arm's joint screws and of its instantaneous screw axis."""
from __future__ import annotations

from typing import Any

import numpy as np

from .space import SpacePicture
from ...chains.serial_chain import SerialChain
from ...errors import ToolError
from ...screws.se3 import Array

_JOINT_COLOUR = '#555555'


def draw_screws(robot: Any, q: Array, qd: Array) -> Any:
    """
    Draw joint screws, frames, and the screw axis of the tip's motion, at a posture.

    Parameters
    ----------
    robot : SerialChain
        An open chain.
    q, qd : array, shape (dof,)
        Positions [rad, m] and rates [rad/s, m/s] of the measured joints.

    Returns
    -------
    matplotlib.figure.Figure

    """
    if not isinstance(robot, SerialChain):
        raise ToolError(f'{robot.name}: a picture of joint screws is drawn of open chains only')
    state = robot.state(q, qd)
    screws = np.asarray(robot.screws(q, pole='base'), dtype=float)
    feet = _skeleton(robot, screws, state.pose[:3, 3])
    picture = SpacePicture(feet)
    space, size = picture.space, picture.size
    space.plot(*feet.T, color='#BBBBBB', linewidth=5, solid_capstyle='round',
               label='links (schematic)')
    for number, (joint, screw, foot) in enumerate(zip(robot.joints, screws, feet[1:]), 1):
        prismatic = joint.kind == 'prismatic'
        direction = screw[3:] if prismatic else screw[:3]
        picture.draw_segment(foot, direction, 0.16 * size, _JOINT_COLOUR,
                             ':' if prismatic else '-')
        # At one end and the other in turn, as neighbouring axes often meet.
        end = 0.2 * size * direction * (1 if number % 2 else -1)
        space.text(*(foot + end), _symbol(number), fontsize=9, ha='center', va='center')
    names = [f'{_symbol(i)}  {joint.name}' for i, joint in enumerate(robot.joints, 1)]
    space.text2D(0.0, 0.86, '\n'.join(names), transform=space.transAxes, fontsize=8,
                 va='top')
    picture.finish(robot, 'joint screws', np.asarray(state.pose, dtype=float),
                   np.asarray(state.velocity, dtype=float))
    return picture.figure


def _symbol(number: int) -> str:
    return f'$\\$_{{{number}}}$'


def _skeleton(robot: Any, screws: Array, tip: Array) -> Array:
    """Return points to draw links between: on each axis that nearest the one before."""
    points = [np.zeros(3)]
    for joint, screw in zip(robot.joints, screws):
        axis, moment = screw[:3], screw[3:]
        if joint.kind == 'prismatic':
            points.append(points[-1])
        else:
            foot = np.cross(axis, moment)
            points.append(foot + axis * (axis @ (points[-1] - foot)))
    return np.array([*points, np.asarray(tip, dtype=float)])
