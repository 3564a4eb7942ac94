# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
What runs a straight-line program: the interpreter of the core.

Where the core is not compiled its interpreter would be slow; there the program runs as the text
of a Python function, on floats and on blocks of NumPy arrays. The results are the same to the
last bit: both do the same operations, and sine and cosine are those of the core's text.
"""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
import os
from threading import Thread
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np

from .layout import interpreter
from .python_text import python_function
from .straight_line_program import StraightLineProgram
from ..core import interpreted
from ..core.interpreter import check_number, COMPILED, MAX_PARTS
from ..screws.se3 import Array

WORTH_A_THREAD = 1 << 13
"""Samples of a batch that take so long that starting a thread for them pays."""

BLOCK = 1024
"""Samples of a batch that NumPy works on at a time; they stay in the processor's cache."""


class Machine(Protocol):
    """What runs a program: one sample, and many."""

    def evaluate(self, values: Sequence[float], /) -> tuple[float, ...]:
        """Return the outputs of one sample, flat; NaN and infinity where there is no result."""

    def sample(self, parts: tuple[Any, ...], /) -> dict[str, Array] | None:
        """
        Return the outputs of one sample by names; None if the parts, arrays, do not fit.

        More parts than there are inputs are passed over.
        """

    def batch(self, parts: Sequence[Array], out: Array, threads: int) -> None:
        """Write the outputs, shape (N, n_outputs), of parts of shape (N, ...)."""


def machine(line: StraightLineProgram, width: int = 0,
            slices: Mapping[str, slice] = MappingProxyType({})) -> Machine:
    """
    Return what runs a program here.

    Parts of the inputs have ``width`` numbers, and parts of the outputs the names of ``slices``;
    both are for :meth:`Machine.sample` alone.
    """
    return (CompiledMachine if COMPILED else TextMachine)(line, width, slices)


class CompiledMachine:
    """The compiled interpreter; see :class:`Machine`."""

    def __init__(self, line: StraightLineProgram, width: int, slices: Mapping[str, slice]) -> None:
        self._interpreter = interpreter(line, width, slices)
        self.evaluate = self._interpreter.evaluate
        self.sample = self._interpreter.sample

    def batch(self, parts: Sequence[Array], out: Array, threads: int) -> None:
        """Write the outputs; each thread has a part of the samples that is worth it."""
        n = max(1, min(threads, os.cpu_count() or 1, len(out) // WORTH_A_THREAD))
        ends = [len(out) * k // n for k in range(n + 1)]
        arrays = out, *parts, *[np.empty((len(out), 0))] * (MAX_PARTS - len(parts))
        others = [Thread(target=self._interpreter.batch, args=(start, stop, *arrays))
                  for start, stop in zip(ends[1:], ends[2:])]
        for thread in others:
            thread.start()
        self._interpreter.batch(0, ends[1], *arrays)
        for thread in others:
            thread.join()


class TextMachine:
    """The program's Python text; see :class:`Machine`."""

    def __init__(self, line: StraightLineProgram, width: int, slices: Mapping[str, slice]) -> None:
        self._width, self._slices = width, slices
        self._n_parts = line.n_inputs // width if width else 0
        core = interpreted('interpreter')
        sines, cosines = partial(_turned, core, 0), partial(_turned, core, 1)
        self._on_floats = python_function(line, core.sine, core.cosine)
        self._on_arrays = python_function(line, sines, cosines, np.sqrt)

    def evaluate(self, values: Sequence[float]) -> tuple[float, ...]:
        """Return the outputs of one sample, flat."""
        floats = [*map(float, values)]
        for value, x in zip(values, floats):
            if x != x:
                check_number(value)
        try:
            return self._on_floats(floats)
        except (ArithmeticError, ValueError):      # where arrays have NaN or infinity
            with np.errstate(all='ignore'):
                return tuple(map(float, self._on_arrays(np.array(floats))))

    def sample(self, parts: tuple[Any, ...]) -> dict[str, Array] | None:
        """Return the outputs of one sample by names; None if the parts do not fit."""
        parts = parts[:self._n_parts]
        if len(parts) < self._n_parts or any(
                getattr(part, 'shape', None) != (self._width,) for part in parts):
            return None
        out = np.array(self.evaluate([x for part in parts for x in part.tolist()]))
        return {name: out[part] for name, part in self._slices.items()}

    def batch(self, parts: Sequence[Array], out: Array, threads: int) -> None:
        """Write the outputs, by one thread."""
        with np.errstate(all='ignore'):
            for start in range(0, len(out), BLOCK):
                block = slice(start, start + BLOCK)
                rows = [row for part in parts for row in part[block].T]
                for k, values in enumerate(self._on_arrays(rows)):
                    out[block, k] = values


def _turned(core: Any, which: int, x: Any) -> Any:
    """Return sines (0) or cosines (1) of an array, or of a number."""
    values = np.asarray(core.turned(x)[which])
    for k in np.argwhere(~(np.abs(x) <= core.LARGEST_ANGLE)):
        values[tuple(k)] = (core.sine, core.cosine)[which](float(np.asarray(x)[tuple(k)]))
    return values
