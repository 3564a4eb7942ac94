# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A picture in space of an arm's joint screws and of its instantaneous screw axis."""
from __future__ import annotations

from typing import Any

import numpy as np

from .figures import COLOURS, pyplot
from ..chain import SerialChain
from ..errors import ToolError
from ..screws import screw_of_twist
from ..se3 import Array

_JOINT_COLOUR = '#555555'
_AXIS_COLOUR = '#CC0000'


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
    plt = pyplot()
    state = robot.state(q, qd)
    screws = np.asarray(robot.screws(q, pole='base'), dtype=float)
    feet = _skeleton(robot, screws, state.pose[:3, 3])
    low, high = bounds(feet)
    size = float((high - low).max())
    figure = plt.figure(figsize=(7.2, 6.4), layout='constrained')
    space = figure.add_subplot(projection='3d')
    space.plot(*feet.T, color='#BBBBBB', linewidth=5, solid_capstyle='round',
               label='links (schematic)')
    for number, (joint, screw, foot) in enumerate(zip(robot.joints, screws, feet[1:]), 1):
        prismatic = joint.kind == 'prismatic'
        direction = screw[3:] if prismatic else screw[:3]
        draw_segment(space, foot, direction, 0.16 * size, _JOINT_COLOUR,
                     ':' if prismatic else '-')
        # At one end and the other in turn, as neighbouring axes often meet.
        end = 0.2 * size * direction * (1 if number % 2 else -1)
        space.text(*(foot + end), _symbol(number), fontsize=9, ha='center', va='center')
    draw_frame(space, np.eye(4), 0.14 * size, robot.base_frame)
    draw_frame(space, np.asarray(state.pose, dtype=float), 0.14 * size, robot.tip_frame)
    title = draw_motion(space, np.asarray(state.velocity, dtype=float), state.pose[:3, 3],
                        (low + high) / 2, size)
    set_limits(space, low, high)
    names = [f'{_symbol(i)}  {joint.name}' for i, joint in enumerate(robot.joints, 1)]
    space.text2D(0.0, 0.86, '\n'.join(names), transform=space.transAxes, fontsize=8,
                 va='top')
    space.legend(loc='upper left', fontsize=8)
    figure.suptitle(f'{robot.name}: joint screws, and motion of {robot.tip_frame} relative '
                    f'to {robot.base_frame}\n{title}', fontsize=10)
    return figure


def set_limits(space: Any, low: Array, high: Array) -> None:
    """Show this part of space, in equal scales."""
    size = float((high - low).max())
    for axis, limits in zip('xyz', zip(low, high)):
        middle = sum(limits) / 2
        getattr(space, f'set_{axis}lim')(middle - 0.62 * size, middle + 0.62 * size)
        getattr(space, f'set_{axis}label')(f'{axis} [m]')
    space.set_box_aspect((1, 1, 1))


def draw_motion(space: Any, twist: Array, tip: Array, centre: Array, size: float) -> str:
    """Draw the instantaneous screw axis; return what to say of it."""
    screw = screw_of_twist(twist)
    if not screw.amplitude > 0:
        return 'at rest: there is no screw axis'
    through = tip if np.isinf(screw.pitch) else tip + screw.point
    # Centred where the axis passes the robot, not where it passes the tip.
    middle = through + screw.axis * (screw.axis @ (centre - through))
    draw_segment(space, middle, screw.axis, 0.6 * size, _AXIS_COLOUR, '-',
                 label='instantaneous screw axis')
    if np.isinf(screw.pitch):
        return f'instantaneous motion: translation at {screw.amplitude:.4g} m/s'
    return (f'instantaneous motion: {screw.amplitude:.4g} rad/s about the axis, pitch '
            f'{1e3 * screw.pitch:.4g} mm/rad')


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


def bounds(points: Array) -> tuple[Array, Array]:
    """Return the least and the greatest coordinates to show."""
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.1 * float((high - low).max()) + 1e-3
    return low - margin, high + margin


def draw_segment(space: Any, middle: Array, direction: Array, half: float, colour: str,
                 style: str, label: str | None = None) -> None:
    """Draw a directed line through a point."""
    begin = middle - half * direction
    space.quiver(*begin, *(2 * half * direction), color=colour, linestyle=style,
                 linewidth=1.6, arrow_length_ratio=0.08, label=label)


def draw_frame(space: Any, pose: Array, length: float, name: str) -> None:
    """Draw a frame with its name."""
    origin = pose[:3, 3]
    for colour, direction in zip(COLOURS, pose[:3, :3].T):
        space.quiver(*origin, *(length * direction), color=colour, linewidth=2,
                     arrow_length_ratio=0.15)
    space.text(*(origin - 0.35 * length * pose[:3, 2]), name, fontsize=8, color='#0033AA')
