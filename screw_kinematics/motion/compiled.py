# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether machine code can be had (optional extra ``fast``), and whether it is ready."""

from __future__ import annotations

from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple
from zlib import crc32


class Kernels(NamedTuple):
    """Compiled functions, see `compiled_step`."""

    take: Any


_ready: list[Kernels] = []


def ready() -> Kernels | None:
    """Return the compiled functions if some estimator has been warmed up, else None."""
    return _ready[0] if _ready else None


def announce(kernels: Kernels) -> None:
    """Let estimators made from now on use the functions, which have run once."""
    _ready[:] = [kernels]


@lru_cache(maxsize=1)
def load() -> Kernels | None:
    """
    Return functions that are compiled when they first run; None where Numba is not installed.

    Compiling takes some seconds and belongs to configuration, not to the first message. The
    result is kept on disk where that can be written.
    """
    if find_spec('numba') is None:
        return None
    from .compiled_step import compile_take
    sources = 0
    for source in sorted(Path(__file__).parent.glob('*.py')):
        sources = crc32(source.read_bytes(), sources)
    try:
        return Kernels(compile_take(sources, cache=True))
    except RuntimeError:      # no place for the cache
        return Kernels(compile_take(sources, cache=False))
