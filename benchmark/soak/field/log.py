# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What the drivers have sent, in memory that another process reads."""
import mmap
from pathlib import Path

import numpy as np

LENGTH = 1 << 15
"""Messages of each robot that are remembered: those of half a minute."""

_ENTRY = np.dtype([('stamp', '<i8'), ('instant', '<f8'), ('sent', '<i8')])


class SentLog:
    """
    The latest messages of each robot, in a file that is made if it does not exist.

    Counts, of shape (robots, 2), are messages published, and entries made. Entries, of shape
    (robots, LENGTH), are stamp [ns], instant that it stands for [s, from the beginning of the
    motion], and when it was sent [ns, monotonic]; entry k is at k modulo LENGTH.
    """

    def __init__(self, file: Path, robots: int) -> None:
        head, size = 16 * robots, robots * LENGTH * _ENTRY.itemsize
        if not file.exists():
            file.write_bytes(bytes(head + size))
        with open(file, 'r+b') as opened:
            shared = mmap.mmap(opened.fileno(), head + size)
        self.counts = np.frombuffer(shared, '<i8', 2 * robots).reshape(robots, 2)
        self.entries = np.frombuffer(shared, _ENTRY, offset=head).reshape(robots, LENGTH)
