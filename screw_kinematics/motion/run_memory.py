# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a compiled run keeps, all in one array, because each array passed costs time.

It holds single numbers first (settings, state, and a second state to try a sample on), then
blocks, whose bounds are among the settings.
"""

from __future__ import annotations

from math import prod
from typing import Any

import numpy as np

from . import pace, sampling_clock
from .joint_motion import Array
from .velocity_evidence import ROWS

# Blocks, for n joints and M filters; the filters of a joint lie together.
(INBOX,         # the sample: whether it has velocities, stamp, positions, velocities: 2 + 2 n
 OUTBOX,        # what it leads to: positions, velocities, accelerations, jerks: 4 n
 LAST,          # positions of the latest sample, unwrapped, n
 FRESH,         # those of the sample at hand, n
 RATES,         # its velocities, 0 where not measured, n
 WRAPS,         # 1 for continuous joints, else 0, n
 FILTERS,       # state, mean squares of both innovations, weight, score: (n, M, 8)
 GAINS,         # of position 4 and velocity 4; precision and constant of both: (n, M, 12)
 CLOCK_STAMPS, CLOCK_POSITIONS,                         # (2, room), (room, n)
 TRUST_STAMPS, TRUST_POSITIONS, TRUST_VELOCITIES,       # (room,), (room, n), (room, n)
 TRUST_KNOWN,   # see `velocity_evidence.judge`
 LAG_STAMPS, LAG_STATES,        # of the samples since the delayed instant, rings: (length,), ...
 LAG_ERRORS,    # innovations of position and velocity: (2, n, M, room)
 LAG_TAPS,      # their weights: (2, n or 1, 4, M, length)
 LAG_PRODUCTS,  # scratch, (M, length)
 BLOCKS) = range(20)

# Settings; the bounds of the blocks come before them.
(N, M, CONTINUOUS, MAX_GAP, MAX_VELOCITY, MAX_JUMP,
 CLOCKED,       # whether ticks of a clock may replace the stamps
 TRUSTING,      # whether measured velocities are looked at
 RATED,         # whether the gains use some
 REFERENCE, WINDOW, RENEWAL, DELAY,
 LENGTH,        # most samples from the delayed instant to the latest
 TAP_SETS,      # 1, or n where the joints' gains differ
 STEP,          # time from the sample before to that at hand, s
 ONWARD,        # time from the sample before the delayed instant to that, s
 STATE) = range(BLOCKS + 1, BLOCKS + 19)

# State.
(STAMP, SHORTEST,       # of the guard
 INSTANT,       # stamp that is used for the latest sample
 TAKEN,         # samples
 SPAN, UNWEIGHED,       # of the bank
 CLOCK_END, TRUST_END, LAG_END,         # where the blocks are filled up to
 TRUST_JUDGED, TRUST_JUDGEMENTS,
 LAG_HEAD, LAG_COUNT,   # place of the latest sample in its ring; samples in use
 CLOCK) = range(14)
PACE = CLOCK + sampling_clock.STATES
STATES = PACE + pace.STATES

TRIAL = STATE + STATES
HEADER = TRIAL + STATES


class RunMemory:
    """
    The array of a run, and views of its parts.

    Parameters
    ----------
    n_joints, n_filters:
        Numbers of them.
    length, sets:
        Samples from the delayed instant to the latest, at most, and sets of their weights; 0
        without a delay.
    ticks, rates:
        Samples for which clock and velocity trust have room.

    """

    def __init__(
        self, n_joints: int, n_filters: int, length: int, sets: int, ticks: int, rates: int
    ) -> None:
        n, m = n_joints, n_filters
        ring, room = (length + 1, 4 * length) if length else (0, 0)
        shapes: tuple[tuple[int, ...], ...] = (
            (2 + 2 * n,), (4, n), (n,), (n,), (n,), (n,), (n, m, 8), (n, m, 12),
            (ticks, 2), (ticks, n), (rates,), (rates, n), (rates, n), (ROWS, n),
            (ring,), (ring, n, m, 4), (2, n, m, room), (2, sets, 4, m, length), (m, length))
        bounds = HEADER + np.cumsum([0, *(prod(shape) for shape in shapes)])
        self.array: Array = np.zeros(bounds[-1])
        self.array[:BLOCKS + 1] = bounds
        self.cells: Any = self.array.data
        """The numbers one by one, at less cost."""
        self.state, self.trial = self.array[STATE:TRIAL], self.array[TRIAL:HEADER]
        self._blocks = [block(self.array, i).reshape(shape) for i, shape in enumerate(shapes)]

    def __getitem__(self, which: int) -> Array:
        """Return a view of one of the blocks."""
        return self._blocks[which]

    def place(self, which: int) -> int:
        """Return where a block begins, in bytes."""
        return 8 * int(self.array[which])


def block(memory: Array, which: int) -> Array:
    """Return one of the blocks, flat."""
    part: Array = memory[int(memory[which]):int(memory[which + 1])]
    return part
