# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Blocks of recorded samples smoothed in several processes."""
from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
import multiprocessing
import os
from types import TracebackType

from ..processes import end_with_parent
from ...recordings.blocks import RawBlock, Result, smooth_block


class SmoothingPool:
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

    def __enter__(self) -> SmoothingPool:
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
