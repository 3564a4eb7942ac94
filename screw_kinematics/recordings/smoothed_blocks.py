# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Recorded joint samples, smoothed in overlapping blocks that fit into memory."""
from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from .blocks import LEAST, RawBlock, Result, SmoothedBlock, Smoothing
from .stage_times import StageTimes

BLOCK = 6_400
"""Samples that are smoothed at a time, without what they share with their neighbours."""

CONTEXT = 0.5
"""How far a block reaches into its neighbours [s]; smoothed values depend on less."""


class SmoothedBlocks:
    """
    Samples of joints that come together, in the order they came.

    Parameters
    ----------
    continuous : sequence of bool
        For each joint whether its position wraps at 2 pi.
    order : int
        Highest derivative wanted, at most 4.
    max_gap : float
        A longer pause begins a new run [s].
    use_velocity : bool
        Whether measured velocities may help.
    smoothing : Smoothing
        Where blocks are smoothed.
    stages : StageTimes
        Gets the time spent.

    Attributes
    ----------
    refused : Counter
        Samples that were not used, by reason.

    """

    def __init__(self, continuous: Sequence[bool], order: int, max_gap: float,
                 use_velocity: bool, smoothing: Smoothing, stages: StageTimes) -> None:
        self.refused: Counter[str] = Counter()
        self._continuous = tuple(continuous)
        self._order = order
        self._max_gap = max_gap
        self._use_velocity = use_velocity
        self._smoothing = smoothing
        self._stages = stages
        self._stamps: list[int] = []
        self._received: list[int] = []
        self._positions: list[Sequence[float]] = []
        self._velocities: list[Sequence[float]] = []
        self._missing = (float('nan'),) * len(continuous)
        self._begin = 0    # how many of the samples are context, smoothed before
        self._runs = 0
        self._waiting: deque[Callable[[], Result]] = deque()

    def add(self, stamp: int, received: int, position: Sequence[float],
            velocity: Sequence[float] | None) -> Iterator[SmoothedBlock]:
        """
        Take a sample; yield what is smoothed by now.

        Parameters
        ----------
        stamp, received : int
            Of the measurement, and when it came [ns].
        position : sequence of n float
            Positions [rad, m].
        velocity : sequence of n float, optional
            Velocities [rad/s, m/s].

        """
        self._stamps.append(stamp)
        self._received.append(received)
        self._positions.append(position)
        measured = velocity if self._use_velocity else None
        self._velocities.append(self._missing if measured is None else measured)
        count = len(self._stamps)
        if count - self._begin >= BLOCK and count % 256 == 0:
            context = self._context()
            if count - self._begin - context >= BLOCK:
                self._submit(count - context, context)
        # As many again as there are processes may wait, so that none is idle.
        while len(self._waiting) > 2 * self._smoothing.processes:
            yield from self._oldest()

    def finish(self) -> Iterator[SmoothedBlock]:
        """Yield the rest."""
        if self._stamps:
            self._submit(len(self._stamps), 0)
        while self._waiting:
            yield from self._oldest()

    def _context(self) -> int:
        """Return how many samples cover the context, at the pace of the latest ones."""
        steps = np.diff(np.array(self._stamps[-1000:], dtype=np.int64))
        period = float(np.median(steps[steps > 0])) * 1e-9 if (steps > 0).any() else CONTEXT
        return min(max(int(CONTEXT / period), LEAST), BLOCK)

    def _submit(self, end: int, context: int) -> None:
        """Have all that is there smoothed; keep what the next block needs beside its own."""
        velocities = np.array(self._velocities)
        self._waiting.append(self._smoothing.submit(RawBlock(
            np.array(self._stamps, dtype=np.int64), np.array(self._received, dtype=np.int64),
            np.array(self._positions, dtype=float),
            velocities if np.isfinite(velocities).any() else None, self._begin, end,
            self._continuous, self._max_gap, self._order)))
        keep = max(end - context, 0)
        self._begin = end - keep
        for samples in (self._stamps, self._received, self._positions, self._velocities):
            del samples[:keep]    # type: ignore[attr-defined]

    def _oldest(self) -> Iterator[SmoothedBlock]:
        """Wait for the oldest block and yield it."""
        block, refused, seconds = self._waiting.popleft()()
        self._stages.add('smooth', seconds)
        self.refused.update(refused)
        if block is not None and len(block.run):
            # A run may go on in the next block, where its number is 0.
            yield block._replace(run=block.run + self._runs)
            self._runs += int(block.run[-1])
