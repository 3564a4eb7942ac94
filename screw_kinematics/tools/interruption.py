# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C and SIGTERM: the first one ends a tool in order, the next one at once."""
from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import os
import signal
import sys
from threading import current_thread, main_thread
from typing import Any, NoReturn

_ORDINARY: dict[int, Any] = {
    signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL}


@contextmanager
def interruptible() -> Iterator[None]:
    """
    Raise KeyboardInterrupt when a signal comes, and end the process when that has left all else.

    A signal that is ignored, as in the background of a script, or that somebody else handles,
    stays so.
    """
    def interrupt(number: int, _: Any) -> NoReturn:
        for each in ours:
            signal.signal(each, _end_at_once)
        raise KeyboardInterrupt(number)

    ours = [number for number, handler in _ORDINARY.items()
            if current_thread() is main_thread() and signal.getsignal(number) == handler]
    for number in ours:
        signal.signal(number, interrupt)
    # What this end leaves of multiprocessing, Python's tracker removes, and would tell.
    os.environ.setdefault('PYTHONWARNINGS', 'ignore:resource_tracker:UserWarning')
    try:
        yield
    except KeyboardInterrupt as error:
        if error.args:
            with suppress(OSError):
                print(end='', flush=True)
            _end_at_once(error.args[0], None)
        raise
    finally:
        for number in ours:
            if signal.getsignal(number) == interrupt:
                signal.signal(number, _ORDINARY[number])


def _end_at_once(number: int, _: Any) -> NoReturn:
    """End as shells tell of it, not as Python does: a pool may wait forever for ended workers."""
    if sys.stderr is not None and sys.stderr.isatty():
        os.write(sys.stderr.fileno(), b'\x1b[?25h')     # bars hide the cursor
    os._exit(128 + number)
