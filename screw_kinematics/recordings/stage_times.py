# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How long each stage of a long work takes, and how much memory it needed."""
from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import resource
import time


class StageTimes:
    """Adds up the time spent in named stages."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._begin = time.perf_counter()

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count the time of a block for a stage."""
        begin = time.perf_counter()
        try:
            yield
        finally:
            self.add(name, time.perf_counter() - begin)

    def add(self, name: str, seconds: float) -> None:
        """Count time that was spent in another process for a stage."""
        self.seconds[name] = self.seconds.get(name, 0.0) + seconds

    def report(self, processes: int = 0) -> str:
        """
        Return the times of the stages, their sum, and the peak of memory, in one line.

        Parameters
        ----------
        processes : int
            How many other processes helped; each is taken to have needed as much memory as
            the largest.

        """
        parts = [f'{name} {seconds:.2f} s' for name, seconds in self.seconds.items()]
        total = time.perf_counter() - self._begin
        own, others = (resource.getrusage(who).ru_maxrss / 1024 for who in (
            resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        return (f'{", ".join(parts)}; in all {total:.2f} s, at most '
                f'{own + processes * others:.0f} MiB of memory')
