# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The first ticks of a device, from the first stamps alone."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate

from .tick_counter import TickCounter
from ..core.robust_line import Line

FIRST = 20
"""Messages from which a first period is taken."""

PAUSE, ALIKE = 8.0, 1.5
"""Steps of the first stamps, in periods, beyond which they tell nothing of the period; unless the
longest is no longer than so many times the shortest of them: messages come in bursts."""

EVEN, FASTEST = 0.25, 1e-4
"""Deviation of three of four steps from multiples, in periods, up to which longer ones are taken
for these; and what a device's period is never below, s: messages that are closer came at once."""

LATEST, IRREGULAR = 1e-2, 0.3
"""Mean deviation of the first stamps from a line, s and in periods, beyond which they are of no
clock: readings come when they come."""


class FirstTicks:
    """
    Take one tick for each stamp, or as many as their steps if these are near multiples.

    Parameters
    ----------
    stamp : float
        Of the reading that the run begins with, s.

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
        period = by_length[len(steps) // 2]
        pauses = [k for k, step in enumerate(steps, start=1) if step > PAUSE * period]
        if pauses and (len(pauses) == 1 or by_length[-1] > ALIKE * by_length[-len(pauses)]):
            self._stamps = stamps[pauses[-1]:]
            return None
        numbers = [float(number) for number in accumulate(_ticks(steps, period), initial=0)]
        line = Line(FIRST)
        last = numbers[-1]
        for number, each in zip(numbers, stamps):
            line.add(number - last, each)
        phase, period, deviation = line.fit(0.0)
        if period < FASTEST or deviation > max(LATEST, IRREGULAR * period):
            self._stamps = stamps[FIRST // 2:]
            return None
        ticks = TickCounter(phase, period, FIRST, max(deviation, 1e-4 * period))
        for number, each in zip(numbers, stamps):
            ticks.line.add(number - last, each)
        return ticks


def _ticks(steps: Sequence[float], period: float) -> list[int]:
    """Return how many ticks each step is: multiples of the period, or one where they are none."""
    if period > FASTEST:
        ticks = [max(1, round(step / period)) for step in steps]
        apart = sorted(abs(step - period * d) for step, d in zip(steps, ticks))
        if apart[3 * len(apart) // 4] < EVEN * period:
            return ticks
    return [1] * len(steps)
