# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The first ticks of a device, from the first stamps alone."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate
from math import gcd, log

from .tick_counter import PAIRS, TickCounter
from ..core.robust_line import Line

FIRST = 20
"""Messages from which a first period is taken."""

PAUSE, ALIKE = 8.0, 1.5
"""Steps of the first stamps, in periods, beyond which they tell nothing of the period; unless the
longest is no longer than so many times the shortest of them: messages come in bursts."""

FASTEST = 1e-4
"""What a device's period is never below, s: messages that are closer came at once."""

TURNS, FINEST = 3, 1e-6
"""How often ticks are counted by the line through those counted before; and the deviation from a
line below which none is better than another, s."""

LATEST, IRREGULAR = 1e-2, 0.3
"""Mean deviation of the first stamps from a line, s and in periods, beyond which they are of no
clock: readings come when they come."""


class FirstTicks:
    """
    Take one tick for each stamp, or as many as tell the stamps more shortly.

    Which ticks were skipped takes words, as any surprise does; how far the stamps are from the
    line through their ticks takes others (minimum description length).

    The first stamp, s, is of the reading that the run begins with.
    """

    def __init__(self, stamp: float) -> None:
        self._stamps = [stamp]

    def add(self, stamp: float) -> TickCounter | None:
        """Add the stamp of a reading; return who counts on, once there are enough."""
        self._stamps = stamps = [*self._stamps[1 - FIRST:], stamp]
        if len(stamps) < FIRST or stamp - stamps[-2] < FASTEST:
            return None
        steps = [b - a for a, b in zip(stamps, stamps[1:])]
        by_length = sorted(steps)
        step = by_length[len(steps) // 2]
        pauses = [k for k, other in enumerate(steps, start=1) if other > PAUSE * step]
        if pauses and (len(pauses) == 1 or by_length[-1] > ALIKE * by_length[-len(pauses)]):
            self._stamps = stamps[pauses[-1]:]
            return None
        least, ticks = _told(range(FIRST), stamps)
        for unit in (step, 0.5 * step):
            numbers = list(accumulate((round(step / unit) or 1 for step in steps), initial=0))
            for _ in range(TURNS):
                words, other = _told(numbers, stamps)
                if other.period < FASTEST:
                    break
                if words < least:
                    least, ticks = words, other
                numbers = count_by(other.phase, other.period, stamps, FIRST)
        if ticks.period < FASTEST or ticks.deviation > max(LATEST, IRREGULAR * ticks.period):
            self._stamps = stamps[FIRST // 2:]
            return None
        return ticks


def _told(numbers: Sequence[int], stamps: Sequence[float]) -> tuple[float, TickCounter]:
    """Return the words, of a nat, that tell stamps by these ticks; and who counts on."""
    longest = gcd(*(number - numbers[0] for number in numbers))
    line = Line(PAIRS)
    for number, stamp in zip(numbers, stamps):
        line.add((number - numbers[-1]) / longest, stamp)
    phase, period, deviation = line.fit(0.0)
    ticks = TickCounter(phase, period, FIRST, max(deviation, 1e-4 * period))
    ticks.line = line
    words = FIRST * log(max(deviation, FINEST))
    for a, b in zip(numbers, numbers[1:]):
        words += ticks.surprise((b - a) // longest)
        ticks.note((b - a) // longest)
    return words, ticks


def count_by(phase: float, period: float, stamps: Sequence[float], last: int) -> list[int]:
    """
    Return the ticks, from that of a phase on, of stamps, none later than the last one.

    As stamps are late rather than early, each is of a tick before that of the next one.
    """
    numbers = []
    for stamp in reversed(stamps):
        numbers.append(min(round((stamp - phase) / period), last))
        last = numbers[-1] - 1
    return numbers[::-1]
