# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Samples that were taken regularly, but arrive, and are stamped, several at once."""

from __future__ import annotations

import math

import numpy as np

from .joint_motion import Array

CLOSE, APART = 0.2, 1.5
"""Steps of stamps within a burst are shorter, those between bursts longer than this multiple of
the mean step."""

PATIENCE, PARDON = 3.0, 0.02
"""How many incomplete bursts are borne; each complete one makes good for that share of one."""

PHASE_GAIN, PERIOD_GAIN = 0.1, 1e-3
"""Gains of the alpha-beta clock; it is corrected once in a burst."""


class BurstClock:
    """
    Counts the ticks of samples that arrive in bursts of one size.

    The last sample of a burst is the fresh one, and its stamp shows what time it is; the others
    were taken a period apart before it.

    Parameters
    ----------
    size:
        Samples in a burst.
    period:
        Time between ticks, s.
    tick, stamp:
        Of the latest sample, s.
    count:
        How many samples of the latest burst have arrived.

    """

    def __init__(self, size: int, period: float, tick: float, stamp: float, count: int) -> None:
        self.size = size
        self._period = self._mean_period = period
        self._tick = tick
        self._stamp = stamp
        self._count = count
        self._incomplete = 0.0

    @property
    def lossy(self) -> bool:
        """
        Whether samples are lost too often.

        Which one of a burst is missing cannot be known, and a wrong tick now and then does more
        harm than stamps that are always as wrong.
        """
        return self._incomplete > PATIENCE

    @classmethod
    def recognise(cls, stamps: Array) -> BurstClock | None:
        """
        Return a clock if the stamps come in bursts, else None.

        Parameters
        ----------
        stamps: shape (N,)
            Increasing, s.

        """
        steps = np.diff(stamps)
        mean = steps.mean()
        pause = steps > APART * mean
        first = np.flatnonzero(pause) + 1
        if len(first) < 4 or not (pause | (steps < CLOSE * mean)).all():
            return None
        sizes = np.diff(first)
        size = int(np.median(sizes))
        if size < 2 or (sizes != size).any():
            return None
        last = stamps[first - 1]
        spacing, phase = np.polyfit(np.arange(len(last)), last, 1).tolist()
        count = len(stamps) - int(first[-1])
        period = spacing / size
        tick = phase + spacing * (len(last) - 1) + count * period
        return cls(size, period, tick, float(stamps[-1]), count)

    def next_tick(self, stamp: float) -> float:
        """Return the tick of the next sample; NaN if the bursts have ended."""
        step, self._stamp = stamp - self._stamp, stamp
        if step < 0.5 * self.size * self._period:
            self._count += 1
            self._tick += self._period
            return self._tick if self._count <= 2 * self.size else math.nan
        # Before a new burst: set the clock by the last sample of the one before. What is missing
        # of it was lost, and so are bursts that should have come meanwhile.
        lost = -self._count % self.size
        self._incomplete = self._incomplete + 1.0 if lost else max(0.0, self._incomplete - PARDON)
        error = stamp - step - self._tick - lost * self._period
        spacing = self.size * self._period
        if abs(error) > spacing or self.lossy:
            return math.nan
        lost += self.size * max(0, round(step / spacing) - 1)
        error = min(max(error, -0.5 * self._period), 0.5 * self._period)
        period = self._period + PERIOD_GAIN * error
        self._period = min(max(period, 0.98 * self._mean_period), 1.02 * self._mean_period)
        self._tick += (1 + lost) * self._period + PHASE_GAIN * error
        self._count = 1
        return self._tick
