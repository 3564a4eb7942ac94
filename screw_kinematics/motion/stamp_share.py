# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How much of what stamps deviate from their ticks is true."""

from __future__ import annotations

from math import inf

BLOCK = 12
"""Readings from which it is found at a time."""

KNOWN = 25
"""Blocks from which on it is known, and changes slowly."""


class StampShare:
    """
    The share of the stamps' deviation from the ticks that makes the positions smoothest.

    The regression of the fourth differences of positions against ticks on those of velocity
    times deviation: 0 for late arrival, 1 for a sampler that wobbles and knows it.
    """

    def __init__(self) -> None:
        self.blocks = 0
        """Blocks of readings that have told of it."""
        self._cross = self._of_stamps = self._of_all = 0.0

    def learn(self, cross: float, of_stamps: float, of_all: float) -> float | None:
        """
        Take in a block of readings; return the share, None while it is not well known.

        The sums are as `Readings.regress` has them.
        """
        if not (-inf < cross < inf and -inf < of_stamps < inf and -inf < of_all < inf):
            return None
        self.blocks += 1
        new = max(1.0 / KNOWN, 1.0 / self.blocks)
        self._cross += new * (cross - self._cross)
        self._of_stamps += new * (of_stamps - self._of_stamps)
        self._of_all += new * (of_all - self._of_all)
        if not self._of_stamps > 0.0:
            return None
        best = self._cross / self._of_stamps
        left = max(self._of_all - best * self._cross, 0.0)
        few = self.blocks <= 4      # these can tell the extremes only
        if left >= 0.5 * self._of_stamps * min(self.blocks, KNOWN) or few and (
                0.25 <= best <= 0.8):
            return None
        if best < 0.1 or few and best < 0.25:
            return 0.0
        return 1.0 if best > 0.8 else best
