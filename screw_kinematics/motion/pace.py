# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Mean sampling period, and whether sampling is regular."""

from __future__ import annotations

from collections.abc import MutableSequence

MEMORY = 64
"""Samples over which irregularity is averaged."""

IRREGULAR = 0.25
"""Mean relative deviation from the period up to which sampling counts as regular."""

SHORT = 6e-3
"""Longest period at which gains are kept, s; at lower rates their cost does not matter."""

DRIFT = 0.04
"""Relative change of the period that makes a new reference."""


PERIOD, REFERENCE, DEVIATION, COUNT, STATES = range(5)
"""Places in the state of a `Pace`, and their number."""


class Pace:
    """
    Follow the sampling period.

    Attributes
    ----------
    state:
        Its numbers, see `follow`.

    """

    def __init__(self) -> None:
        self.start()

    def start(self) -> None:
        """Begin a run."""
        self.state = [0.0] * STATES

    @property
    def period(self) -> float:
        """Mean time between samples, s."""
        return self.state[PERIOD]

    @property
    def reference(self) -> float:
        """
        Return the period for which gains may be kept once they have converged, s; else 0.

        It is 0 while sampling is not regular, or slow. A few missing samples and jittering
        stamps do not make it so.
        """
        return self.state[REFERENCE]

    @property
    def regular(self) -> bool:
        """Whether the time between samples varies little."""
        return self.state[DEVIATION] <= IRREGULAR

    def push(self, dt: float) -> None:
        """Take the time since the last sample, s."""
        follow(self.state, dt)


def follow(state: MutableSequence[float], dt: float) -> None:
    """
    Take the time since the last sample, s.

    Written for a list, and for an array in machine code.
    """
    period = state[PERIOD]
    if period == 0.0:
        state[PERIOD] = dt
        return
    state[COUNT] = count = state[COUNT] + 1.0
    limited = dt if dt < 3 * period else 3 * period
    change = limited - period
    period += change * (0.01 if count > 100 else 1 / (count + 1))
    state[PERIOD] = period
    deviation = change / period
    if deviation < 0.0:
        deviation = -deviation
    mean = state[DEVIATION]
    state[DEVIATION] = mean = mean + (deviation - mean) / (count if count < MEMORY else MEMORY)
    if count < 16 or mean > IRREGULAR or period > SHORT:
        state[REFERENCE] = 0.0
    elif not (1 - DRIFT) * period < state[REFERENCE] < (1 + DRIFT) * period:
        state[REFERENCE] = period
