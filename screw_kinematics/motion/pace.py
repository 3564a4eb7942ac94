# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Mean sampling period, and whether sampling is regular."""

from __future__ import annotations

MEMORY = 64
"""Samples over which irregularity is averaged."""

IRREGULAR = 0.25
"""Mean relative deviation from the period up to which sampling counts as regular."""

SHORT = 6e-3
"""Longest period at which gains are kept, s; at lower rates their cost does not matter."""

DRIFT = 0.04
"""Relative change of the period that makes a new reference."""


class Pace:
    """
    Follow the sampling period.

    Attributes
    ----------
    period:
        Mean time between samples, s.
    reference:
        The period for which gains may be kept once they have converged, s; 0 while sampling is
        not regular, or slow. A few missing samples and jittering stamps do not make it so.

    """

    def __init__(self) -> None:
        self.start()

    def start(self) -> None:
        """Begin a run."""
        self.period = 0.0
        self.reference = 0.0
        self._deviation = 0.0
        self._count = 0

    @property
    def regular(self) -> bool:
        """Whether the time between samples varies little."""
        return self._deviation <= IRREGULAR

    def push(self, dt: float) -> None:
        """Take the time since the last sample, s."""
        period = self.period
        if not period:
            self.period = dt
            return
        self._count = count = self._count + 1
        limited = dt if dt < 3 * period else 3 * period
        change = limited - period
        period += change * (0.01 if count > 100 else 1 / (count + 1))
        self.period = period
        deviation = change / period
        if deviation < 0.0:
            deviation = -deviation
        self._deviation += (deviation - self._deviation) / (count if count < MEMORY else MEMORY)
        if count < 16 or self._deviation > IRREGULAR or period > SHORT:
            self.reference = 0.0
        elif not (1 - DRIFT) * period < self.reference < (1 + DRIFT) * period:
            self.reference = period
