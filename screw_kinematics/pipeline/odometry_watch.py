# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether the poses and twists of odometry tell of one motion, as no single message shows."""
from __future__ import annotations

import numpy as np

from ..messages.base_motion import BaseSample
from ..screws.rotations import rotation_from_quaternion
from ..screws.se3 import Array

INTERVAL_NS = 200_000_000
"""Poses so far apart in time are compared [ns]."""

MOVED = 0.02
"""If they are so far apart in space [m]."""

ENOUGH = 5.0
"""So many intervals tell, later ones more than earlier ones."""

FORGET = 0.9


class OdometryWatch:
    """Compares steps of the pose with the integral of the twist, in the axes of either frame."""

    def __init__(self) -> None:
        self._begin: tuple[int, Array] | None = None
        self._last_ns = 0
        self._own, self._turned = np.zeros(3), np.zeros(3)
        self._count = self._way = self._off_own = self._off_turned = 0.0

    def update(self, sample: BaseSample) -> None:
        """Take a sample that has a pose."""
        position = np.array(sample.position)
        dt = (sample.stamp_ns - self._last_ns) * 1e-9
        self._last_ns = sample.stamp_ns
        if self._begin is None or not 0 < dt < INTERVAL_NS * 1e-9:
            self._start(sample.stamp_ns, position)
            return
        linear = np.array(sample.twist[3:])
        self._own += dt * rotation_from_quaternion(np.array(sample.quaternion)) @ linear
        self._turned += dt * linear
        before, start = self._begin
        if sample.stamp_ns - before >= INTERVAL_NS:
            self._compare(position - start)
            self._start(sample.stamp_ns, position)

    def findings(self) -> list[str]:
        """Return what is wrong, in sentences."""
        if self._count < ENOUGH or self._off_own < 0.25 * self._way:
            return []
        if self._off_turned < 0.1 * self._off_own:
            return ['the twist of the base is in the axes of the world, not of the moving frame']
        return ['the twist of the base does not tell how its pose moves']

    def _start(self, stamp_ns: int, position: Array) -> None:
        self._begin = stamp_ns, position
        self._own, self._turned = np.zeros(3), np.zeros(3)

    def _compare(self, step: Array) -> None:
        if max(np.abs(step).max(), np.abs(self._own).max()) < MOVED:
            return
        self._count = FORGET * self._count + 1
        self._way = FORGET * self._way + float(step @ step)
        self._off_own = FORGET * self._off_own + float(((step - self._own)**2).sum())
        self._off_turned = FORGET * self._off_turned + float(((step - self._turned)**2).sum())
