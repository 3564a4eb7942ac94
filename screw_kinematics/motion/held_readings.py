# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Which messages merely repeat the reading before."""

from __future__ import annotations

from math import dist, inf

from .numbers import Row
from .tick_counter import Ticks
from ..core.bank import Bank

HELD_MOST = 0.1
"""A reading that repeats for longer is of joints that stand, s."""

UNLIKELY = 5.0
"""Log odds against encoders that repeat themselves, beyond which a repetition is no reading."""

HARDEST = 100.0
"""Deceleration of joints that a reading that repeats is believed to show, rad/s^2."""


class HeldReadings:
    """
    Tell a reading that is sent again from joints that stand.

    A reading that repeats is a held one for as long as readings have been held before, or, the
    first time, where the joints went on too fast to have stopped.

    The run begins with a reading of a stamp, s, and a position, rad or m.
    """

    def __init__(self, stamp: float, position: Row, hold: float = 0.0,
                 quantum: float = inf) -> None:
        # For how long readings are held, as far as it is known, s; the smallest step of a joint
        # that was seen, infinite if there was none.
        self.hold, self.quantum = hold, quantum
        self.standing = False
        """Whether the reading repeats although the joints cannot have stopped."""
        self._same = 0
        # Of the latest reading: when it came; the one before, and for how long that was held.
        self._came = stamp
        self._before: Row | None = None
        self._ran = 0.0
        # Three readings, and the ticks between them.
        self._position = self._one_ago = self._two_ago = position
        self._ticks = self._ticks_before = 1

    def repeats(self, stamp: float, age: float, foreseen: float, unit: float,
                bank: Bank | None) -> bool:
        """
        Take a reading that is the same as before; return whether it is but sent again.

        It is sent at the stamp, ``age`` after it was taken for a reading; ``unit`` is a tick, all
        s. ``foreseen`` is the length of the joints' move in a tick, by the filters of the bank,
        which is None while they have not settled.
        """
        self._same += 1
        since = stamp - self._came
        self.standing = bank is not None and (
            self.standing or self._stands(since, foreseen, unit, bank))
        return age < 1.3 * self.hold or self.standing and since < HELD_MOST

    def moved(self, stamp: float, position: Row, ticks: Ticks, learn: bool) -> None:
        """Take another reading, so many ticks later; `learn`: how far joints step at least."""
        self.standing = False
        if learn or self._same or self._ran > 0.0:
            self._follow(stamp, position)
        self._came, self._before = stamp, self._position
        self._two_ago, self._one_ago, self._position = self._one_ago, self._position, position
        self._ticks_before, self._ticks = self._ticks, ticks

    def stopped(self, position: Row) -> None:
        """Know that the joints have stopped for good."""
        self.standing = False
        self._one_ago = self._two_ago = self._position = position
        self._ticks = self._ticks_before = 1

    def _stands(self, since: float, foreseen: float, unit: float, bank: Bank) -> bool:
        """
        Whether a reading that repeats cannot be a new one: joints do not stop so fast.

        They had gone on evenly up to it, as far as the encoder can tell, and would have moved on
        by many of its steps since then.
        """
        gone = dist(self._position, self._one_ago) / self._ticks
        before = dist(self._one_ago, self._two_ago) / self._ticks_before
        step = self.quantum if self.quantum < inf else 0.0
        return (gone + step > 0.8 * before > 0.0 and foreseen + step > 0.5 * gone
                and foreseen > HARDEST * (since - 1.1 * unit) * unit
                and bank.odds_against_repeating(since) > UNLIKELY)

    def _follow(self, stamp: float, position: Row) -> None:
        """Learn for how long readings are held that repeat and then go on as before."""
        moved, before = self._position, self._before
        move = [a - b for a, b in zip(position, moved)]
        sizes = [abs(m) for m in move]
        self.quantum = min(self.quantum, min(size for size in sizes if size > 0.0))
        run = stamp - self._came
        if before is not None and max(sizes) > 4.0 * self.quantum:
            old = [a - b for a, b in zip(moved, before)]
            along = sum(a * b for a, b in zip(move, old))
            both = dist(position, moved) * dist(moved, before)
            if along > 0.8 * both and self._same > 0:
                self.hold = max(0.98 * self.hold, min(run, self._ran))
            else:
                self.hold *= 0.98
        self._ran = run if self._same > 0 else 0.0
        self._same = 0
