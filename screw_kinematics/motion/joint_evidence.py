# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What the joints tell of a device's ticks: which these are, and how much of stamps is true."""
from __future__ import annotations

from copy import copy
from math import dist, inf
from typing import NamedTuple

from .first_ticks import count_by
from .numbers import Row
from .stamp_share import BLOCK, KNOWN, StampShare
from .tick_counter import TickCounter
from ..core.period_search import PeriodSearch
from ..core.readings import Readings

Replay = list[tuple[float, Row]]
"""Readings and their times."""

WINDOW = 40
"""Readings that are searched for a period."""

LONG_WINDOW = 30
"""Readings that move from which on a search that finds nothing need not soon be repeated."""

ADOPT = 12.0
"""Log likelihood ratio from which on another counting of ticks is adopted."""

STEPS = 2.5
"""Steps of the encoder that joints move in a tick, at least, for positions to tell ticks."""


class Recount(NamedTuple):
    """
    Other ticks, of which the latest readings are found to be.

    `ticks` counts on; `move` is how far the joints go in a tick, rad; `first` the stamp of the
    first of these readings, s; `replay` are they.
    """

    ticks: TickCounter
    move: float
    first: float
    replay: Replay


class JointEvidence:
    """
    The latest readings by their ticks and deviations, and what their positions tell of both.

    Every some readings they are asked how much of the stamps' deviation from the ticks is true
    (`StampShare`), and, ever more seldom, whether the joints went more smoothly by other ticks
    (`PeriodSearch`).
    """

    def __init__(self, n_joints: int) -> None:
        self._readings = Readings(n_joints, WINDOW)
        self._search = PeriodSearch(self._readings)
        self.start()

    def forget(self) -> None:
        """Know no readings, and nothing of the stamps."""
        self._readings.clear()
        self._share = StampShare()
        self._rest, self._wait, self._patience = 8, 0.0, 1.0

    def start(self, known: JointEvidence | None = None) -> None:
        """Begin a run; what `known` has been told of the stamps is known at once."""
        self._tick = self._deviation = 0.0      # of the latest reading
        self._new = 0
        self.forget()
        if known is not None:
            self._share = copy(known._share)

    def pause(self) -> None:
        """Know no readings: those to come are not to be compared with them."""
        self._readings.clear()
        self._new = 0

    def advance(self, d: float, step: float) -> None:
        """Let ticks go on, and the deviation of the stamps, s."""
        self._tick += d
        self._deviation += step

    def add(self, stamp: float, time: float, position: Row) -> None:
        """Add a reading of the present tick, by its stamp and its time, s."""
        self._readings.add(self._tick, self._deviation, stamp, time, position)

    def count_first(self, ticks: TickCounter, last: float) -> None:
        """Put the readings so far on the first ticks; `last`: the latest stamp, s."""
        readings, phase, period = self._readings, ticks.phase, ticks.period
        rows = [readings.at(i) for i in range(readings.number())]
        for i, (k, (*_, stamp, time)) in enumerate(zip(
                count_by(phase, period, [row[2] for row in rows], 0), rows)):
            readings.place(i, k, stamp - phase - k * period, time)
        self._tick, self._deviation = 0.0, last - phase

    def due(self) -> bool:
        """Know of another reading; return whether there are enough of them to be asked."""
        self._new += 1
        if self._new < self._rest or self._readings.number() < BLOCK:
            return False
        self._new = 0
        return True

    def coarsen(self, ticks: TickCounter) -> int:
        """Let ticks be longer if all steps were multiples, of late and long before; by what."""
        common = self._readings.divisor(BLOCK)
        if common < 2 or (
                sum(w for d, w in ticks.often.items() if d % common) > 1e-3 * ticks.total):
            return 1
        ticks.coarsen(common)
        self._readings.rescale(self._tick, common)
        self._tick = 0.0
        return common

    def regress(self, period: float) -> tuple[float, float, float]:
        """Return what the latest readings tell of their deviations; zeros while joints rest."""
        return self._readings.regress(BLOCK, period)

    def share(self, regression: tuple[float, float, float]) -> float | None:
        """Return how much of the stamps' deviation is true; None while it is not well known."""
        return self._share.learn(*regression)

    def wait(self, unit: float, eager: bool) -> bool:
        """
        Choose when to ask the joints again; return whether it is time to search.

        `unit`: a tick, s; `eager`: whether they may soon tell what is not known yet.
        """
        readings = self._readings
        if self._share.blocks >= KNOWN:
            self._rest = max(8, min(64, int(0.05 / unit)))
        else:
            slow = readings.at(-1)[2] - readings.at(-BLOCK)[2] > 0.06
            self._rest = 4 if eager and slow else 8
        self._wait -= 1.0
        return self._wait <= 0.0

    def by_ticks(self, unit: float, scale: float) -> Replay | None:
        """Return the readings by ticks of a unit and a share of their deviations."""
        return self._readings.by_ticks(self._readings.at(-1)[3], unit, scale)

    def by_stamps(self, time: float) -> Replay | None:
        """Return the readings by their stamps, the latest at a time; None if they are few."""
        return self._readings.by_stamps(time) if self._readings.number() >= BLOCK else None

    def search(self, ticks: TickCounter, quantum: float) -> Recount | None:
        """
        Try other countings of the latest readings; return one that is proven.

        `quantum`: the encoder's step, rad; infinite if it is not known.
        """
        readings = self._readings
        number = self._search.since_moving()
        if number < BLOCK:
            return None
        if number >= LONG_WINDOW:
            self._wait = self._patience
            self._patience = min(1.5 * self._patience, 40.0)
        readings.drop(readings.number() - number)
        found = self._search.search(ticks.deviation, ticks.period)
        if found is None or found[0] < ADOPT:
            return None
        _, numbers, at_zero, slope, deviation = found
        move = dist(readings.position(number - 1), readings.position(0)) / numbers[-1]
        if move < STEPS * quantum < inf:
            return None     # what looks like ticks are the encoder's steps
        stamps = [readings.at(i)[2] for i in range(number)]
        new = ticks.recounted(numbers, stamps, at_zero, slope, deviation)
        self._share, self._rest, self._wait = StampShare(), 8, 0.0
        return Recount(new, move, stamps[0], self._place(numbers, at_zero, slope, new.period))

    def _place(self, numbers: list[float], at_zero: float, slope: float,
               period: float) -> Replay:
        """Put the readings on other ticks, the latest where it is; return them."""
        readings, last, latest = self._readings, numbers[-1], self._readings.at(-1)[3]
        replay = []
        for i, k in enumerate(numbers):
            self._deviation = readings.at(i)[2] - (at_zero + slope * k)
            time = latest + (k - last) * period
            readings.place(i, k, self._deviation, time)
            replay.append((time, readings.position(i)))
        self._tick = last
        return replay
