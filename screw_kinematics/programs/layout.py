# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
How a straight-line program is laid out for the interpreter of the core.

Operations become runs of one kind, in waves of operations that do not depend on each other, so
that the interpreter decides once for each run what to do, and the processor need not wait. Sums
and products become one kind (a b + c with one factor 1, or the summand -0, which changes no bit);
a product that only one sum reads becomes part of it, rounded in between as before; and sine and
cosine of one angle are found together.
"""
from __future__ import annotations

from array import array
from collections.abc import Mapping
from typing import NamedTuple, Union

import numpy as np

from .checkpoint import checkpoint
from .straight_line_program import StraightLineProgram
from ..core.interpreter import Interpreter, KINDS, MAX_ROWS
from ..errors import InvalidValueError

_Value = Union[int, float]     # as in an Operation: a value's index, or a constant


class _Step(NamedTuple):
    """One operation of the interpreter: what it reads, and the values it makes (-1: unread)."""

    kind: str
    reads: tuple[_Value, ...]
    makes: tuple[int, ...]


def interpreter(line: StraightLineProgram, width: int, slices: Mapping[str, slice]) -> Interpreter:
    """Return an interpreter that has learnt a program."""
    code, n_rows, constants, outputs = _rows(line, _runs(line, _steps(line)))
    if n_rows > MAX_ROWS:
        raise InvalidValueError(
            f'the program needs {n_rows} numbers at a time; allowed: {MAX_ROWS}')
    return Interpreter(array('Q', code), n_rows, line.n_inputs, array('d', constants),
                       array('Q', outputs), width, list(slices.items()), np.empty)


def _steps(line: StraightLineProgram) -> list[_Step]:
    """Return the program in the interpreter's kinds."""
    uses = line.uses()
    steps: dict[int, _Step] = {}
    turned: dict[str, int] = {}

    def factors(x: _Value) -> tuple[_Value, ...] | None:
        """Take a product that nothing else reads apart."""
        if not (isinstance(x, int) and x >= line.n_inputs and uses[x] == 1
                and line.operations[x - line.n_inputs].kind == 'mul'):
            return None
        return steps.pop(x).reads[:2]

    for value, (kind, left, right) in enumerate(line.operations, start=line.n_inputs):
        reads: tuple[_Value, ...]
        if kind in ('sin', 'cos'):
            at = turned.get(repr(left), value)
            sine, cosine = steps[at].makes if at in steps else (-1, -1)
            if (sine if kind == 'sin' else cosine) >= 0:
                at, sine, cosine = value, -1, -1
            turned[repr(left)] = at
            steps[at] = _Step('sincos', (left,), (value, cosine) if kind == 'sin'
                              else (sine, value))
            continue
        if right is None:
            kind, reads = (kind, (left,)) if kind == 'sqrt' else ('submul', (left, 1.0, -0.0))
        elif kind == 'mul':
            kind, reads = 'muladd', (left, right, -0.0)
        elif kind == 'div':
            reads = left, right
        elif (product := factors(left)) is not None:
            kind, reads = 'muladd' if kind == 'add' else 'mulsub', (*product, right)
        elif (product := factors(right)) is not None:
            kind, reads = 'muladd' if kind == 'add' else 'submul', (*product, left)
        else:
            kind, reads = 'muladd' if kind == 'add' else 'mulsub', (left, 1.0, right)
        steps[value] = _Step(kind, reads, (value,))
    return list(steps.values())


def _runs(line: StraightLineProgram, steps: list[_Step]) -> list[list[_Step]]:
    """Return the steps in an order with few changes of kind."""
    maker = {value: at for at, step in enumerate(steps) for value in step.makes}
    readers: list[list[int]] = [[] for _ in steps]
    missing = [0] * len(steps)
    for at, step in enumerate(steps):
        before = {maker[x] for x in step.reads if isinstance(x, int) and x >= line.n_inputs}
        missing[at] = len(before)
        for other in before:
            readers[other].append(at)
    ready: dict[str, list[int]] = {kind: [] for kind in KINDS}
    for at, step in enumerate(steps):
        if not missing[at]:
            ready[step.kind].append(at)
    runs = []
    while any(ready.values()):
        checkpoint()
        # Sines and cosines take longest, and most of what follows waits for them.
        kind = 'sincos' if ready['sincos'] else max(KINDS, key=lambda k: len(ready[k]))
        run = []
        while ready[kind]:
            wave, ready[kind] = ready[kind], []
            run += [steps[at] for at in wave]
            for at in wave:
                for reader in readers[at]:
                    missing[reader] -= 1
                    if not missing[reader]:
                        ready[steps[reader].kind].append(reader)
        runs.append(run)
    return runs


def _rows(line: StraightLineProgram, runs: list[list[_Step]]) \
        -> tuple[list[int], int, list[float], list[int]]:
    """Return code, number of rows, constants, and the rows of the outputs."""
    steps = [step for run in runs for step in run]
    last = {x: at for at, step in enumerate(steps) for x in step.reads if isinstance(x, int)}
    last.update((x, len(steps)) for x in line.outputs if isinstance(x, int))
    # By their text: 0.0 and -0.0 are equal, but not the same.
    constants = {repr(x): x for values in (*(step.reads for step in steps), line.outputs)
                 for x in values if isinstance(x, float)}
    constant = {text: line.n_inputs + k for k, text in enumerate(constants)}
    n_rows = line.n_inputs + len(constants)
    row = {value: value for value in range(line.n_inputs)}
    free: list[int] = []

    def read(x: _Value) -> int:
        return row[x] if isinstance(x, int) else constant[repr(x)]

    code: list[int] = []
    at = 0
    for run in runs:
        checkpoint()
        code.append(KINDS.index(run[0].kind) | len(run) << 16)
        for step in run:
            targets = []
            for value in step.makes:
                if not free:
                    free.append(n_rows)
                    n_rows += 1
                row[value] = free.pop()
                targets.append(row[value])
            entry = [targets[0], *map(read, step.reads), *targets[1:]]
            code.append(sum(r << 16 * k for k, r in enumerate(entry)))
            # Freed after the targets were chosen: no operation writes a row that it reads.
            free += [row[x] for x in {*step.reads} if isinstance(x, int)
                     and x >= line.n_inputs and last[x] == at]
            free += [row[value] for value in step.makes if value not in last]
            at += 1
    return code, n_rows, list(constants.values()), [read(x) for x in line.outputs]
