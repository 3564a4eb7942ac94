# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Slow work beside the stream of messages: reading models, compiling programs."""
from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

from ..errors import ScrewKinematicsError


class Background:
    """
    Runs work in one other thread, and hands the results over where it is told to.

    The work must not touch what the node uses; what it returns takes effect only in
    :meth:`collect`, which the node's own thread calls.
    """

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(1, thread_name_prefix='compile')
        self._jobs: list[tuple[Future[Any], Callable[[Any], None],
                               Callable[[ScrewKinematicsError], None]]] = []

    def submit(self, work: Callable[[], Any], done: Callable[[Any], None],
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
        self._jobs.append((self._pool.submit(work), done, failed))

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
        self._pool.shutdown(wait=False, cancel_futures=True)
        self._jobs.clear()
