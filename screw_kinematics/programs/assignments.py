# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
A straight-line program as assignments, in the syntax that Python and C share.

A value that is read once becomes part of its reader's expression; the others get a name,
which is used again as soon as its value is no longer needed. Both spare an interpreter
loads and stores, and neither changes the order of rounding.
"""
from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Union

from .straight_line_program import StraightLineProgram

MAX_DEPTH = 30
"""Nesting of an expression; Python's parser allows about 90 levels, C compilers 63."""

_BINARY = {'add': '+', 'sub': '-', 'mul': '*', 'div': '/'}
_ATOM, _PRODUCT, _SUM = 0, 1, 2


@dataclass(frozen=True)
class Assignments:
    """Assignments in order, and the expressions of the outputs after them."""

    body: tuple[tuple[str, str], ...]    # name and expression
    outputs: tuple[str, ...]             # one expression for each output of the program
    names: tuple[str, ...]               # those assigned to, each once


class _Text(NamedTuple):
    """An expression: its text, how tightly it binds, its nesting, the values it reads."""

    text: str
    level: int
    depth: int
    leaves: tuple[int, ...]


def assignments(line: StraightLineProgram, input_names: Sequence[str],
                name: Callable[[int], str] = 'x{}'.format, reuse: bool = True) -> Assignments:
    """
    Return a straight-line program as assignments; ``name`` gives that of the k-th variable.

    To reuse names spares an interpreter memory, and costs a compiler time: to tell such values
    apart grows as their square.
    """
    named, outputs = _expressions(line)
    last_read = {leaf: position for position, (_, text) in enumerate(named)
                 for leaf in text.leaves}
    for text in outputs:
        last_read.update((leaf, len(named)) for leaf in text.leaves)
    names = {_mark(k): input_name for k, input_name in enumerate(input_names)}
    all_names: list[str] = []
    free: list[str] = []
    body = []
    for position, (value, text) in enumerate(named):
        expression = text.text.format_map(names)
        for leaf in set(text.leaves):
            if reuse and leaf >= line.n_inputs and last_read[leaf] == position:
                free.append(names[_mark(leaf)])
        if not free:
            free.append(name(len(all_names)))
            all_names.append(free[-1])
        names[_mark(value)] = free.pop()
        body.append((names[_mark(value)], expression))
    return Assignments(tuple(body), tuple(t.text.format_map(names) for t in outputs),
                       tuple(all_names))


def _mark(index: int) -> str:
    """Return the key that stands for a value until it has a name."""
    return f'v{index}'


def _leaf(index: int) -> _Text:
    return _Text(f'{{{_mark(index)}}}', _ATOM, 0, (index,))


def _expressions(line: StraightLineProgram) -> tuple[list[tuple[int, _Text]], list[_Text]]:
    """Return the values that get a name with their expressions, and the outputs."""
    uses = line.uses()
    texts = {k: _leaf(k) for k in range(line.n_inputs)}
    named: list[tuple[int, _Text]] = []

    def operand(x: Union[int, float, None], loosest: int) -> _Text:
        assert x is not None
        text = texts[x] if isinstance(x, int) else _Text(repr(x), _ATOM, 0, ())
        if text.level <= loosest:
            return text
        return text._replace(text=f'({text.text})', level=_ATOM, depth=text.depth + 1)

    for index, (kind, left, right) in enumerate(line.operations, start=line.n_inputs):
        if kind in _BINARY:
            level = _SUM if kind in ('add', 'sub') else _PRODUCT
            a, b = operand(left, level), operand(right, level - 1)
            sign = _BINARY[kind]
            if kind == 'add' and isinstance(right, float) and right < 0:
                sign, b = '-', operand(-right, _ATOM)
            text = _Text(f'{a.text} {sign} {b.text}', level, max(a.depth, b.depth),
                         a.leaves + b.leaves)
        elif kind == 'neg':
            a = operand(left, _PRODUCT)
            text = _Text(f'-{a.text}', _SUM, a.depth, a.leaves)
        else:
            a = operand(left, _SUM)
            text = _Text(f'{kind}({a.text})', _ATOM, a.depth + 1, a.leaves)
        if uses[index] > 1 or text.depth >= MAX_DEPTH:
            named.append((index, text))
            text = _leaf(index)
        texts[index] = text
    return named, [operand(output, _SUM) for output in line.outputs]
