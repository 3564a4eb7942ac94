# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Smoothing of one block of recorded samples, here or in another process."""
from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
import multiprocessing
import os
import time
from types import TracebackType
from typing import NamedTuple

import numpy as np

from .processes import end_with_parent
from ..motion.smoother import smooth
from ..se3 import Array

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


class Smoothing:
    """
    Smooths blocks in other processes, or here if there is to be one process only.

    Parameters
    ----------
    processes : int
        How many of them.

    Attributes
    ----------
    helped : int
        How many had been started, known at the end.

    """

    def __init__(self, processes: int) -> None:
        self.processes = processes
        self.helped = 0
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> Smoothing:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 traceback: TracebackType | None) -> None:
        if self._pool is not None:
            self.helped = self.processes
            self._pool.shutdown(cancel_futures=True)

    def submit(self, raw: RawBlock) -> Callable[[], Result]:
        """Begin to smooth a block; return a function that waits for the result."""
        if self.processes < 2:
            result = smooth_block(raw)
            return lambda: result
        if self._pool is None:
            # Started when the first block is full: short recordings need no processes.
            self._pool = ProcessPoolExecutor(
                self.processes, multiprocessing.get_context('spawn'),
                end_with_parent, (os.getpid(),))
        future: Future[Result] = self._pool.submit(smooth_block, raw)
        return future.result
