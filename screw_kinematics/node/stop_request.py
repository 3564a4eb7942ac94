# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How a process is asked to end."""
from __future__ import annotations

from collections.abc import Callable
import signal
from types import FrameType


class StopRequest:
    """
    A request to stop, made by SIGINT, SIGTERM or a call of :meth:`make`.

    Used as a context manager, it takes over both signals and gives them back at the end.
    ROS's own handlers are not to be installed beside it: they shut the middleware down below
    running callbacks, which then raise now and then.

    Examples
    --------
    >>> import os, signal
    >>> with StopRequest() as stop:
    ...     os.kill(os.getpid(), signal.SIGTERM)
    ...     stop.made
    True

    """

    def __init__(self) -> None:
        # Whether it was made; whether what runs is then to begin again.
        self.made = self.again = False
        # Called when it is made, to end what takes long; it must be safe in a signal handler.
        self.interrupt: Callable[[], object] | None = None
        self._previous: dict[int, Callable[[int, FrameType | None], object] | int | None] = {}

    def make(self, *_: object) -> None:
        """Ask for the end."""
        self.made = True
        if self.interrupt is not None:
            self.interrupt()

    def begin_again(self) -> None:
        """Ask for the end of what runs now, so that it begins again."""
        self.again = True
        if self.interrupt is not None:
            self.interrupt()

    def middleware_ended(self) -> None:
        """Ask for the end, unless the middleware ends to begin again."""
        if not self.again:
            self.make()

    def take_signals(self) -> None:
        """Handle both signals here, whoever handled them until now."""
        for number in (signal.SIGINT, signal.SIGTERM):
            previous = signal.signal(number, self.make)
            self._previous.setdefault(number, previous)

    def __enter__(self) -> StopRequest:
        self.take_signals()
        return self

    def __exit__(self, *_: object) -> None:
        for number, previous in self._previous.items():
            signal.signal(number, signal.SIG_DFL if previous is None else previous)
