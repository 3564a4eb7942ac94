# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Smoothing of one block of recorded samples, in whatever process."""
from __future__ import annotations

from collections import Counter
from collections.abc import Callable
import time
from typing import NamedTuple, Protocol

import numpy as np

from ..motion.smoother import smooth
from ..screws.se3 import Array

LEAST = 8
"""Samples that a run must have."""


class RawBlock(NamedTuple):
    """
    Samples of joints that come together, with what the block shares with its neighbours.

    Attributes
    ----------
    stamps, received : array of int, shape (N,)
        Of the samples, and when they came [ns].
    positions, velocities : array, shape (N, n)
        As measured; NaN where not measured. No velocities: None.
    begin, end : int
        The samples that are the block's own.
    continuous : tuple of bool
        Whether positions wrap at 2 pi.
    max_gap : float
        A longer pause begins a new run [s].
    order : int
        Highest derivative wanted, at most 4.

    """

    stamps: Array
    received: Array
    positions: Array
    velocities: Array | None
    begin: int
    end: int
    continuous: tuple[bool, ...]
    max_gap: float
    order: int


class SmoothedBlock(NamedTuple):
    """
    Smoothed motion of joints that come together.

    Attributes
    ----------
    stamps, received : array of int, shape (N,)
        The instants, and when their samples came [ns].
    motion : array, shape (order + 1, N, n)
        Positions, velocities, ... [rad or m, per s to the power of the derivative].
    run : array of int, shape (N,)
        Number of the run each belongs to: nothing is known between two runs.

    """

    stamps: Array
    received: Array
    motion: Array
    run: Array


class Result(NamedTuple):
    """A smoothed block, the samples it could not use, by reason, and the time it took [s]."""

    block: SmoothedBlock | None
    refused: Counter[str]
    seconds: float


class Smoothing(Protocol):
    """What smooths blocks: some processes, of which there are so many."""

    processes: int

    def submit(self, raw: RawBlock) -> Callable[[], Result]:
        """Begin to smooth a block; return a function that waits for the result."""


def smooth_block(raw: RawBlock) -> Result:
    """Smooth a block; return its own part."""
    clock = time.perf_counter()
    own = slice(raw.begin, raw.end)
    refused: Counter[str] = Counter()
    used: Array = np.all(np.isfinite(raw.positions), axis=1)
    refused['position_not_finite'] += int((~used[own]).sum())
    finite = np.flatnonzero(used)
    if len(finite) < LEAST:
        refused['run_too_short'] += int(used[own].sum())
        return Result(None, refused, time.perf_counter() - clock)
    start = raw.stamps[finite[0]]
    motion = smooth((raw.stamps[finite] - start) * 1e-9, raw.positions[finite],
                    None if raw.velocities is None else raw.velocities[finite],
                    continuous=raw.continuous, max_gap=raw.max_gap)
    chosen = finite[motion.used]
    inside: Array = (chosen >= raw.begin) & (chosen < raw.end)
    refused['out_of_order_or_outlier'] += int(used[own].sum() - inside.sum())
    derivatives = [motion.position, motion.velocity, motion.acceleration, motion.jerk]
    if raw.order > 3:
        # The smoothed motion has a third derivative; the fourth is its slope.
        derivatives.append(np.gradient(motion.jerk, motion.stamps, axis=0))
    steps = np.diff(motion.stamps)
    run = np.concatenate([[0], np.cumsum((steps > raw.max_gap) | (steps < 0))])
    block = SmoothedBlock(
        start + np.rint(motion.stamps[inside] * 1e9).astype(np.int64),
        raw.received[chosen[inside]],
        np.array([x[inside] for x in derivatives[:raw.order + 1]]), run[inside])
    return Result(block, refused, time.perf_counter() - clock)
