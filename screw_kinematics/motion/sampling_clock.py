# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The clock behind the stamps of a periodic sampler."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
import math

import numpy as np

from .divided_difference import divided_difference
from .joint_motion import Array

LOCK_SAMPLES = 40
"""Samples from which period and phase are first taken."""

PHASE_GAIN, PERIOD_GAIN = 0.02, 1e-4
"""Gains of the alpha-beta clock."""

BLOCK, REST = 8, 0.02
"""Samples judged together, and least time between judgements, s."""

_ROW = np.arange(BLOCK)[:, None]
_COLUMN = _ROW + np.arange(5)

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
    roughness:
        The function of that name, or its compiled twin.

    """

    def __init__(self) -> None:
        self.roughness: Callable[[Array, Array], tuple[Array, int]] = roughness
        self.start()

    def start(self) -> None:
        """Begin a run."""
        self.regularised = False
        self._stamps: list[float] = []
        self._period = 0.0
        self._fastest = self._slowest = 0.0
        self._tick = math.nan
        self._strays = 0
        self._samples: deque[tuple[float, float, Array]] = deque(maxlen=BLOCK + 4)
        self._fresh = 0
        self._judged = -math.inf
        self._blocks = 0
        self._noise = np.zeros(2)

    def push(self, stamp: float, position: Array) -> float:
        """Take one sample; return the stamp to use for it."""
        if not self._period:
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
        if (tick - self._judged >= REST and self._fresh >= BLOCK
                and len(self._samples) == BLOCK + 4):
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
        self._period = float(period)
        self._fastest, self._slowest = 0.98 * self._period, 1.02 * self._period
        self._tick = float(phase + period * ticks[-1])

    def _advance(self, stamp: float) -> float | None:
        """Return the tick of the sample; None if the sampler is not periodic after all."""
        period = self._period
        tick = self._tick
        passed = round((stamp - tick) / period)
        tick += passed * period if passed > 1 else period
        error = stamp - tick
        if abs(error) > 0.45 * period:
            self._strays += 1
            if self._strays > 5:
                return None
        elif self._strays:
            self._strays -= 1
        limit = 0.3 * period
        if not -limit <= error <= limit:
            error = math.copysign(limit, error)
        self._tick = tick = tick + PHASE_GAIN * error
        period += PERIOD_GAIN * error
        if not self._slowest >= period >= self._fastest:
            period = self._slowest if period > self._slowest else self._fastest
        self._period = period
        return tick

    def _judge(self) -> None:
        given, ticks, positions = zip(*self._samples)
        noise, moving = self.roughness(np.array((given, ticks)), np.array(positions))
        if not moving:
            return
        self._blocks += 1
        gain = max(0.04, 1.0 / self._blocks)
        self._noise += gain * (noise - self._noise)
        if self._blocks >= 8:
            limit = ABANDON if self.regularised else ADOPT
            self.regularised = bool(self._noise[1] < limit * self._noise[0])


def roughness(stamps: Array, positions: Array) -> tuple[Array, int]:
    """
    Return the mean squares of the positions' fourth differences against two kinds of stamps.

    Parameters
    ----------
    stamps: shape (2, BLOCK + 4)
        Two stamps of each sample, s.
    positions: shape (BLOCK + 4, n)
        Of n joints.

    Returns
    -------
    The mean squares over the joints that move, shape (2,), and the number of these.

    """
    q = positions - positions[0]
    moving = int(np.count_nonzero(q.any(axis=0)))
    # As one product, with the differences' coefficients as the bands of two matrices.
    bands = np.zeros((2, BLOCK, BLOCK + 4))
    bands[:, _ROW, _COLUMN] = divided_difference(stamps[:, _COLUMN])
    differences = bands.reshape(-1, BLOCK + 4).dot(q).reshape(2, -1)
    return (differences * differences).sum(axis=1) / (BLOCK * max(moving, 1)), moving
