# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What a recording says of a robot's motion, in numbers that can be added up."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .states import RecordedRobot, StateBlock
from ..chains.freedom import freedom_of
from ..chains.serial_chain import SerialChain
from ..programs.program import Program
from ..screws.se3 import Array

EDGES = np.logspace(-5, 4, 361)
"""Bounds of the classes of speeds and accelerations: 40 a decade, so quantiles to 3 %."""

NEAR_SINGULAR = 0.05
"""Ratio of the least to the greatest singular value of the Jacobian; lengths by the arm's size."""

CLASSES = len(EDGES) - 1

_SINGULAR_PERIOD = 50_000_000      # so often the Jacobian is looked at [ns]
_POINTS = 500                      # of a path and of a history
_SLOW = 0.01                       # [m/s]: below, there is nothing to stop


@dataclass
class MotionSummary:
    """
    Speeds, accelerations, workspace and odd moments of a tip, relative to what its states are.

    Speed, turning (the angular speed) and acceleration (the linear one) are seconds by class;
    peaks are largest values and when [ns], low and high bounds of the positions [m]. The path is
    of some positions; the history of stretches: time since the start, largest speed and
    acceleration. Stops are hard ones: when [ns], and how hard. Seconds near a singularity are
    NaN where that is not known.
    """

    seconds: float = 0.0
    speed: Any = field(default_factory=lambda: np.zeros(CLASSES))
    turning: Any = field(default_factory=lambda: np.zeros(CLASSES))
    acceleration: Any = field(default_factory=lambda: np.zeros(CLASSES))
    peaks: dict[str, tuple[float, int]] = field(default_factory=dict)
    low: Any = field(default_factory=lambda: np.full(3, np.inf))
    high: Any = field(default_factory=lambda: np.full(3, -np.inf))
    path: list[tuple[float, float, float]] = field(default_factory=list)
    history: list[tuple[float, float, float]] = field(default_factory=list)
    near_singular: float = 0.0
    stops: list[tuple[int, float]] = field(default_factory=list)

    def merge(self, other: MotionSummary) -> None:
        """Add what another recording says."""
        self.seconds += other.seconds
        self.near_singular += other.near_singular
        for name in ('speed', 'turning', 'acceleration'):
            setattr(self, name, getattr(self, name) + np.array(getattr(other, name)))
        for name, peak in other.peaks.items():
            self.peaks[name] = max(self.peaks.get(name, peak), peak, key=lambda p: p[0])
        self.low = np.minimum(self.low, other.low)
        self.high = np.maximum(self.high, other.high)
        self.stops = self.stops + other.stops

    def quantile(self, name: str, share: float) -> float:
        """Return the value below which a quantity is for a share of the time."""
        seconds = np.array(getattr(self, name))
        if not seconds.sum():
            return float('nan')
        reached = np.cumsum(seconds) / seconds.sum()
        return float(np.sqrt(EDGES[:-1] * EDGES[1:])[np.searchsorted(reached, share)])


class Summarizer:
    """Sums up the states of one robot in one recording; a hard stop exceeds the limit [m/s^2]."""

    def __init__(self, robot: RecordedRobot, stop_limit: float) -> None:
        self.summary = MotionSummary()
        self._tip = robot.at_tip('pose', 'twist', 'accel')
        self._max_gap = float(robot.settings.motion.options['max_gap'])
        self._stop_limit = stop_limit
        self._start: int | None = None
        self._looked = -2**62
        self._stopping = False
        self._stride, self._stretch = 1, 0.02
        self._passed = 0
        self._jacobian: Program | None = None
        if isinstance(robot.model, SerialChain):
            self._jacobian = robot.model.compile(('jacobian',))
            self._freedom = freedom_of(robot.model)
        else:
            self.summary.near_singular = float('nan')

    def add(self, block: StateBlock) -> None:
        """Take the states of a block, in order; positions, velocities and accelerations."""
        found, stamps = self.summary, block.stamps
        states = self._tip(block)
        position, twist, accel = states['pose'][:, :3], states['twist'], states['accel']
        steps = np.diff(stamps, append=stamps[-1:]) * 1e-9
        period = float(np.median(steps[:-1])) if len(steps) > 1 else 0.0
        steps = np.where((steps > self._max_gap) | (steps <= 0), period, steps)
        speed, turning = (np.linalg.norm(twist[:, part], axis=1)
                          for part in (slice(3, 6), slice(0, 3)))
        acceleration = np.linalg.norm(accel[:, 3:], axis=1)
        found.seconds += float(steps.sum())
        for name, values in (('speed', speed), ('turning', turning),
                             ('acceleration', acceleration)):
            getattr(found, name)[:] += np.bincount(class_of(values), steps, CLASSES)
            at = int(values.argmax())
            peak = float(values[at]), int(stamps[at])
            found.peaks[name] = max(found.peaks.get(name, peak), peak, key=lambda p: p[0])
        found.low = np.minimum(found.low, position.min(axis=0))
        found.high = np.maximum(found.high, position.max(axis=0))
        self._start = int(stamps[0]) if self._start is None else self._start
        self._keep_path(position)
        self._keep_history((stamps - self._start) * 1e-9, speed, acceleration)
        self._find_stops(stamps, twist[:, 3:], accel[:, 3:], speed)
        self._find_singularities(stamps, block.motion[0], period)

    def _keep_path(self, position: Array) -> None:
        path = self.summary.path
        path.extend(map(tuple, position[-self._passed % self._stride::self._stride].tolist()))
        self._passed += len(position)
        while len(path) > 2 * _POINTS:
            path[:] = path[::2]
            self._stride *= 2

    def _keep_history(self, time: Array, speed: Array, acceleration: Array) -> None:
        history = self.summary.history
        stretches = (time // self._stretch).astype(int)
        for stretch in np.unique(stretches).tolist():
            inside = stretches == stretch
            history.append((stretch * self._stretch, float(speed[inside].max()),
                            float(acceleration[inside].max())))
        while len(history) > 2 * _POINTS:
            history[:] = [(a[0], max(a[1], b[1]), max(a[2], b[2]))
                          for a, b in zip(history[::2], history[1::2])]
            self._stretch *= 2

    def _find_stops(self, stamps: Array, velocity: Array, acceleration: Array,
                    speed: Array) -> None:
        slowing = -(velocity * acceleration).sum(axis=1) / np.maximum(speed, _SLOW)
        hard = slowing > self._stop_limit
        for at in np.flatnonzero(hard).tolist():
            if not self._stopping:
                self.summary.stops.append((int(stamps[at]), float(slowing[at])))
            elif slowing[at] > self.summary.stops[-1][1]:
                self.summary.stops[-1] = int(stamps[at]), float(slowing[at])
            self._stopping = at + 1 < len(hard) and bool(hard[at + 1])
        self._stopping = bool(hard[-1])

    def _find_singularities(self, stamps: Array, position: Array, period: float) -> None:
        if self._jacobian is None:
            return
        looks = []
        for at in np.searchsorted(stamps, np.arange(
                max(self._looked + _SINGULAR_PERIOD, int(stamps[0])), int(stamps[-1]) + 1,
                _SINGULAR_PERIOD)).tolist():
            if stamps[at] >= self._looked + _SINGULAR_PERIOD // 2:
                looks.append(at)
                self._looked = int(stamps[at])
        if looks:
            rows = self._jacobian.batch(position[looks])['jacobian']
            jacobians = rows.reshape(len(looks), 6, -1).copy()
            jacobians[:, 3:] /= self._freedom.size
            values = np.linalg.svd(jacobians, compute_uv=False)
            near = values[:, self._freedom.rank - 1] < NEAR_SINGULAR * values[:, 0]
            each = max(_SINGULAR_PERIOD * 1e-9, period)
            self.summary.near_singular += float(near.sum()) * each


def class_of(values: Array) -> Array:
    """Return the class of each value; those beyond the bounds are of the first or the last."""
    return np.clip(np.searchsorted(EDGES, values, side='right') - 1, 0, CLASSES - 1)
