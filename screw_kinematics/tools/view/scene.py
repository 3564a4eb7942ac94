# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""One robot in the scene: links, tip's trail, arrows of its motion, screw axis."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from .meshes import RobotMeshes, w_first
from .motion import ShownMotion, Snapshot
from ...pipeline.ellipsoids import ellipsoid
from ...screws.screw import screw_of_twist
from ...screws.se3 import Array

TRAIL = 3.0
"""How long the tip's trail is [s]."""


class Quantity(NamedTuple):
    """A vector that is drawn as an arrow at the tip."""

    label: str
    unit: str
    colour: tuple[int, int, int]


# Colours that stay apart for colour-blind eyes (Okabe and Ito).
QUANTITIES = {
    'v': Quantity('linear velocity v', 'm/s', (0, 114, 178)),
    'w': Quantity('angular velocity w', 'rad/s', (86, 180, 233)),
    'a': Quantity('linear acceleration a', 'm/s²', (213, 94, 0)),
    'alpha': Quantity('angular acceleration', 'rad/s²', (230, 159, 0)),
}
TRUTH = (90, 90, 90)
SCREW = (204, 121, 167)
TRAIL_COLOUR = (0, 158, 115)
_LINKS = (120, 120, 130)


def vectors(twist: Array, accel: Array) -> dict[str, Array]:
    """Return the vectors of a twist and an acceleration, by the names of QUANTITIES."""
    return {'v': twist[3:], 'w': twist[:3], 'a': accel[3:], 'alpha': accel[:3]}


def round_scale(largest: float, length: float) -> float:
    """
    Return metres of arrow per unit of a quantity: 1, 2 or 5 times a power of ten.

    The largest arrow is at most ``length``, and at least two fifths of it.

    Examples
    --------
    >>> round_scale(3.0, 0.4)
    0.1

    """
    if not largest > 0:
        return length
    exact = length / largest
    power = 10.0 ** np.floor(np.log10(exact))
    return float(max(step for step in (1, 2, 5) if step * power <= exact * (1 + 1e-9)) * power)


class RobotScene:
    """The nodes of one robot in a viser scene, drawn at an offset; without meshes its skeleton."""

    def __init__(self, server: Any, motion: ShownMotion, offset: Array,
                 meshes: RobotMeshes | None) -> None:
        self._scene = server.scene
        self._motion = motion
        self._root = f'/{motion.name}'
        self._size = motion.size
        self._meshes = meshes
        self.scales: dict[str, float] = {}      # metres of arrow per unit of a quantity
        self.fit(motion.snapshots)
        self.factor = 1.0                       # by which all arrows are longer than that
        self.shown = {name: True for name in (*QUANTITIES, 'screw', 'trail', 'truth', 'frames')}
        self._nodes: dict[str, Any] = {}
        first = motion.at(0.0)
        points = np.zeros((1, 3)) if first is None else first.points
        self.middle = offset + (points.min(axis=0) + points.max(axis=0)) / 2
        self._scene.add_frame(self._root, show_axes=False, position=offset)
        for name, label in (('base', motion.robot.base_frame), ('tip', motion.robot.tip_frame)):
            self._nodes[name] = self._scene.add_frame(
                f'{self._root}/{name}', axes_length=0.12 * self._size,
                axes_radius=0.004 * self._size)
            self._scene.add_label(f'{self._root}/{name}/name', label, font_screen_scale=0.8)
        if meshes is not None:
            self._nodes['carrier'] = self._scene.add_frame(f'{self._root}/carrier',
                                                           show_axes=False)
            meshes.add_to(server, f'{self._root}/carrier/bodies')

    def fit(self, snapshots: Sequence[Snapshot]) -> bool:
        """Choose the arrows' scales for states; return whether they have changed."""
        before = dict(self.scales)
        for name in QUANTITIES:
            largest = max((float(np.linalg.norm(vectors(s.twist, s.accel)[name]))
                           for s in snapshots), default=0.0)
            wanted = round_scale(largest, 0.6 * self._size)
            present = self.scales.get(name, np.inf)
            # Shorter arrows at once, longer ones only where they had become tiny.
            if wanted < present or wanted > 4 * present:
                self.scales[name] = wanted
        return before != self.scales

    def show(self, snapshot: Snapshot) -> None:
        """Draw the robot at an instant."""
        tip = snapshot.pose[:3, 3]
        if self._meshes is not None:
            self._place('carrier', snapshot.base)
            self._meshes.move(snapshot.q)
        else:
            self._draw_lines('links', [np.stack([line[:-1], line[1:]], axis=1)
                                       for line in snapshot.skeleton], _LINKS,
                             0.018 * self._size, True)
        for name, pose in (('base', snapshot.base), ('tip', snapshot.pose)):
            self._place(name, pose)
            self._nodes[name].visible = self.shown['frames']
        measured = vectors(snapshot.twist, snapshot.accel)
        for name, quantity in QUANTITIES.items():
            self._draw_arrow(name, tip, measured[name] * self.scales[name], quantity.colour,
                             0.014, self.shown[name])
        if snapshot.exact is not None:
            for name, value in vectors(*snapshot.exact).items():
                self._draw_arrow(f'true {name}', tip, value * self.scales[name], TRUTH, 0.007,
                                 self.shown['truth'] and self.shown[name])
        self._draw_covariance(snapshot)
        self._draw_screw_axis(snapshot)
        self._draw_trail(snapshot.time)

    def arrow(self, name: str) -> Array:
        """Return begin and end of an arrow as it is drawn, shape (2, 3) [m]."""
        return np.array(self._nodes[name].points)[0]

    def _place(self, name: str, pose: Array) -> None:
        self._nodes[name].wxyz = w_first(pose[:3, :3])
        self._nodes[name].position = pose[:3, 3]

    def _draw_arrow(self, name: str, begin: Array, vector: Array, colour: Sequence[int],
                    width: float, visible: bool) -> None:
        vector = self.factor * vector
        points = np.stack([begin, begin + vector])[None].astype(np.float32)
        node = self._nodes.get(name)
        if node is None:
            node = self._nodes[name] = self._scene.add_arrows(
                f'{self._root}/{name}', points, tuple(colour),
                shaft_radius=0.8 * width * self._size, head_radius=1.8 * width * self._size,
                head_length=4 * width * self._size)
        node.points = points
        # A shorter one would be all head.
        node.visible = visible and float(np.linalg.norm(vector)) > 0.01 * self._size

    def _draw_lines(self, name: str, segments: Sequence[Array], colour: Sequence[int],
                    width: float, visible: bool) -> None:
        points = np.concatenate(segments).astype(np.float32)
        node = self._nodes.get(name)
        if node is None or len(node.points) != len(points):
            self._nodes[name] = self._scene.add_line_segments(
                f'{self._root}/{name}', points, tuple(colour), thickness=width, visible=visible)
        else:
            node.points, node.visible = points, visible

    def _draw_covariance(self, snapshot: Snapshot) -> None:
        """Draw the two-sigma ellipsoid of the linear acceleration at the head of its arrow."""
        found = None if snapshot.covariance is None else ellipsoid(snapshot.covariance)
        if found is None:
            return
        scale = self.factor * self.scales['a']
        node = self._nodes.get('covariance')
        if node is None:
            node = self._nodes['covariance'] = self._scene.add_icosphere(
                f'{self._root}/covariance', 1.0, QUANTITIES['a'].colour, opacity=0.25,
                cast_shadow=False, receive_shadow=False)
        node.wxyz = w_first(found.axes)
        node.position = snapshot.pose[:3, 3] + scale * snapshot.accel[3:]
        node.scale = tuple(np.maximum(2 * found.radii * scale, 2e-3 * self._size).tolist())
        node.visible = self.shown['a']

    def _draw_screw_axis(self, snapshot: Snapshot) -> None:
        screw = screw_of_twist(snapshot.twist)
        moving = screw.amplitude > 1e-9
        through = snapshot.pose[:3, 3] if np.isinf(screw.pitch) else (
            snapshot.pose[:3, 3] + screw.point)
        axis = screw.axis if moving else np.array([0.0, 0.0, 1.0])
        # Nearest to the base.
        middle: Array = through - axis * (axis @ (through - snapshot.base[:3, 3]))
        ends = np.stack([middle - 1.2 * self._size * axis, middle + 1.2 * self._size * axis])
        self._draw_lines('screw axis', [ends[None]], SCREW, 0.012 * self._size,
                         bool(moving and self.shown['screw']))

    def _draw_trail(self, time: float) -> None:
        points = np.array([s.pose[:3, 3] for s in self._motion.window(time, TRAIL)])
        # As many segments at every instant, so that the node stays the same.
        places = np.linspace(0, len(points) - 1, 81).round().astype(int)
        visible = self.shown['trail'] and len(points) > 1
        points = points[places] if len(points) else np.zeros((81, 3))
        self._draw_lines('trail', [np.stack([points[:-1], points[1:]], axis=1)], TRAIL_COLOUR,
                         0.006 * self._size, visible)
