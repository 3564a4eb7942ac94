# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures for RViz and Foxglove: arrows at the tip, its trail, the instantaneous screw axis."""
from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
import math
from typing import Any

from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import Point, Vector3
import numpy as np
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from ..pipeline.ellipsoids import Ellipsoid, TipEllipsoids
from ..pipeline.kinematics import State
from ..pipeline.message_writers import JointColumns, Slices
from ..pipeline.outputs import KINDS
from ..pipeline.settings import RobotSettings
from ..screws.body_state import BodyState
from ..screws.rigid import pose_from_row
from ..screws.rotations import quaternion_from_rotation
from ..screws.screw import screw_of_twist
from ..screws.se3 import Array

SECOND = 1_000_000_000

ARROWS = {'angular_velocity': 0.2, 'linear_velocity': 0.5,
          'angular_acceleration': 0.05, 'linear_acceleration': 0.1}
"""How long the arrows are [m per rad/s, m/s, rad/s^2, m/s^2]."""

REST = 1e-4
"""Below this many rad/s and m/s there is no axis to speak of."""

FAR = 100.0
"""An axis further from the tip than this [m] is that of a translation."""

HALF_AXIS = 0.5                # m
SHAFT = 0.01                   # m
TRAIL = 3.0                    # s

_COLORS = {
    'linear_velocity': (0.1, 0.7, 0.2), 'angular_velocity': (0.1, 0.4, 0.9),
    'linear_acceleration': (0.9, 0.5, 0.1), 'angular_acceleration': (0.8, 0.2, 0.7),
    'screw_axis': (0.9, 0.9, 0.1), 'pitch': (1.0, 1.0, 1.0), 'trail': (0.0, 0.6, 0.5)}

CLEAR = 0.35
"""How much of what is behind an ellipsoid it hides."""


class MarkerPublisher:
    """Publishes the markers of one robot, in its base frame, at a bounded rate."""

    order = KINDS['markers'].order

    def __init__(self, publish: Callable[[MarkerArray], None], slices: Slices,
                 settings: RobotSettings, frame_id: str, joints: JointColumns) -> None:
        self._publish = publish
        self._slices = [slices[need] for need in KINDS['markers'].needs]
        self._axes, self._pole = settings.expressed_in, settings.reference_point
        self._frame_id = frame_id
        self._deviations = settings.markers_deviations
        self._ellipsoids = (TipEllipsoids(slices, settings, joints) if self._deviations
                            else None)
        self._period_ns = round(SECOND / settings.markers_rate)
        # Viewers drop the markers after this time without new ones.
        lifetime = settings.stale_timeout
        self._lifetime = Duration(sec=int(lifetime), nanosec=int(lifetime % 1 * SECOND))
        self._last_ns = -self._period_ns
        self._trail: deque[tuple[int, Point]] = deque()

    def publish(self, state: State) -> None:
        """Publish the markers of this instant, unless the last ones are too fresh."""
        stamp_ns = state.stamp_ns
        if 0 <= stamp_ns - self._last_ns < self._period_ns:
            return
        if not 0 <= stamp_ns - self._last_ns < TRAIL * SECOND:
            self._trail.clear()
        self._last_ns = stamp_ns
        body = self._body(state)
        markers = [*markers_of_state(body), self._trail_to(stamp_ns, body.pose[:3, 3])]
        if self._ellipsoids is not None:
            markers += markers_of_uncertainty(body, self._ellipsoids.of(state, body),
                                              self._deviations)
        for marker in markers:
            marker.header.frame_id = self._frame_id
            marker.header.stamp = Time(sec=stamp_ns // SECOND, nanosec=stamp_ns % SECOND)
            marker.lifetime = self._lifetime
        self._publish(MarkerArray(markers=markers))

    def clear(self) -> None:
        """Delete the markers of this robot."""
        self._trail.clear()
        marker = Marker(action=Marker.DELETEALL)
        marker.header.frame_id = self._frame_id
        self._publish(MarkerArray(markers=[marker]))

    def _trail_to(self, stamp_ns: int, tip: Array) -> Marker:
        """Return the tip's way in the last seconds."""
        self._trail.append((stamp_ns, _point(tip)))
        while stamp_ns - self._trail[0][0] > TRAIL * SECOND:
            self._trail.popleft()
        if len(self._trail) < 2:
            return _deleted('trail')
        marker = _marker('trail', Marker.LINE_STRIP)
        marker.points = [point for _, point in self._trail]
        marker.scale = Vector3(x=SHAFT / 2)
        return marker

    def _body(self, state: State) -> BodyState:
        """Return the motion of the tip, about itself, in base axes."""
        row, twist, accel = (np.array(state.values[part]) for part in self._slices)
        pose = pose_from_row(row)
        pole = pose[:3, 3] if self._pole == 'tip' else np.zeros(3)
        return BodyState(pose, (twist, accel), pole, pole=self._pole, axes=self._axes
                         ).expressed_in('base').about('tip')


def markers_of_state(state: BodyState) -> list[Marker]:
    """
    Return arrows at the tip and the screw axis, in base axes; what does not apply is deleted.

    Velocity and acceleration are about the tip, in base axes; namespaces are the names of the
    quantities.
    """
    tip = state.pose[:3, 3]
    return [*(_arrow(name, tip, vector) for name, vector in _vectors(state).items()),
            *_screw_axis(tip, state.velocity)]


def markers_of_uncertainty(state: BodyState, ellipsoids: Iterable[Ellipsoid | None],
                           deviations: float) -> list[Marker]:
    """
    Return ellipsoids at the heads of the arrows, to their scale; what is not known is deleted.

    The arrows are those of the state, about the tip, in base axes; four ellipsoids are in the
    order of `ARROWS`, and their radii are so many standard deviations.
    """
    return [_ellipsoid(name, state.pose[:3, 3] + vector, ellipsoid, deviations * ARROWS[name])
            for (name, vector), ellipsoid in zip(_vectors(state).items(), ellipsoids)]


def _vectors(state: BodyState) -> dict[str, Array]:
    """Return the arrows, from the tip on [m]."""
    values = np.concatenate([state.classical(1), state.classical(2)]).reshape(4, 3)
    return {name: scale * value for (name, scale), value in zip(ARROWS.items(), values)}


def _ellipsoid(name: str, centre: Array, ellipsoid: Ellipsoid | None, scale: float) -> Marker:
    if ellipsoid is None:
        return _deleted(f'{name}_uncertainty')
    marker = _marker(name, Marker.SPHERE)
    marker.ns, marker.color.a = f'{name}_uncertainty', CLEAR
    marker.pose.position = _point(centre)
    orientation = marker.pose.orientation
    orientation.x, orientation.y, orientation.z, orientation.w = quaternion_from_rotation(
        ellipsoid.axes).tolist()
    # Viewers warn of a diameter of zero.
    x, y, z = np.maximum(2.0 * scale * ellipsoid.radii, 1e-6).tolist()
    marker.scale = Vector3(x=x, y=y, z=z)
    return marker


def _screw_axis(tip: Array, twist: Array) -> Iterable[Marker]:
    if np.abs(twist).max() < REST:
        return _deleted('screw_axis'), _deleted('pitch')
    screw = screw_of_twist(twist)
    foot = tip + screw.point    # the point of the axis nearest to the tip
    pitch = float(screw.pitch)
    if math.isinf(pitch) or float(np.linalg.norm(screw.point)) > FAR:
        foot, text = tip, 'translation'
    elif abs(pitch) < 1e-6:
        text = 'rotation'
    else:
        text = f'pitch {pitch:.4g} m/rad'
    axis = _marker('screw_axis', Marker.LINE_LIST)
    axis.points = [_point(foot - HALF_AXIS * screw.axis), _point(foot + HALF_AXIS * screw.axis)]
    axis.scale = Vector3(x=SHAFT / 2)
    label = _marker('pitch', Marker.TEXT_VIEW_FACING)
    label.pose.position = _point(foot + HALF_AXIS * screw.axis)
    label.scale = Vector3(z=0.06)
    label.text = text
    return axis, label


def _arrow(name: str, start: Array, vector: Array) -> Marker:
    if not np.abs(vector).max() > 1e-6:
        return _deleted(name)
    marker = _marker(name, Marker.ARROW)
    marker.points = [_point(start), _point(start + vector)]
    marker.scale = Vector3(x=SHAFT, y=2 * SHAFT, z=3 * SHAFT)
    return marker


def _marker(name: str, kind: int) -> Marker:
    red, green, blue = _COLORS[name]
    marker = Marker(ns=name, type=kind, action=Marker.ADD,
                    color=ColorRGBA(r=red, g=green, b=blue, a=1.0))
    marker.pose.orientation.w = 1.0
    return marker


def _deleted(name: str) -> Marker:
    return Marker(ns=name, action=Marker.DELETE)


def _point(p: Array) -> Any:
    x, y, z = p.tolist()
    return Point(x=x, y=y, z=z)
