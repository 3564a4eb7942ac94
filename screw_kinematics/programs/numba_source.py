# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The text that Numba compiles: the program on a block of samples.

All numbers of a block are in one flat array of rows, one row for each quantity and one
column for each sample: inputs, outputs, angles, their sines, their cosines. The operations
run in one loop over the samples without branches, which LLVM turns into vector
instructions. A block of one sample is the program for a single sample; there the vectors
run over the joint angles.
"""
from __future__ import annotations

from collections.abc import Sequence

from .instructions import StraightLine
from .statements import assignments

HEADER = """\
# Written by screw_kinematics; safe to delete.
from math import cos, sin, sqrt

import numpy as np

from screw_kinematics.programs.vector_math import LARGEST_ANGLE, sincos, transpose


"""


def block_source(line: StraightLine, block: int, name: str) -> str:
    """
    Return the text of a function that runs the program on a block, in place.

    Parameters
    ----------
    line : StraightLine
        The program.
    block : int
        Number of samples.
    name : str
        Name of the function, which takes the flat array of :func:`rows` rows.

    """
    n, m = line.n_inputs, len(line.outputs)
    angles, sines, cosines = _angles(line)
    k = len(angles)
    first = n + m
    inputs = [f'q{j}' for j in range(n)]
    turned = [f'{f}{j}' for f in 'sc' for j in range(k)]
    # Placeholders stand for the sine of an angle of which only the cosine is wanted.
    rest = line.part([*range(n), *sines, *cosines], line.outputs)
    text = [f'def {name}(w):', *_loop(line.part(range(n), angles), inputs, [*range(n)], first,
                                      block)]
    if k:
        text += _sincos(first * block, k * block)
    text += _loop(rest, inputs + turned, [*range(n), *range(first + k, first + 3 * k)], n,
                  block)
    return '\n'.join(text) + '\n'


def rows(line: StraightLine) -> int:
    """Return the number of rows a block needs."""
    return line.n_inputs + len(line.outputs) + 3 * len(_angles(line)[0])


def batch_source(widths: Sequence[int], line: StraightLine, block: int) -> str:
    """
    Return the text of ``batch(count, part0, part1, ..., results, past_the_cache)``.

    Parameters
    ----------
    widths : sequence of int
        How many inputs each of the parts has.
    line : StraightLine
        The program.
    block : int
        Samples in a block; the text uses ``block(w)``.

    """
    m = len(line.outputs)
    parts = [f'part{k}' for k in range(len(widths))]
    text = [f'def batch(count, {", ".join(parts)}, results, past_the_cache):',
            f'    w = np.zeros({rows(line) * block})',
            f'    for start in range(0, count, {block}):',
            f'        n = min({block}, count - start)']
    row = 0
    for part, width in zip(parts, widths):
        text += [f'        transpose(w, {row * block}, {block}, {part}, start * {width}, '
                 f'{width}, n, {width}, False)']
        row += width
    text += ['        block(w)',
             f'        transpose(results, start * {m}, {m}, w, {row * block}, {block}, '
             f'{m}, n, past_the_cache)']
    return '\n'.join(text) + '\n'


def _angles(line: StraightLine) -> tuple[list[int], list[int], list[int]]:
    """
    Return the values whose sine or cosine is taken, and these sines and cosines.

    Only such that are made without sines and cosines; the sine or cosine that is not
    wanted is -1.
    """
    functions: dict[int, dict[str, int]] = {}
    late: set[int] = set()
    for value, operation in enumerate(line.operations, start=line.n_inputs):
        if late.intersection(operation.operands):
            late.add(value)
        elif operation.kind in ('sin', 'cos') and isinstance(operation.left, int):
            late.add(value)
            functions.setdefault(operation.left, {})[operation.kind] = value
    return (list(functions), [f.get('sin', -1) for f in functions.values()],
            [f.get('cos', -1) for f in functions.values()])


def _loop(line: StraightLine, names: Sequence[str], from_rows: Sequence[int], to_row: int,
          block: int) -> list[str]:
    """Return the loop of a program that reads and writes rows of the array ``w``."""
    read = {k for operation in line.operations for k in operation.operands}
    read |= {output for output in line.outputs if isinstance(output, int)}
    text = assignments(line, names, reuse=False)
    return [f'    for i in range({block}):',
            *[f'        {name} = w[{row * block} + i]'
              for k, (name, row) in enumerate(zip(names, from_rows)) if k in read],
            *[f'        {name} = {expression}' for name, expression in text.body],
            *[f'        w[{(to_row + k) * block} + i] = {expression}'
              for k, expression in enumerate(text.outputs)],
            '        pass']


def _sincos(start: int, count: int) -> list[str]:
    """Return the loops that put sines and cosines behind the angles."""
    def loop(function: str) -> list[str]:
        return [f'        for i in range({start}, {start + count}):',
                f'            w[{count} + i], w[{2 * count} + i] = {function}']
    return ['    large = 0',
            f'    for i in range({start}, {start + count}):',
            '        large += not abs(w[i]) <= LARGEST_ANGLE',
            '    if large:', *loop('sin(w[i]), cos(w[i])'),
            '    else:', *loop('sincos(w[i])')]
