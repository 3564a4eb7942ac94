# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What a device's clock tells of those whom it serves: what cannot be known, what is odd."""

from __future__ import annotations

from math import hypot, sqrt
from typing import NamedTuple

from .clock_error import ClockError
from .tick_counter import LONGEST, TickCounter

ENOUGH, MANY = 20, 100
"""Messages from which on it is known who reads, and from which on that is told."""

WORTH_TELLING = 1e-6
"""Stamps that jitter by less are rounded, as floats of seconds since 1970 are, s."""

HOLDS, SKIPS = 2, 0.3
"""Readings that were held, or ticks that were skipped for each reading, from which on who reads
is taken to have a clock of its own."""


class Tally(NamedTuple):
    """What messages brought: the same reading again, a new one; and ticks that none was of."""

    held: int
    fresh: int
    lost: int


def clock_error(ticks: TickCounter | None, tally: Tally, messages: float,
                doubt: float) -> ClockError:
    """
    Return what none can know of the device's time; `ticks`: None where stamps are right.

    The line through ticks and stamps ends where they are needed, known by two standard errors of
    its mean, and its slope by as many of its own. Who reads by another clock takes readings that
    are up to a period old; where both beat slowly, the joints tell the ticks, but nothing tells
    what is between. `messages`: their period, s; `doubt`: by how much the latest stamp is odd, s.
    """
    if ticks is None:
        return ClockError(doubt)
    held, fresh, lost = tally
    aged = held + fresh >= ENOUGH and (held > HOLDS or lost > SKIPS * fresh)
    # What stamps of readings that age have in common is their age, which counts below.
    line, rate = ticks.line_error() if aged else ticks.stated_error()
    time = hypot(line, doubt)
    if not aged:
        return ClockError(time, rate)
    span = max(ticks.line.ticks(), 1.0) * ticks.period
    shorter, longer = min(ticks.period, messages), max(ticks.period, messages)
    # The line through the stamps averages a beat that is faster than it is long, and leans where
    # one ends in it. Half of them are believed: where messages are lost neither period is known
    # well enough to tell few from none.
    beats = abs(longer / shorter - round(longer / shorter)) * min(span, LONGEST) / longer
    age = shorter / sqrt(12.0) / max(1.0, 0.5 * beats)
    return ClockError(hypot(time, age), hypot(rate, age / span))


def clock_doubts(ticks: TickCounter | None, tally: Tally) -> list[str]:
    """Return what is odd about when joints were read; `ticks`: None where stamps are right."""
    held, fresh, lost = tally
    if ticks is None or fresh < MANY:
        return [] if not held else [
            f'{held} of {held + fresh} messages repeat a reading while the joints move']
    repeated, skipped = held / (fresh + held), lost / (fresh + lost)
    if max(repeated, skipped) < 0.01:
        if ticks.deviation < WORTH_TELLING:
            return []
        return [f'stamps jitter by {1e3 * ticks.deviation:.2g} ms: replaced by a regular '
                f'clock of {1.0 / ticks.period:.1f} Hz']
    found = (f'read by another clock: device at {1.0 / ticks.period:.1f} Hz, readings '
             f'{2e3 * ticks.early:.1f} ms old on average')
    if repeated > 0.01:
        found += f', {100.0 * repeated:.0f} % held'
    if skipped > 0.01:
        found += f', {100.0 * skipped:.0f} % skipped'
    return [found]
