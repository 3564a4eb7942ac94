# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Slow work beside the stream of messages: reading models, compiling programs."""
from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from queue import SimpleQueue
from threading import Thread
from typing import Any

from ..errors import ScrewKinematicsError

Work = Callable[[], Any]


class Background:
    """
    Runs work in one other thread, and hands the results over where it is told to.

    The work must not touch what the node uses; what it returns takes effect only in
    :meth:`collect`, which the node's own thread calls. The end of the process does not wait
    for it: compiling may take seconds.
    """

    def __init__(self) -> None:
        self._waiting: SimpleQueue[tuple[Future[Any], Work] | None] = SimpleQueue()
        self._jobs: list[tuple[Future[Any], Callable[[Any], None],
                               Callable[[ScrewKinematicsError], None]]] = []
        # A pool of threads would be waited for.
        Thread(target=_run, args=(self._waiting,), name='compile', daemon=True).start()

    def submit(self, work: Work, done: Callable[[Any], None],
               failed: Callable[[ScrewKinematicsError], None]) -> None:
        """
        Begin some work.

        Parameters
        ----------
        work : callable
            Runs in the other thread.
        done, failed : callable
            Run in :meth:`collect`, with the result or with the error.

        """
        future: Future[Any] = Future()
        self._jobs.append((future, done, failed))
        self._waiting.put((future, work))

    def collect(self) -> None:
        """Hand over the results that are there, in the order of the work."""
        while self._jobs and self._jobs[0][0].done():
            future, done, failed = self._jobs.pop(0)
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
        self._waiting.put(None)


def _run(waiting: SimpleQueue[tuple[Future[Any], Work] | None]) -> None:
    while (job := waiting.get()) is not None:
        future, work = job
        if not future.set_running_or_notify_cancel():
            continue
        try:
            future.set_result(work())
        except Exception as error:
            future.set_exception(error)
