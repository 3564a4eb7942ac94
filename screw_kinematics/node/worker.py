# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Slow work beside the stream of messages: reading models, compiling programs."""
from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import count
from queue import Empty, PriorityQueue, SimpleQueue
from threading import Thread
from typing import Any

from ..errors import ScrewKinematicsError

Work = Callable[[], Any]
Done = Callable[[Any], None]
Failed = Callable[[ScrewKinematicsError], None]

_NOW, _LATER, _LAST = range(3)
_Waiting = PriorityQueue[tuple[int, int, tuple[Work, Done, Failed] | None]]
_Finished = SimpleQueue[Callable[[], None]]


class Background:
    """
    Runs work in one other thread, and hands the results over where it is told to.

    The work must not touch what the node uses; what it returns takes effect only in
    :meth:`collect`, which the node's own thread calls. The end of the process does not wait
    for it: compiling may take seconds.

    Attributes
    ----------
    pending : int
        How much work has not been handed over yet.

    """

    def __init__(self) -> None:
        self.pending = 0
        self._numbers = count()
        self._waiting: _Waiting = PriorityQueue()
        self._finished: _Finished = SimpleQueue()
        # A pool of threads would be waited for.
        Thread(target=_run, args=(self._waiting, self._finished), name='compile',
               daemon=True).start()

    def submit(self, work: Work, done: Done, failed: Failed, urgent: bool = True) -> None:
        """
        Begin some work.

        Parameters
        ----------
        work : callable
            Runs in the other thread.
        done, failed : callable
            Run in :meth:`collect`, with the result or with the error.
        urgent : bool
            Whether to do it before all that is not; else in the order of submission.

        """
        self.pending += 1
        self._waiting.put((_NOW if urgent else _LATER, next(self._numbers),
                           (work, done, failed)))

    def collect(self) -> None:
        """Hand over the results that are there, in the order in which the work was done."""
        while not self._finished.empty():
            hand_over = self._finished.get()
            self.pending -= 1
            hand_over()

    def close(self) -> None:
        """Drop all work that has not begun, and all results."""
        while True:
            try:
                self._waiting.get_nowait()
            except Empty:
                break
        self._waiting.put((_LAST, 0, None))
        self._finished = SimpleQueue()
        self.pending = 0


def _run(waiting: _Waiting, finished: _Finished) -> None:
    while (job := waiting.get()[2]) is not None:
        work, done, failed = job
        try:
            finished.put(partial(done, work()))
        except ScrewKinematicsError as error:
            finished.put(partial(failed, error))
        except Exception as error:      # of a stranger's description, it must not end the node
            finished.put(partial(failed, ScrewKinematicsError(f'{type(error).__name__}: {error}')))
