# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What a process and all that descend from it need: processor, waiting for one, memory."""
from __future__ import annotations

from pathlib import Path
import re


class Family:
    """A process and its descendants, looked at now and then."""

    def __init__(self, pid: int) -> None:
        self._pid = pid
        self._threads: dict[Path, tuple[int, int]] = {}
        self.largest = 0.0      # memory of the largest process at its worst so far [MiB]

    @property
    def busy(self) -> float:
        """Return the processor time of all [s]."""
        return sum(busy for busy, _ in self._threads.values()) * 1e-9

    @property
    def waited(self) -> float:
        """Return how long threads that could run waited for a processor [s]."""
        return sum(waited for _, waited in self._threads.values()) * 1e-9

    def look(self) -> None:
        """Take in what the processes that live have needed so far."""
        for member in self._members():
            self.largest = max(self.largest, _memory(member))
            for thread in Path(f'/proc/{member}/task').glob('*/schedstat'):
                try:
                    busy, waited, _ = map(int, thread.read_text().split())
                except (OSError, ValueError):
                    continue
                self._threads[thread] = busy, waited

    def _members(self) -> list[int]:
        children: dict[int, list[int]] = {}
        for status in Path('/proc').glob('[0-9]*/stat'):
            try:
                parent = int(status.read_text().rpartition(')')[2].split()[1])
            except (OSError, ValueError, IndexError):
                continue
            children.setdefault(parent, []).append(int(status.parent.name))
        family = [self._pid]
        for member in family:
            family.extend(children.get(member, []))
        return family


def _memory(pid: int) -> float:
    """Return how much memory a process needed so far [MiB]."""
    try:
        found = re.search(r'VmHWM:\s+(\d+)', Path(f'/proc/{pid}/status').read_text())
    except OSError:
        return 0.0
    return int(found[1]) / 1024 if found else 0.0
