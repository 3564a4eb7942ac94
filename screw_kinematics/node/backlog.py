# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Messages that wait, on any topic, are worked through before anything is published.

Every call of the middleware takes from the processor's caches what the next message needs: one
message after the other costs less than half of what each costs between such calls. For the same
reason those of one robot are taken in a row.
"""
from __future__ import annotations

from time import perf_counter
from typing import Protocol

LONGEST = 5e-4
"""For so long [s] messages that wait are worked through before their outputs are published."""

MOST = 10
"""So many messages of a topic are, at most: the usual queue of who listens holds as many."""

LOOK_EVERY = 7
"""Where none wait, it is looked for some after so many messages: to find none costs a little."""


class Queue(Protocol):
    """Messages of one topic, and what they lead to."""

    def take_waiting(self, most: int, end: float) -> int:
        """Take messages that wait, at most so many and until a time [s]; return how many."""

    def publish(self) -> None:
        """Publish what the messages taken have led to."""


class Backlog:
    """The queues of a node."""

    def __init__(self) -> None:
        self.queues: list[Queue] = []
        self._taken: list[Queue] = []
        self._until_look = 0

    def work_off(self, first: Queue) -> None:
        """Take messages that wait, from one queue after the other, beginning with the first."""
        self._until_look -= 1
        if self._until_look > 0:
            return
        end = perf_counter() + LONGEST
        start, looked, found = self.queues.index(first), 0, 0
        for queue in self.queues[start:] + self.queues[:start]:
            looked += 1
            taken = queue.take_waiting(MOST - (queue is first), end)
            if taken and queue is not first:
                self._taken.append(queue)
            found += taken
            if perf_counter() > end:
                break
        # Of many queues few may have any.
        self._until_look = max(looked - found, 0 if found else LOOK_EVERY)

    def publish(self, first: Queue) -> None:
        """Publish what was taken, of this queue first."""
        taken, self._taken = self._taken, []
        for queue in (first, *taken):
            queue.publish()
