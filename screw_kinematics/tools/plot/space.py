# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures in space: a robot's links, its joint screws or held wrenches, the screw axis."""
from __future__ import annotations

from typing import Any

import numpy as np

from .histories import COLOURS, pyplot
from ...chains.manipulator import Manipulator
from ...chains.serial_chain import SerialChain
from ...parallel import ParallelManipulator
from ...screws.screw import Screw, screw_of_twist
from ...screws.se3 import Array

_AXIS_COLOUR = '#CC0000'
_JOINT_COLOUR = '#555555'
_WRENCH_COLOUR = '#0077BB'
# An axis farther away, in sizes of the robot, would leave a dot of it: its direction is shown.
_FARTHEST = 15.0


def draw_space(robot: Manipulator, q: Array, qd: Array) -> Any:
    """
    Draw a robot at a posture, and the screw axis of its tip's motion.

    An open chain is drawn with its joint screws, a parallel manipulator with the axes of the
    wrenches that its locked actuators hold.
    """
    state = robot.state(q, qd)
    pose, twist = np.asarray(state.pose, float), np.asarray(state.velocity, float)
    lines = robot.skeleton(q)
    picture = _Picture(np.vstack([*lines, np.zeros((1, 3))]), screw_of_twist(twist), pose[:3, 3])
    if isinstance(robot, ParallelManipulator):
        what = 'limbs'
        _draw_limbs(picture, robot, q, pose[:3, 3])
    else:
        assert isinstance(robot, SerialChain)
        what = 'joint screws'
        _draw_joint_screws(picture, robot, q, lines[0])
    picture.draw_frame(np.eye(4), robot.base_frame)
    picture.draw_frame(pose, robot.tip_frame)
    picture.draw_screw_axis()
    picture.finish(f'{getattr(robot, "name", "")}: {what}, and motion of {robot.tip_frame} '
                   f'relative to {robot.base_frame}')
    return picture.figure


def _draw_joint_screws(picture: _Picture, robot: SerialChain, q: Array, line: Array) -> None:
    space, size = picture.space, picture.robot_size
    space.plot(*line.T, color='#BBBBBB', linewidth=5, solid_capstyle='round',
               label='links (schematic)')
    screws = np.asarray(robot.screws(q, pole='base'), dtype=float)
    for number, (joint, screw, foot) in enumerate(zip(robot.joints, screws, line[1:]), 1):
        prismatic = joint.kind == 'prismatic'
        direction = screw[3:] if prismatic else screw[:3]
        picture.draw_segment(foot, direction, 0.16 * size, _JOINT_COLOUR,
                             ':' if prismatic else '-')
        # At one end and the other in turn, as neighbouring axes often meet.
        end = 0.2 * size * direction * (1 if number % 2 else -1)
        if picture.room_for_words:
            space.text(*(foot + end), _symbol(number), fontsize=9, ha='center', va='center')
    names = [f'{_symbol(i)}  {joint.name}' for i, joint in enumerate(robot.joints, 1)]
    space.text2D(0.0, 0.86, '\n'.join(names), transform=space.transAxes, fontsize=8, va='top')


def _symbol(number: int) -> str:
    return f'$\\$_{{{number}}}$'


def _draw_limbs(picture: _Picture, robot: ParallelManipulator, q: Array, tip: Array) -> None:
    posture = robot.posture(q)
    label: str | None = 'wrenches of the actuators'
    for points, wrenches in zip(robot.points(posture).values(), robot.wrenches(posture)[0]):
        # Joints of one centre are one point; the platform reaches from the last to its frame.
        picture.space.plot(*points[:-1].T, color='#888888', linewidth=3, marker='o',
                           markersize=4)
        picture.space.plot(*points[-2:].T, color='#CCCCCC', linewidth=3)
        for force, moment in zip(wrenches[:, :3], wrenches[:, 3:]):
            if force @ force > 0.5:     # a unit force; a couple has no axis
                near = tip + np.cross(force, moment)
                middle = near + force * (force @ (points[:-1].mean(axis=0) - near))
                picture.draw_segment(middle, force, 0.3 * picture.robot_size, _WRENCH_COLOUR,
                                     '--', label)
                label = None


class _Picture:
    """A part of space, large enough for a robot's points and for the screw axis of its tip."""

    def __init__(self, points: Array, screw: Screw, tip: Array) -> None:
        self._screw = screw
        middle, self.robot_size = _box(points)
        # Centred where the axis passes the robot, not where it passes the tip.
        through = tip if np.isinf(screw.pitch) else tip + screw.point
        self._axis_point = through + screw.axis * (screw.axis @ (middle - through))
        self._tip = tip
        self.distance = float(np.linalg.norm(self._axis_point - middle)) \
            if screw.amplitude > 0 else 0.0
        self.far = self.distance > _FARTHEST * self.robot_size
        seen = points if self.far else np.vstack([points, self._axis_point])
        self._middle, self._size = _box(seen)
        self.room_for_words = self._size < 3 * self.robot_size
        self.figure = pyplot().figure(figsize=(7.2, 6.4), layout='constrained')
        self.space: Any = self.figure.add_subplot(projection='3d')

    def draw_segment(self, middle: Array, direction: Array, half: float, colour: str,
                     style: str, label: str | None = None) -> None:
        """Draw a directed line through a point."""
        begin = middle - half * direction
        self.space.quiver(*begin, *(2 * half * direction), color=colour, linestyle=style,
                          linewidth=1.6, arrow_length_ratio=0.08, label=label)

    def draw_frame(self, pose: Array, name: str) -> None:
        """Draw a frame with its name."""
        origin, length = pose[:3, 3], 0.14 * self.robot_size
        for colour, direction in zip(COLOURS, pose[:3, :3].T):
            self.space.quiver(*origin, *(length * direction), color=colour, linewidth=2,
                              arrow_length_ratio=0.15)
        self.space.text(*(origin - 0.35 * length * pose[:3, 2]), name, fontsize=8,
                        color='#0033AA')

    def draw_screw_axis(self) -> None:
        """Draw the instantaneous screw axis, or the way to one that is far away."""
        if not self._screw.amplitude > 0:
            return
        if not self.far:
            self.draw_segment(self._axis_point, self._screw.axis, 0.6 * self._size, _AXIS_COLOUR,
                              '-', label='instantaneous screw axis')
        if self.distance > 0.5 * self.robot_size:
            # Perpendicular to the axis, from the tip: how far away the axis is.
            to_axis: Array = self._axis_point - self._tip
            to_axis = to_axis - self._screw.axis * (self._screw.axis @ to_axis)
            end = self._tip + to_axis * min(
                1.0, 0.55 * self._size / float(np.linalg.norm(to_axis))
                if self.far else 1.0)
            self.space.plot(*np.array([self._tip, end]).T, '--', color=_AXIS_COLOUR,
                            linewidth=1.0, label='to the screw axis, '
                            f'{np.linalg.norm(to_axis):.3g} m from the tip')

    def finish(self, title: str) -> None:
        """Set scales, legend and title."""
        show_cube(self.space, self._middle, 0.62 * self._size)
        self.figure.suptitle(f'{title}\n{_motion(self._screw)}', fontsize=10)


def show_cube(space: Any, middle: Array, half: float) -> None:
    """Show what is within half a cube's length of a point, in the same scale, and the legend."""
    for axis, centre in zip('xyz', middle):
        getattr(space, f'set_{axis}lim')(centre - half, centre + half)
        getattr(space, f'set_{axis}label')(f'{axis} [m]')
    space.set_box_aspect((1, 1, 1))
    space.legend(loc='upper left', fontsize=8)


def _box(points: Array) -> tuple[Array, float]:
    """Return the middle of points and the length of the part of space they need [m]."""
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2, 1.2 * float((high - low).max()) + 2e-3


def _motion(screw: Screw) -> str:
    """Return what to say of the tip's motion."""
    if not screw.amplitude > 0:
        return 'at rest: there is no screw axis'
    if np.isinf(screw.pitch):
        return f'instantaneous motion: translation at {screw.amplitude:.4g} m/s'
    return (f'instantaneous motion: {screw.amplitude:.4g} rad/s about the axis, pitch '
            f'{1e3 * screw.pitch:.4g} mm/rad')
