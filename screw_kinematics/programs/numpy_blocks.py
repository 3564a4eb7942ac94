# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The program on blocks of samples, one NumPy call for each operation.

A block is short enough that all intermediate rows stay in the cache, and long enough that
the cost of the calls does not count. Rows are used again as soon as their value is no
longer needed, so the rows of a 7R arm fill less than one megabyte.
"""
from __future__ import annotations

from collections.abc import Sequence
from typing import Union

import numpy as np

from .instructions import StraightLine
from ..screws.se3 import Array

BLOCK = 2000
"""Samples in a block."""

_UFUNC = {'add': 'add', 'sub': 'subtract', 'mul': 'multiply', 'div': 'divide',
          'neg': 'negative', 'sin': 'sin', 'cos': 'cos', 'sqrt': 'sqrt'}


def numpy_source(line: StraightLine) -> tuple[str, int]:
    """
    Return the text of ``block(inputs, outputs, rows)`` and the number of rows it needs.

    All three are sequences of one-dimensional arrays of one length: a row for each input,
    for each output, and scratch.
    """
    last_read: dict[int, int] = {}
    for position, operation in enumerate(line.operations):
        last_read.update((index, position) for index in operation.operands)
    wanted = {output: k for k, output in reversed(list(enumerate(line.outputs)))
              if isinstance(output, int)}
    names = {k: f'q{k}' for k in range(line.n_inputs)}
    free: list[str] = []
    n_rows = 0
    body = []

    def text(x: Union[int, float, None]) -> str:
        return names[x] if isinstance(x, int) else repr(x)

    for position, operation in enumerate(line.operations):
        value = line.n_inputs + position
        arguments = [text(x) for x in (operation.left, operation.right) if x is not None]
        for index in set(operation.operands):
            if last_read[index] == position and names[index].startswith('x'):
                free.append(names[index])
        if value in wanted:
            names[value] = f'y{wanted[value]}'
        elif free:
            names[value] = free.pop()
        else:
            names[value] = f'x{n_rows}'
            n_rows += 1
        body.append(f'{_UFUNC[operation.kind]}({", ".join(arguments)}, {names[value]})')
    # Outputs that are constants, inputs, or equal to an earlier output.
    for k, output in enumerate(line.outputs):
        if not isinstance(output, int) or names[output] != f'y{k}':
            body.append(f'y{k}[:] = {text(output)}')

    def unpack(prefix: str, n: int, source: str) -> list[str]:
        return [', '.join(f'{prefix}{k}' for k in range(n)) + f', = {source}'] if n else []

    rows = [*unpack('q', line.n_inputs, 'inputs'), *unpack('y', len(line.outputs), 'outputs'),
            *unpack('x', n_rows, 'rows'), *body, 'return']
    functions = ', '.join(f'{u}={u}' for u in dict.fromkeys(_UFUNC.values()))
    return '\n    '.join([f'def block(inputs, outputs, rows, {functions}):', *rows]), n_rows


class NumpyBlocks:
    """
    The program on arrays, block by block.

    Parameters
    ----------
    line : StraightLine

    """

    def __init__(self, line: StraightLine) -> None:
        source, n_rows = numpy_source(line)
        scope = {ufunc: getattr(np, ufunc) for ufunc in _UFUNC.values()}
        exec(compile(source, '<screw_kinematics blocks>', 'exec'), scope)
        self._block = scope['block']
        self._n_outputs = len(line.outputs)
        self._n_rows = n_rows

    def __call__(self, inputs: Sequence[Array], results: Array) -> None:
        """
        Write the outputs of all samples.

        Parameters
        ----------
        inputs : sequence of array, shape (N, n)
            The inputs, in one or several arrays.
        results : array, shape (N, number of outputs)
            The outputs.

        """
        n_samples = len(inputs[0])
        widths = [part.shape[1] for part in inputs]
        length = min(BLOCK, n_samples)
        columns = np.empty((sum(widths), length))
        outputs = np.empty((self._n_outputs, length))
        rows = np.empty((self._n_rows, length))
        ends = np.cumsum([0, *widths])
        # A sample that is not finite gives NaN, silently, as with the other backends.
        with np.errstate(invalid='ignore', over='ignore', divide='ignore'):
            for start in range(0, n_samples, BLOCK):
                stop = min(start + BLOCK, n_samples)
                n = stop - start
                for part, first, last in zip(inputs, ends, ends[1:]):
                    columns[first:last, :n] = part[start:stop].T
                self._block(columns[:, :n], outputs[:, :n], rows[:, :n])
                results[start:stop] = outputs[:, :n].T
