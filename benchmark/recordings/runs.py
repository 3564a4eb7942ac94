# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Runs of the tool bag: on cores of their own, halted while others have their turn."""
from __future__ import annotations

from collections.abc import Sequence
import os
from pathlib import Path
import re
import signal
import subprocess
import sys
import time

from rich.console import Console
from rich.progress import Progress

from .processes import Family
from screw_kinematics.tools.processes import end_with_parent

MODEL = 'package://screw_kinematics/config/robots/panda.yaml'

TURN, LOOK = 10.0, 0.2
"""How long a turn lasts, and how often it is looked how far a run is [s]."""


class Run:
    """
    A run of the tool bag, which begins halted.

    It has as many cores as processes, from the `first` one on; ``seconds`` is for how long it went
    on so far, ``text`` what it has printed once it has ended.
    """

    def __init__(self, paths: Sequence[Path], output: Path, processes: int, first: int = 0,
                 ) -> None:
        cores, parent = sorted(os.sched_getaffinity(0))[first:first + processes], os.getpid()

        def prepare() -> None:
            os.sched_setaffinity(0, cores)
            end_with_parent(parent)     # also where this one is killed outright

        self._process = subprocess.Popen(
            [sys.executable, '-m', 'screw_kinematics', 'bag', *map(str, paths), '--robot', MODEL,
             '--output', str(output), '--format', 'dataset', '--processes', str(processes)],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, start_new_session=True,
            preexec_fn=prepare)
        os.killpg(self._process.pid, signal.SIGSTOP)
        self._output = output
        self.processes, self.seconds, self.ended, self.text = processes, 0.0, False, ''
        self.family = Family(self._process.pid)

    def go_on(self) -> None:
        """Go on with the work."""
        self._since = time.monotonic()
        os.killpg(self._process.pid, signal.SIGCONT)

    def look(self) -> None:
        """Take in what it has needed so far, and whether it has ended."""
        self.family.look()
        if self._process.poll() is not None and not self.ended:
            self.seconds += time.monotonic() - self._since
            self.text, self.ended = self._process.communicate()[0], True

    def halt(self) -> None:
        """Do nothing until it goes on."""
        self.look()
        if not self.ended:
            os.killpg(self._process.pid, signal.SIGSTOP)
            self.seconds += time.monotonic() - self._since

    def kill(self) -> None:
        """End it in the middle of its work."""
        os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()

    @property
    def done(self) -> dict[Path, int]:
        """Return the notes of recordings that are done, and when each was written [ns]."""
        return {file: file.stat().st_mtime_ns for file in self._output.glob('_done/*.json')}

    @property
    def samples(self) -> int:
        """Return how many samples it made states of."""
        return int(re.findall(r'^\d+ recordings +(\d+)', self.text, re.MULTILINE)[-1])

    @property
    def rate(self) -> float:
        """Return samples a second while it went on."""
        return self.samples / self.seconds


def take_turns(contenders: Sequence[Sequence[Run]], whole: int, console: Console) -> None:
    """
    Let contenders, each of them runs that go on together, end their work in turns.

    So what else the machine does falls on all alike. A bar shows how many of so many recordings
    each has done.
    """
    with Progress(console=console, transient=True) as progress:
        bars = [progress.add_task(f'{len(runs)} of {runs[0].processes}', total=whole)
                for runs in contenders]
        while not all(run.ended for runs in contenders for run in runs):
            for bar, runs in zip(bars, contenders):
                _turn([run for run in runs if not run.ended])
                progress.update(bar, completed=sum(len(run.done) for run in runs))


def _turn(runs: Sequence[Run]) -> None:
    end = time.monotonic() + TURN
    for run in runs:
        run.go_on()
    while time.monotonic() < end and not all(run.ended for run in runs):
        time.sleep(LOOK)
        for run in runs:
            run.look()
    for run in runs:
        run.halt()
