# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Slow work beside the stream of messages: reading models, compiling programs."""
from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from queue import SimpleQueue
from threading import Condition, Thread
from time import monotonic
from typing import Any

from ..errors import ScrewKinematicsError
from ..programs.checkpoint import CHECKPOINT

SHORT = 0.05
"""Work that has taken less time than this goes before all other; longer work looks so often
whether its turn has come [s]."""


@dataclass(eq=False)
class Job:
    """
    Some work, and where its result or its error go.

    ``worked`` is for how long it has been at work, but for its present turn, which began at
    ``since``; all in seconds.
    """

    key: Hashable
    work: Callable[[], Any]
    done: Callable[[Any], None]
    failed: Callable[[ScrewKinematicsError], None]
    worked: float = 0.0
    since: float | None = None

    def rank(self, now: float) -> int:
        """Return how often the time that it took has doubled since it was short."""
        turn = 0.0 if self.since is None else now - self.since
        return int((self.worked + turn) / SHORT).bit_length()


class LetGo(BaseException):
    """Ends work whose result nobody waits for any more."""


class Worker:
    """
    Runs work in other threads, and hands the results over where it is told to.

    The work must not touch what the node uses; what it returns takes effect only in
    :meth:`collect`, which the node's own thread calls. Of works with one key only the newest
    counts: an older one is let go. At their checkpoints all works wait but one, so that the
    messages have one other thread to share the interpreter with: what has taken least time so
    far goes first, of long works the oldest. The end of the process does not wait for any:
    compiling may take seconds.
    """

    def __init__(self) -> None:
        self._newest: dict[Hashable, Job] = {}
        self._at_work: list[Job] = []
        self._changed = Condition()
        self._finished: SimpleQueue[tuple[Job, Callable[..., None], Any]] = SimpleQueue()

    @property
    def pending(self) -> int:
        """How much work has not been handed over yet."""
        return len(self._newest)

    def is_at(self, key: Hashable) -> bool:
        """Return whether work for this has not been handed over yet."""
        return key in self._newest

    def submit(self, key: Hashable, work: Callable[[], Any], done: Callable[[Any], None],
               failed: Callable[[ScrewKinematicsError], None]) -> None:
        """
        Begin some work in another thread, in the place of earlier work for the same key.

        ``done`` or ``failed`` runs in :meth:`collect`, with the result or with the error.
        """
        job = Job(key, work, done, failed)
        with self._changed:
            self._newest[key] = job
            self._at_work.append(job)
            self._changed.notify_all()
        # A pool of threads would be waited for.
        Thread(target=self._work, args=(job,), name='worker', daemon=True).start()

    def cancel(self, key: Hashable) -> None:
        """Let go the work for this, if there is any."""
        with self._changed:
            self._newest.pop(key, None)
            self._changed.notify_all()

    def collect(self) -> None:
        """Hand over the results that are there, in the order in which the work was done."""
        while not self._finished.empty():
            job, hand_over, result = self._finished.get()
            if self._counts(job):
                del self._newest[job.key]
                hand_over(result)

    def close(self) -> None:
        """Let go all work."""
        with self._changed:
            self._newest.clear()
            self._changed.notify_all()

    def _counts(self, job: Job) -> bool:
        return self._newest.get(job.key) is job

    def _work(self, job: Job) -> None:
        CHECKPOINT.set(lambda: self._wait_for_turn(job))
        try:
            self._wait_for_turn(job)
            self._finished.put((job, job.done, job.work()))
        except ScrewKinematicsError as error:
            self._finished.put((job, job.failed, error))
        except Exception as error:      # of a stranger's description, it must not end the node
            self._finished.put((job, job.failed, ScrewKinematicsError(
                f'{type(error).__name__}: {error}')))
        except LetGo:
            pass
        finally:
            with self._changed:
                self._at_work.remove(job)
                self._changed.notify_all()

    def _wait_for_turn(self, job: Job) -> None:
        """Wait while other work goes first; end this work if it was let go."""
        with self._changed:
            if job.since is not None:
                job.worked += monotonic() - job.since
            job.since = None
            while self._counts(job) and not self._is_first(job):
                self._changed.notify_all()
                self._changed.wait(SHORT)
            if not self._counts(job):
                raise LetGo
            job.since = monotonic()

    def _is_first(self, job: Job) -> bool:
        """Return whether none has taken less time; one that stands still takes more and more."""
        now = monotonic()
        return job is min(filter(self._counts, self._at_work), key=lambda each: each.rank(now))
