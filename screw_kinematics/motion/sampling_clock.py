# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The clock behind the stamps of a periodic sampler."""

from __future__ import annotations

from collections import deque
import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from screw_kinematics.motion.divided_difference import divided_difference
from screw_kinematics.motion.joint_motion import Array

LOCK_SAMPLES = 40
"""Samples from which period and phase are first taken."""

PHASE_GAIN, PERIOD_GAIN = 0.02, 1e-4
"""Gains of the alpha-beta clock."""

BLOCK, REST = 8, 0.02
"""Samples judged together, and least time between judgements, s."""

ADOPT, ABANDON = 0.4, 0.7
"""Ratio of noise with regular stamps to that with given stamps below/above which to change."""


class SamplingClock:
    """
    Decide between the stamps as given and the ticks of a regular clock.

    A controller samples periodically, but its messages are often stamped on arrival, and the
    error of the stamp times the velocity is an error of position. An alpha-beta clock predicts
    the ticks. They replace the stamps while, and only while, the positions are smoother (by
    their fourth divided differences) against the ticks than against the stamps.

    Attributes
    ----------
    regularised:
        Whether the ticks replace the stamps.

    """

    def __init__(self) -> None:
        self.start()

    def start(self) -> None:
        """Begin a run."""
        self.regularised = False
        self._stamps: list[float] = []
        self._period = 0.0
        self._nominal = 0.0
        self._tick = math.nan
        self._strays = 0
        self._samples: deque[tuple[float, float, Array]] = deque(maxlen=BLOCK + 4)
        self._fresh = 0
        self._judged = -math.inf
        self._blocks = 0
        self._noise = np.zeros(2)

    def push(self, stamp: float, position: Array) -> float:
        """Take one sample; return the stamp to use for it."""
        if math.isnan(self._tick):
            self._stamps.append(stamp)
            if len(self._stamps) == LOCK_SAMPLES:
                self._lock()
            return stamp
        tick = self._advance(stamp)
        if tick is None:
            self.start()
            return stamp
        self._samples.append((stamp, tick, position))
        self._fresh += 1
        if self._fresh >= BLOCK and tick - self._judged >= REST and (
                len(self._samples) == BLOCK + 4):
            self._fresh = 0
            self._judged = tick
            self._judge()
        return tick if self.regularised else stamp

    def _lock(self) -> None:
        """Fit period and phase to the first stamps, allowing for missing ones."""
        t = np.array(self._stamps)
        steps = np.diff(t)
        ticks = np.maximum(1, np.rint(steps / np.median(steps))).cumsum()
        period, phase = np.polyfit(ticks, t[1:], 1)
        self._period = self._nominal = float(period)
        self._tick = float(phase + period * ticks[-1])

    def _advance(self, stamp: float) -> float | None:
        """Return the tick of the sample; None if the sampler is not periodic after all."""
        period = self._period
        tick = self._tick + max(1, round((stamp - self._tick) / period)) * period
        error = stamp - tick
        if abs(error) > 0.45 * period:
            self._strays += 1
            if self._strays > 5:
                return None
        elif self._strays:
            self._strays -= 1
        error = max(-0.3 * period, min(0.3 * period, error))
        self._tick = tick = tick + PHASE_GAIN * error
        period += PERIOD_GAIN * error
        self._period = max(0.98 * self._nominal, min(1.02 * self._nominal, period))
        return tick

    def _judge(self) -> None:
        given, ticks, positions = zip(*self._samples)
        q = np.array(positions)
        moving = (q != q[0]).any(axis=0)
        if not moving.any():
            return
        q = sliding_window_view(q[:, moving] - q[0, moving], 5, axis=0)
        noise = [
            np.einsum('wi,wni->wn', divided_difference(sliding_window_view(t, 5)), q)
            for t in (np.array(given), np.array(ticks))]
        self._blocks += 1
        gain = max(0.04, 1.0 / self._blocks)
        self._noise += gain * (np.array([np.mean(x * x) for x in noise]) - self._noise)
        if self._blocks >= 8:
            limit = ABANDON if self.regularised else ADOPT
            self.regularised = bool(self._noise[1] < limit * self._noise[0])
