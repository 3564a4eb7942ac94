# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Slow work beside the stream of messages: reading models, compiling programs."""
from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from itertools import count
from queue import PriorityQueue
from threading import Thread
from typing import Any

from ..errors import ScrewKinematicsError

Work = Callable[[], Any]
_Queue = PriorityQueue[tuple[int, int, Future[Any], Work | None]]
_NOW, _LATER, _LAST = range(3)


class Background:
    """
    Runs work in one other thread, and hands the results over where it is told to.

    The work must not touch what the node uses; what it returns takes effect only in
    :meth:`collect`, which the node's own thread calls. The end of the process does not wait
    for it: compiling may take seconds.
    """

    def __init__(self) -> None:
        self._waiting: _Queue = PriorityQueue()
        self._numbers = count()
        self._jobs: list[tuple[Future[Any], Callable[[Any], None],
                               Callable[[ScrewKinematicsError], None]]] = []
        # A pool of threads would be waited for.
        Thread(target=_run, args=(self._waiting,), name='compile', daemon=True).start()

    def submit(self, work: Work, done: Callable[[Any], None],
               failed: Callable[[ScrewKinematicsError], None], urgent: bool = True) -> None:
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
        future: Future[Any] = Future()
        self._jobs.append((future, done, failed))
        self._waiting.put((_NOW if urgent else _LATER, next(self._numbers), future, work))

    def collect(self) -> None:
        """Hand over the results that are there, in the order of submission."""
        for job in [job for job in self._jobs if job[0].done()]:
            self._jobs.remove(job)
            future, done, failed = job
            error = future.exception()
            if error is None:
                done(future.result())
            elif isinstance(error, ScrewKinematicsError):
                failed(error)
            else:   # of a stranger's description, it must not end the node
                failed(ScrewKinematicsError(f'{type(error).__name__}: {error}'))

    def close(self) -> None:
        """Drop all work that has not begun."""
        for future, _, _ in self._jobs:
            future.cancel()
        self._jobs.clear()
        self._waiting.put((_LAST, 0, Future(), None))


def _run(waiting: _Queue) -> None:
    while True:
        _, _, future, work = waiting.get()
        if work is None:
            return
        if not future.set_running_or_notify_cancel():
            continue
        try:
            future.set_result(work())
        except Exception as error:
            future.set_exception(error)
