# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What is shown of a robot: its state at instants, as they were recorded or as they come."""
from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ...chains.manipulator import Manipulator
from ...screws.se3 import Array


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """
    A robot at an instant.

    States are classical, about the tip, in axes of what they are relative to.
    """

    time: float                        # since the beginning [s]
    q: Array                           # (dof,), measured joints [rad, m]
    skeleton: tuple[Array, ...]        # lines of the links, (points, 3) each [m]
    pose: Array                        # (4, 4), of the tip [m]
    twist: Array                       # (6,), of the tip [rad/s, m/s]
    accel: Array                       # (6,), of the tip [rad/s^2, m/s^2]
    covariance: Array | None = None    # (3, 3), of the linear acceleration [m^2/s^4]
    exact: Array | None = None         # (2, 6), the true twist and acceleration
    base: Array = field(default_factory=lambda: np.eye(4))

    @property
    def points(self) -> Array:
        """Return the points of base and links, shape (N, 3) [m]."""
        return np.vstack([self.base[:3, 3], *self.skeleton])


@dataclass(eq=False)
class ShownMotion:
    """The snapshots of a robot, in order of time."""

    name: str
    robot: Manipulator
    snapshots: list[Snapshot] = field(default_factory=list)
    doubts: Sequence[str] = ()    # what is to be said of its joint states
    description: str = ''         # URDF text or file for meshes; or empty
    world: str = ''               # frame that a moving base moves in; or empty

    @property
    def end(self) -> float:
        """Return the time of the latest snapshot [s]."""
        return self.snapshots[-1].time if self.snapshots else 0.0

    @property
    def size(self) -> float:
        """Return how large the robot is, about [m]."""
        points = self.snapshots[0].points if self.snapshots else np.eye(3)
        return float(max(np.ptp(points, axis=0).max(), 1e-3))

    def at(self, time: float) -> Snapshot | None:
        """Return the latest snapshot up to a time, the first before all of them."""
        if not self.snapshots:
            return None
        return self.snapshots[max(self._after(time) - 1, 0)]

    def window(self, time: float, span: float) -> list[Snapshot]:
        """Return the snapshots of the span [s] up to a time."""
        return self.snapshots[self._after(time - span):self._after(time)]

    def append(self, snapshot: Snapshot, keep: float) -> None:
        """Add a snapshot that came; forget those older than ``keep`` [s]."""
        self.snapshots.append(snapshot)
        if snapshot.time - self.snapshots[0].time > 1.2 * keep:
            del self.snapshots[:self._after(snapshot.time - keep)]

    def _after(self, time: float) -> int:
        return bisect_right(self.snapshots, time, key=lambda snapshot: snapshot.time)


def moved(lines: Sequence[Array], base: Array) -> tuple[Array, ...]:
    """Return lines of points, of shape (..., points, 3) [m], as a moving base carries them."""
    turn, place = np.swapaxes(base[..., :3, :3], -1, -2), base[..., None, :3, 3]
    return tuple(line @ turn + place for line in lines)


def tip_covariance(jacobian: Array, variance: Array) -> Array:
    """
    Return the covariance of the tip's linear acceleration, of shape (..., 3, 3) [m^2/s^4].

    From the Jacobian about the tip, and the variances of the accelerations of what is in its
    columns.
    """
    linear = jacobian[..., 3:, :]
    return linear * np.asarray(variance)[..., None, :] @ np.swapaxes(linear, -1, -2)
