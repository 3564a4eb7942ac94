# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How far the joints went since the latest reading, in ticks, by the filters that foresee them."""
from __future__ import annotations

from math import dist, hypot, sqrt

from .numbers import Row
from .tick_counter import Ticks
from ..core.bank import Bank

UNFORESEEN = 50.0
"""Acceleration of all joints together that may come from one reading to the next, rad/s^2."""

FAR = 12
"""Ticks beyond which the filters do not foresee where the joints will be."""

FEW_TICKS, LONG = 3, 0.03
"""So they do not beyond this many ticks if these take longer than this, s."""

NEXT = 0.35
"""Ticks by which joints may be from where they are foreseen for that to be of the reading."""


class Foreseen:
    """What the filters make of a position; nothing, at first."""

    def __init__(self, position: Row, near: Ticks) -> None:
        # Ticks that have passed by its stamp; the position without what only one joint tells.
        self.near, self.agreed = near, position
        # Ticks that joints travelled; their move in a tick, and what they are usually off, rad.
        self.ticks = self.length = self.usual = 0.0
        # Of the former from the ticks that passed: as usual; for an acceleration not foreseen.
        self.deviation = self.surprise = 1e3
        self.told = False       # whether the joints tell the ticks

    def far(self, age: float) -> bool:
        """Whether this is longer than the filters foresee; by the stamp it is so many seconds."""
        return self.near >= FAR or self.near > FEW_TICKS and age > LONG

    def contradicts(self, d: Ticks) -> bool:
        """Whether joints tell that so many ticks are not how far they went."""
        return self.told and abs(self.ticks - d) > NEXT

    def nearer(self, d: Ticks, span: float, unit: float) -> float:
        """Return d ticks, s, if joints are foreseen so far and it suits them better than span."""
        reaches = self.told and (
            self.near < FAR or not self.contradicts(d) and self.near > d + 1)
        return d * unit if reaches and (
            abs(d - self.ticks) * unit <= abs(span - self.ticks * unit)) else span

    def agreed_on(self, position: Row, d: Ticks) -> Row:
        """Return what joints agree on, if they were where they are foreseen d ticks later."""
        return position if abs(self.ticks - d) > NEXT else self.agreed

    def goes_on(self, position: Row, unit: float, bank: Bank) -> bool:
        """Whether a reading after a pause is the next one, late: all joints go on by a tick."""
        d = round(self.ticks)
        if not 0 < d < FEW_TICKS:
            return False
        n, state = len(position), bank.state()
        span = d * unit
        move = [span * (state[n + j] + 0.5 * span * state[2 * n + j]) for j in range(n)]
        return dist(position, [state[j] + move[j] for j in range(n)]) < (
            NEXT * hypot(*move) / d)


class Foresight:
    """
    Foresee positions, and remember how well.

    ``usual`` is what joints are usually off, rad; None while it is not known.
    """

    def __init__(self, usual: float | None = None) -> None:
        self.usual = usual

    def foresee(self, position: Row, near: Ticks, unit: float, bank: Bank) -> Foreseen:
        """Return what the filters make of a position, `near`: ticks later by its stamp."""
        foreseen = Foreseen(position, near)
        span = (near if 0 < near < FAR else 1) * unit
        foreseen.ticks, foreseen.length, foreseen.agreed = bank.travel(
            position, unit, span, UNFORESEEN)
        foreseen.usual = foreseen.length if self.usual is None else self.usual
        foreseen.deviation = max(foreseen.usual / foreseen.length, 0.15)
        foreseen.surprise = UNFORESEEN * span * span / foreseen.length
        foreseen.told = foreseen.deviation < 0.3
        return foreseen

    def learn(self, foreseen: Foreseen, d: Ticks) -> None:
        """Learn from a reading that was d ticks later."""
        usual = foreseen.usual
        off = min(abs(foreseen.ticks - d) * foreseen.length, 3.0 * usual)
        self.usual = off + 1e-9 if self.usual is None else sqrt(
            0.95 * usual * usual + 0.075 * off * off)
