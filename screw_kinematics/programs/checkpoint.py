# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Where long work looks up, so that whoever runs it in a thread can let it wait, or end it."""
from __future__ import annotations

from collections.abc import Callable
from contextvars import ContextVar

CHECKPOINT: ContextVar[Callable[[], object]] = ContextVar('checkpoint', default=lambda: None)
"""What is called there. It may take its time, and what it raises ends the work."""

NODES_BETWEEN = 256
"""Operations that are traced or placed between two checkpoints: some milliseconds."""


def checkpoint() -> None:
    """Look up, in the midst of work that takes seconds."""
    CHECKPOINT.get()()
