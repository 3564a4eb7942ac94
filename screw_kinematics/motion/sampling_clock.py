# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The clock behind the stamps of a periodic sampler."""

from __future__ import annotations

from collections import deque
from collections.abc import MutableSequence
import math

import numpy as np

from .bursts import BurstClock
from .joint_motion import Array

LOCK_SAMPLES = 40
"""Samples from which period and phase are first taken."""

PHASE_GAIN, PERIOD_GAIN = 0.02, 1e-4
"""Gains of the alpha-beta clock."""

BLOCK, REST, LONG_REST = 8, 0.02, 0.05
"""Samples judged together, and least time between judgements, s: of the first `FIRST_BLOCKS`,
and of later ones."""

FIRST_BLOCKS = 25

WINDOW = BLOCK + 4
"""Samples that are looked at for that."""

FOURTH, SECOND = 5, 3
"""Samples of a fourth difference, and of a second one. The latter is for bursts: the fourth
would not see that a joint runs on evenly though the stamps nearly stand still."""

_COLUMNS = {points: np.arange(points)[:, None] + np.arange(WINDOW + 1 - points)
            for points in (FOURTH, SECOND)}

ADOPT, ABANDON = 0.4, 0.7
"""Ratio of noise with regular stamps to that with given stamps below/above which to change."""


(PERIOD, FASTEST, SLOWEST, TICK, STRAYS, REGULARISED, FRESH, JUDGED, BLOCKS, NOISE_GIVEN,
 NOISE_TICKS, STATES) = range(12)
"""Places in the state of a `SamplingClock`, and their number."""


class SamplingClock:
    """
    Decide between the stamps as given and the ticks of a regular clock.

    A controller samples periodically, but its messages are often stamped on arrival, and the
    error of the stamp times the velocity is an error of position. An alpha-beta clock predicts
    the ticks. They replace the stamps while, and only while, the positions are smoother (by
    their fourth divided differences) against the ticks than against the stamps. Where samples
    arrive in bursts, the ticks are counted.

    Attributes
    ----------
    state:
        Its numbers, see `next_tick` and `decide`; the period is 0 until the clock is locked.
    samples:
        The latest samples: stamps, ticks, positions.

    """

    def __init__(self) -> None:
        self.start()

    def start(self) -> None:
        """Begin a run."""
        self.state = [0.0] * STATES
        self.state[JUDGED] = -math.inf
        self.samples: deque[tuple[float, float, Array]] = deque(maxlen=WINDOW)
        self._stamps: list[float] = []
        self._bursts: BurstClock | None = None
        self._lossy = False

    @property
    def regularised(self) -> bool:
        """Whether the ticks replace the stamps."""
        return bool(self.state[REGULARISED])

    @property
    def locked(self) -> bool:
        """Whether the ticks are known and there are samples enough to judge them."""
        return self.state[PERIOD] > 0.0 and len(self.samples) == WINDOW

    def push(self, stamp: float, position: Array) -> float:
        """Take one sample; return the stamp to use for it."""
        state = self.state
        if state[PERIOD]:
            tick = next_tick(state, stamp)
        elif self._bursts is not None:
            state[TICK] = tick = self._bursts.next_tick(stamp)
            state[FRESH] += 1.0
        else:
            self._stamps.append(stamp)
            if len(self._stamps) == LOCK_SAMPLES:
                self._lock()
            return stamp
        if tick != tick:
            lossy = self._lossy or self._bursts is not None and self._bursts.lossy
            self.start()
            self._lossy = lossy
            return stamp
        self.samples.append((stamp, tick, position))
        if due(state) and len(self.samples) == WINDOW:
            given, ticks, positions = zip(*self.samples)
            noise, moving = roughness(
                np.array((given, ticks)), np.concatenate(positions).reshape(WINDOW, -1),
                FOURTH if self._bursts is None else SECOND)
            of_stamps, of_ticks = noise.tolist()
            decide(state, of_stamps, of_ticks, moving)
        return tick if state[REGULARISED] else stamp

    def _lock(self) -> None:
        """Fit period and phase to the first stamps, allowing for missing ones."""
        t = np.array(self._stamps)
        self._bursts = None if self._lossy else BurstClock.recognise(t)
        if self._bursts is not None:
            return
        steps = np.diff(t)
        ticks = np.maximum(1, np.rint(steps / np.median(steps))).cumsum()
        period, phase = np.polyfit(ticks, t[1:], 1).tolist()
        self.state[PERIOD] = period
        self.state[FASTEST], self.state[SLOWEST] = 0.98 * period, 1.02 * period
        self.state[TICK] = phase + period * ticks[-1].item()


# The following are written for a list as the state, and for an array in machine code.


def next_tick(state: MutableSequence[float], stamp: float) -> float:
    """Return the tick of the next sample; NaN if the sampler is not periodic after all."""
    period = state[PERIOD]
    tick = state[TICK]
    passed = round((stamp - tick) / period)
    tick += passed * period if passed > 1 else period
    error = stamp - tick
    if abs(error) > 0.45 * period:
        state[STRAYS] += 1.0
        if state[STRAYS] > 5.0:
            return math.nan
    elif state[STRAYS] > 0.0:
        state[STRAYS] -= 1.0
    limit = 0.3 * period
    if not -limit <= error <= limit:
        error = math.copysign(limit, error)
    tick += PHASE_GAIN * error
    period += PERIOD_GAIN * error
    if not state[SLOWEST] >= period >= state[FASTEST]:
        period = state[SLOWEST] if period > state[SLOWEST] else state[FASTEST]
    state[TICK] = tick
    state[PERIOD] = period
    state[FRESH] += 1.0
    return tick


def due(state: MutableSequence[float]) -> bool:
    """Whether the latest samples are to be judged, if there are enough of them."""
    return state[FRESH] >= BLOCK and state[TICK] - state[JUDGED] >= (
        REST if state[BLOCKS] < FIRST_BLOCKS else LONG_REST)


def decide(state: MutableSequence[float], given: float, ticks: float, moving: int) -> None:
    """Choose ticks or stamps by what `roughness` found of them; not if no joint moved."""
    state[FRESH] = 0.0
    state[JUDGED] = state[TICK]
    if not moving:
        return
    state[BLOCKS] += 1.0
    gain = max(0.04, 1.0 / state[BLOCKS])
    state[NOISE_GIVEN] += gain * (given - state[NOISE_GIVEN])
    state[NOISE_TICKS] += gain * (ticks - state[NOISE_TICKS])
    if state[BLOCKS] >= 8.0:
        limit = ABANDON if state[REGULARISED] > 0.0 else ADOPT
        state[REGULARISED] = 1.0 if state[NOISE_TICKS] < limit * state[NOISE_GIVEN] else 0.0


def roughness(stamps: Array, positions: Array, points: int = FOURTH) -> tuple[Array, int]:
    """
    Return the mean squares of the positions' differences against two kinds of stamps.

    Parameters
    ----------
    stamps: shape (2, WINDOW)
        Two stamps of each sample, s.
    positions: shape (WINDOW, n)
        Of n joints.
    points:
        One more than the order of the differences.

    Returns
    -------
    The mean squares over the joints that move, shape (2,), and the number of these.

    """
    q = positions - positions[0]
    moving = int(np.count_nonzero(q.any(axis=0)))
    # As one product, with the differences' coefficients as the bands of two matrices. They are
    # those of `divided_difference`, found for all windows side by side, which takes half the time.
    column = _COLUMNS[points]
    row = np.arange(column.shape[1])
    t = stamps[:, column]
    c = 1.0 / np.multiply.reduce(t[:, :, None] - t[:, None] + np.eye(points)[:, :, None], axis=1)
    c /= np.sqrt(np.add.reduce(c * c, axis=1))[:, None]
    bands = np.zeros((2, len(row), WINDOW))
    bands[:, row, column] = c
    differences = bands.reshape(-1, WINDOW).dot(q).reshape(2, -1)
    squares = np.einsum('ij,ij->i', differences, differences)
    return squares / (len(row) * max(moving, 1)), moving
