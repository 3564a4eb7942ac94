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
    A robot at an instant: classical states about the tip, in axes of what they are relative to.

    Parameters
    ----------
    time : float
        Since the beginning [s].
    q : array, shape (dof,)
        Positions of the measured joints [rad, m].
    skeleton : tuple of array, shape (points, 3)
        Lines of its links [m].
    pose : array, shape (4, 4)
        Of the tip [m].
    twist, accel : array, shape (6,)
        Of the tip [rad/s, m/s; rad/s^2, m/s^2].
    covariance : array, shape (3, 3), optional
        Of the linear acceleration [m^2/s^4].
    exact : array, shape (2, 6), optional
        The true twist and acceleration, where they are known.
    base : array, shape (4, 4)
        Pose of a moving base [m].

    """

    time: float
    q: Array
    skeleton: tuple[Array, ...]
    pose: Array
    twist: Array
    accel: Array
    covariance: Array | None = None
    exact: Array | None = None
    base: Array = field(default_factory=lambda: np.eye(4))

    @property
    def points(self) -> Array:
        """Return the points of base and links, shape (N, 3) [m]."""
        return np.vstack([self.base[:3, 3], *self.skeleton])


@dataclass(eq=False)
class ShownMotion:
    """
    The snapshots of a robot, in order.

    Parameters
    ----------
    name : str
        Of the robot.
    robot : SerialChain or ParallelManipulator
        Its model.
    snapshots : list of Snapshot
        In the order of their times.
    doubts : sequence of str
        What is to be said of its joint states.
    description : str
        URDF text or file from which meshes may be taken; empty: none.
    world : str
        Frame that a moving base moves in; empty: the base stands.

    """

    name: str
    robot: Manipulator
    snapshots: list[Snapshot] = field(default_factory=list)
    doubts: Sequence[str] = ()
    description: str = ''
    world: str = ''

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
    """
    Return lines of points as a moving base carries them.

    Parameters
    ----------
    lines : sequence of array, shape (..., points, 3)
        In base coordinates [m].
    base : array, shape (..., 4, 4)
        Pose of the base [m].

    Returns
    -------
    tuple of array, shape (..., points, 3)
        Where the base is given [m].

    """
    turn, place = np.swapaxes(base[..., :3, :3], -1, -2), base[..., None, :3, 3]
    return tuple(line @ turn + place for line in lines)


def tip_covariance(jacobian: Array, variance: Array) -> Array:
    """
    Return the covariance of the tip's linear acceleration from that of the joints'.

    Parameters
    ----------
    jacobian : array, shape (..., 6, n)
        Pole at the tip.
    variance : array, shape (..., n)
        Of the accelerations of joints, and of a moving base.

    Returns
    -------
    array, shape (..., 3, 3)
        [m^2/s^4]

    """
    linear = jacobian[..., 3:, :]
    return linear * np.asarray(variance)[..., None, :] @ np.swapaxes(linear, -1, -2)
