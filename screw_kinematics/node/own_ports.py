# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Whether this process still listens where others send: Fast DDS's ports in shared memory.

Of a process that stands still for some seconds Fast DDS gives up the ports, and every publisher
makes and deletes them anew with each message. One that goes on just then may be left with a port
that has no name any more: nothing arrives there, and nothing in the middleware notices.
"""
from __future__ import annotations

from contextlib import suppress
import os
from pathlib import Path
import re
from time import monotonic

LASTING = 1.5
"""For how long a port must have had no name [s]: it takes a third of a second to open another."""

LOCK = re.compile(r'(/.*/fast(?:rtps|dds)_port\d+)_el$')
"""File that a process keeps open while it alone listens to the port of that name."""


class OwnPorts:
    """Looks after the ports that /proc tells of the process; where there are none, for nothing."""

    def __init__(self, process: Path = Path('/proc/self')) -> None:
        self._process = process
        # One that has no file from the start carries nothing that is missed.
        self._files = {port: file for port in self._locked() if (file := _file(port))}
        self._nameless: dict[str, float] = {}

    def deaf(self) -> list[str]:
        """Return ports that are listened to, and have had no name for a while."""
        doubtful = {port for port, file in self._files.items() if _file(port) != file}
        if doubtful:        # most often none: a look costs microseconds
            doubtful &= self._locked()
            mapped = self._mapped()
            for port in doubtful & mapped:
                self._files[port] = _file(port)     # made anew, and opened again
            doubtful -= mapped
        now = monotonic()
        self._nameless = {port: self._nameless.get(port, now) for port in doubtful}
        return sorted(port for port, since in self._nameless.items() if now - since > LASTING)

    @property
    def names(self) -> frozenset[str]:
        """Return the names of the ports that are looked after."""
        return frozenset(self._files)

    def _locked(self) -> set[str]:
        """Return the names of the ports that this process has locked."""
        names = set()
        with suppress(OSError):
            for link in (self._process / 'fd').iterdir():
                with suppress(OSError):
                    if found := LOCK.match(os.readlink(link)):
                        names.add(found[1])
        return names

    def _mapped(self) -> set[str]:
        """Return the names of the files that are in this process's memory, and not deleted."""
        return {line.split(maxsplit=5)[5] for line in (
            self._process / 'maps').read_text(errors='replace').splitlines()
            if '/fast' in line and not line.endswith(' (deleted)')}


def _file(port: str) -> int:
    """Return the number of the file of that name; 0 if there is none."""
    try:
        return os.stat(port).st_ino
    except OSError:
        return 0
