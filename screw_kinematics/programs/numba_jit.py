# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The program compiled to machine code by Numba; needs the extra ``fast``."""
from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
import hashlib
import os
from pathlib import Path
from struct import Struct
import tempfile
from typing import Any

import numpy as np

from .instructions import StraightLine
from .numba_source import batch_source, block_source, HEADER, rows
from ..screws.se3 import Array

BLOCK = 64
"""Samples in a block of a batch: all its rows stay in the first-level cache."""

CACHE = 2 ** 22
"""Results of more bytes than this are written past the cache."""


KEPT = 64
"""Functions kept for programs of the same text. Numba never gives the memory of one back, some
50 KiB, so a robot whose descriptions alternate would grow with each."""


class NumbaBackend:
    """
    One sample in a workspace, many in blocks laid out for vector instructions.

    Nothing is compiled before the first call or :meth:`warm_up`. Machine code is kept in
    the user's cache directory and found again by the next process. ``evaluate`` uses the
    one workspace, so it is for one thread at a time; ``batch`` is not.

    Parameters
    ----------
    line : StraightLine
        The program.
    input_names : sequence of str
        Ignored; the text is for the compiler only.

    Attributes
    ----------
    workspace : array, shape (n_inputs + n_outputs,)
        Inputs and behind them outputs of :meth:`run`.

    """

    name = 'numba'

    def __init__(self, line: StraightLine, input_names: Sequence[str]) -> None:
        self._line = line
        n, m = line.n_inputs, len(line.outputs)
        self._rows = np.zeros(rows(line))
        self.workspace = self._rows[:n + m]
        self._write = Struct(f'={n}d').pack_into
        self._read = Struct(f'={m}d').unpack_from
        self._bytes = self._rows.data.cast('B')
        self._inputs_size = 8 * n
        self._kernel: Callable[[Array], Any] | None = None
        self._batch: dict[tuple[int, ...], Callable[..., Any]] = {}

    def evaluate(self, values: Sequence[float]) -> Sequence[float]:
        """Return the outputs of one sample, flat."""
        self._write(self._bytes, 0, *values)
        (self._kernel or self._compile_kernel())(self._rows)
        return self._read(self._bytes, self._inputs_size)

    def run(self) -> None:
        """Compute the outputs in the workspace from the inputs in it."""
        (self._kernel or self._compile_kernel())(self._rows)

    def batch(self, inputs: Sequence[Array], results: Array) -> None:
        """Write the outputs, shape (N, n_outputs), of inputs of shape (N, ...)."""
        widths = tuple(part.shape[1] for part in inputs)
        if widths not in self._batch:
            self._compile_batch(widths)
        flat = [np.ascontiguousarray(part).reshape(-1) for part in inputs]
        aligned = results.ctypes.data % 16 == 0 and results.shape[1] % 2 == 0
        self._batch[widths](len(results), *flat, results.reshape(-1),
                            aligned and results.nbytes > CACHE)

    def warm_up(self) -> None:
        """Compile the program for single samples."""
        self._compile_kernel()

    def _compile_kernel(self) -> Callable[[Array], Any]:
        source = block_source(self._line, 1, 'kernel')
        kernel = _compiled(source, 'kernel', 'void(float64[::1])')
        # The entry point does without the search for the right overload: there is one,
        # and the workspace is always of its type.
        self._kernel = next(iter(kernel.overloads.values())).entry_point
        assert self._kernel is not None
        return self._kernel

    def _compile_batch(self, widths: tuple[int, ...]) -> None:
        source = '\n\n'.join([block_source(self._line, BLOCK, 'block'),
                              batch_source(widths, self._line, BLOCK)])
        arrays = ', '.join(['float64[::1]'] * (len(widths) + 1))
        self._batch[widths] = _compiled(source, 'batch', f'void(intp, {arrays}, boolean)', 'block')


@lru_cache(maxsize=KEPT)
def _compiled(source: str, name: str, signature: str, *helpers: str) -> Any:
    """Return a function of a text as machine code, from the cache where it can be."""
    import numba
    path = _cached_text(HEADER + source)
    # Numba looks up the module of a function that it loads from the cache.
    scope: dict[str, Any] = {'__name__': __name__}
    exec(compile(HEADER + source, str(path or f'<screw_kinematics {name}>'), 'exec'), scope)
    # Contraction is fused multiply-add, which rounds once less; nothing is reordered.
    options: Any = {'fastmath': {'contract'}, 'error_model': 'numpy', 'nogil': True}
    for helper in helpers:
        scope[helper] = numba.njit(**options)(scope[helper])
    return numba.njit(signature, cache=path is not None, **options)(scope[name])


def _cached_text(text: str) -> Path | None:
    """
    Return a file in the user's cache that holds the text, or None if there cannot be one.

    Numba finds machine code by the file and the name of a function, and does not look
    into what the function calls. So the name of the file depends on all of it.
    """
    from . import vector_math
    called = Path(vector_math.__file__).read_text(encoding='utf-8')
    digest = hashlib.sha256((called + text).encode()).hexdigest()[:16]
    cache = os.environ.get('XDG_CACHE_HOME') or str(Path('~/.cache').expanduser())
    path = Path(cache) / 'screw_kinematics' / f'program_{digest}.py'
    try:
        if not path.exists() or path.read_text(encoding='utf-8') != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile('w', dir=path.parent, delete=False,
                                             encoding='utf-8') as file:
                file.write(text)
            os.replace(file.name, path)
    except (OSError, RuntimeError):
        return None
    return path
