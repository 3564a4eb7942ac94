# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Slow work beside the stream of messages: reading models, compiling programs."""
from __future__ import annotations

from collections.abc import Callable, Hashable
from queue import SimpleQueue
from threading import Lock, Thread
from typing import Any, NamedTuple

from ..errors import ScrewKinematicsError

THREADS = 4
"""How much work is done at a time; so much that takes for ever does not hold up the rest."""


class Job(NamedTuple):
    """Some work, and where its result or its error go."""

    key: Hashable
    work: Callable[[], Any]
    done: Callable[[Any], None]
    failed: Callable[[ScrewKinematicsError], None]


class Worker:
    """
    Runs work in other threads, and hands the results over where it is told to.

    The work must not touch what the node uses; what it returns takes effect only in
    :meth:`collect`, which the node's own thread calls. Of works with one key only the newest
    counts: an older one is let go. The end of the process does not wait for any: compiling may
    take seconds.
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._running = 0
        self._waiting: list[Job] = []
        self._newest: dict[Hashable, Job] = {}
        self._finished: SimpleQueue[tuple[Job, Callable[..., None], Any]] = SimpleQueue()

    @property
    def pending(self) -> int:
        """How much work has not been handed over yet."""
        return len(self._newest)

    def submit(self, key: Hashable, work: Callable[[], Any], done: Callable[[Any], None],
               failed: Callable[[ScrewKinematicsError], None]) -> None:
        """
        Begin some work.

        Parameters
        ----------
        key : hashable
            What it is for: it takes the place of earlier work for the same.
        work : callable
            Runs in another thread.
        done, failed : callable
            One of them runs in :meth:`collect`, with the result or with the error.

        """
        job = self._newest[key] = Job(key, work, done, failed)
        with self._lock:
            self._waiting.append(job)
            if self._running == THREADS:
                return
            self._running += 1
        # A pool of threads would be waited for.
        Thread(target=self._work, name='worker', daemon=True).start()

    def cancel(self, key: Hashable) -> None:
        """Let go the work for this, if there is any."""
        self._newest.pop(key, None)

    def collect(self) -> None:
        """Hand over the results that are there, in the order in which the work was done."""
        while not self._finished.empty():
            job, hand_over, result = self._finished.get()
            if self._newest.get(job.key) is job:
                del self._newest[job.key]
                hand_over(result)

    def close(self) -> None:
        """Let go all work."""
        self._newest.clear()

    def _work(self) -> None:
        while True:
            with self._lock:
                if not self._waiting:
                    self._running -= 1
                    return
                job = self._waiting.pop()       # the newest first
            if self._newest.get(job.key) is not job:
                continue
            try:
                self._finished.put((job, job.done, job.work()))
            except ScrewKinematicsError as error:
                self._finished.put((job, job.failed, error))
            except Exception as error:      # of a stranger's description, it must not end the node
                self._finished.put((job, job.failed, ScrewKinematicsError(
                    f'{type(error).__name__}: {error}')))
