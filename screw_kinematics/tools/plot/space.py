# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What pictures of robots in space have in common: frames, lines, the screw axis, equal scales."""
from __future__ import annotations

from typing import Any

import numpy as np

from .histories import COLOURS, pyplot
from ...screws.screw import screw_of_twist
from ...screws.se3 import Array

_AXIS_COLOUR = '#CC0000'


class SpacePicture:
    """
    A picture of a part of space.

    Parameters
    ----------
    points : array, shape (n, 3)
        What is to be seen [m].

    Attributes
    ----------
    figure : matplotlib.figure.Figure
    space : matplotlib.axes.Axes
    size : float
        Length of the part of space that is shown [m].

    """

    def __init__(self, points: Array) -> None:
        low, high = points.min(axis=0), points.max(axis=0)
        self.size = 1.2 * float((high - low).max()) + 2e-3
        self._middle = (low + high) / 2
        self.figure = pyplot().figure(figsize=(7.2, 6.4), layout='constrained')
        self.space: Any = self.figure.add_subplot(projection='3d')

    def draw_segment(self, middle: Array, direction: Array, half: float, colour: str,
                     style: str, label: str | None = None) -> None:
        """Draw a directed line through a point."""
        begin = middle - half * direction
        self.space.quiver(*begin, *(2 * half * direction), color=colour, linestyle=style,
                          linewidth=1.6, arrow_length_ratio=0.08, label=label)

    def finish(self, robot: Any, what: str, pose: Array, twist: Array) -> None:
        """
        Draw both frames and the instantaneous screw axis; set scales and title.

        Parameters
        ----------
        robot : SerialChain or ParallelManipulator
            Names itself and the frames.
        what : str
            What was drawn of it.
        pose : array, shape (4, 4)
            Of the tip frame.
        twist : array, shape (6,)
            Of the tip; pole: tip, axes: base.

        """
        self._draw_frame(np.eye(4), robot.base_frame)
        self._draw_frame(pose, robot.tip_frame)
        motion = self._draw_motion(twist, pose[:3, 3])
        for axis, middle in zip('xyz', self._middle):
            getattr(self.space, f'set_{axis}lim')(middle - 0.62 * self.size,
                                                  middle + 0.62 * self.size)
            getattr(self.space, f'set_{axis}label')(f'{axis} [m]')
        self.space.set_box_aspect((1, 1, 1))
        self.space.legend(loc='upper left', fontsize=8)
        self.figure.suptitle(f'{robot.name}: {what}, and motion of {robot.tip_frame} relative '
                             f'to {robot.base_frame}\n{motion}', fontsize=10)

    def _draw_motion(self, twist: Array, tip: Array) -> str:
        """Draw the instantaneous screw axis; return what to say of it."""
        screw = screw_of_twist(twist)
        if not screw.amplitude > 0:
            return 'at rest: there is no screw axis'
        through = tip if np.isinf(screw.pitch) else tip + screw.point
        # Centred where the axis passes the robot, not where it passes the tip.
        middle = through + screw.axis * (screw.axis @ (self._middle - through))
        self.draw_segment(middle, screw.axis, 0.6 * self.size, _AXIS_COLOUR, '-',
                          label='instantaneous screw axis')
        if np.isinf(screw.pitch):
            return f'instantaneous motion: translation at {screw.amplitude:.4g} m/s'
        return (f'instantaneous motion: {screw.amplitude:.4g} rad/s about the axis, pitch '
                f'{1e3 * screw.pitch:.4g} mm/rad')

    def _draw_frame(self, pose: Array, name: str) -> None:
        """Draw a frame with its name."""
        origin, length = pose[:3, 3], 0.14 * self.size
        for colour, direction in zip(COLOURS, pose[:3, :3].T):
            self.space.quiver(*origin, *(length * direction), color=colour, linewidth=2,
                              arrow_length_ratio=0.15)
        self.space.text(*(origin - 0.35 * length * pose[:3, 2]), name, fontsize=8,
                        color='#0033AA')
