# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The resident memory of a process over time, and whether it grows.

The middleware keeps what a queue has once needed, some 1 KiB for each message. A reliable
publisher queues up to its depth while a subscriber does not acknowledge, be it stopped or
killed; an input queues what comes while the node is busy or gets no processor. So memory grows
by a step whenever a queue is longer than ever before. While 60 subscribers were killed one
after another, that of the node grew by 37 MiB until all queues of outputs had been full once,
and by 0.6 MiB in all during the last 30; that of a bare relay by 29 and by 1.6 MiB. A run that is
long enough for a slope therefore begins by having all queues longer than any fault will make
them.
"""
from dataclasses import dataclass, field
import os
from pathlib import Path
import time

import numpy as np

MAX_SLOPE = 60.0
"""Of the node's memory in the second half of the run [KiB/min], where that tells."""

SLOPE_MINUTES = 5.0
"""Shortest time in which a slope tells of growth."""


@dataclass
class Memory:
    """The memory of one process: instants [s, monotonic] and resident memory [KiB]."""

    samples: list[tuple[float, float]] = field(default_factory=list)

    def look(self, pid: int) -> None:
        """Take a sample."""
        pages = int(Path(f'/proc/{pid}/statm').read_text().split()[1])
        self.samples.append((time.monotonic(), pages * os.sysconf('SC_PAGE_SIZE') / 1024))

    def forget(self) -> None:
        """Begin at the last sample."""
        del self.samples[:-1]

    @property
    def slope(self) -> float | None:
        """Return the slope in the second half [KiB/min], if that is long enough."""
        if not self.samples:
            return None
        t, kib = np.array(self.samples).T
        late = t >= (t[0] + t[-1]) / 2
        minutes = (t[late] - t[0]) / 60
        if np.ptp(minutes) < SLOPE_MINUTES:
            return None
        return float(np.polyfit(minutes, kib[late], 1)[0])

    def told(self) -> str:
        """Return the memory for reading."""
        slope = 'too short to tell' if self.slope is None else f'{self.slope:+.1f} KiB/min'
        first, last = (self.samples[i][1] / 1024 if self.samples else 0.0 for i in (0, -1))
        return f'{first:.1f} MiB to {last:.1f} MiB, {slope}'
