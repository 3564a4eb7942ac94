# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Child processes that never outlive the tool which started them."""
from __future__ import annotations

from collections.abc import Sequence
import ctypes
from functools import partial
import os
import signal
import subprocess
import sys
import tempfile
from typing import IO

from ..errors import ToolError

_PR_SET_PDEATHSIG = 1
_GRACE = 5.0        # that a process has to end by itself [s]
_TOLD = 5           # last lines of its output that are told


class Children:
    """
    Python processes of this environment, ended when the context is left.

    Each runs in a session of its own, so Ctrl-C in the terminal reaches the tool alone,
    which then ends its children in order; and on Linux the kernel ends them if the
    tool is killed outright.
    """

    def __init__(self) -> None:
        self._running: list[tuple[str, subprocess.Popen[bytes], IO[bytes]]] = []

    def __enter__(self) -> Children:
        return self

    def __exit__(self, *error: object) -> None:
        for _, process, _ in reversed(self._running):
            _signal_group(process, signal.SIGTERM)
        for _, process, output in reversed(self._running):
            try:
                process.wait(_GRACE)
            except subprocess.TimeoutExpired:
                _signal_group(process, signal.SIGKILL)
                process.wait()
            output.close()
        self._running.clear()

    def start(self, name: str, module: str, arguments: Sequence[str]) -> None:
        """Start ``python -m module arguments``; its output is kept for error messages."""
        output = tempfile.TemporaryFile()
        process = subprocess.Popen(
            [sys.executable, '-m', module, *arguments], stdin=subprocess.DEVNULL,
            stdout=output, stderr=subprocess.STDOUT, start_new_session=True,
            preexec_fn=partial(end_with_parent, os.getpid()))
        self._running.append((name, process, output))

    def check(self) -> None:
        """Raise ToolError if a process has ended, with the last lines it wrote."""
        for name, process, output in self._running:
            code = process.poll()
            if code is not None:
                raise ToolError(
                    f'{name} ended with exit code {code}: {_last_lines(output)}')


def end_with_parent(parent: int) -> None:
    """Ask the kernel to send SIGTERM when the parent dies; called in the child."""
    if sys.platform != 'linux':
        return
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:    # it died before the request
        os._exit(1)


def _signal_group(process: subprocess.Popen[bytes], number: signal.Signals) -> None:
    try:
        os.killpg(process.pid, number)
    except ProcessLookupError:
        pass


def _last_lines(output: IO[bytes]) -> str:
    output.seek(0)
    lines = [line for line in output.read().decode(errors='replace').strip().splitlines()
             if not line.startswith('[INFO]')]      # of how it began, not why it ended
    return ' | '.join(line.strip() for line in lines[-_TOLD:]) or 'no output'
