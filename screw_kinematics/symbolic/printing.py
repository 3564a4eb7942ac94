# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Formulas as text: LaTeX to read, Python and C to run.

Expressions of SymPy are traced like the package's own: common terms are shared, and the
writers of programs write them. For a program of a whole robot see
:meth:`~screw_kinematics.SerialChain.compile`, which needs no SymPy.
"""
from __future__ import annotations

from collections.abc import Mapping, Sequence
import keyword
from math import prod
import re
from typing import Any

import numpy as np
import sympy

from ..errors import InvalidValueError
from ..programs.assignments import assignments
from ..programs.straight_line_program import StraightLineProgram
from ..programs.tracing import Graph, straight_line
from ..screws.vectors import cos, sin

_DOTS = {1: r'\dot', 2: r'\ddot', 3: r'\dddot', 4: r'\ddddot'}
_COORDINATE = re.compile(r'(q|theta)(d{0,4})(\d+)')


def latex(x: Any) -> str:
    r"""
    Return an expression or array as LaTeX, the coordinates' derivatives with dots.

    Parameters
    ----------
    x : expression, or array of at most two axes
        A six-vector becomes a column.

    Returns
    -------
    str
        For math mode; needs ``amsmath`` for matrices and for more than two dots.

    Examples
    --------
    >>> q1, qd1 = sympy.symbols('q1 qd1')
    >>> latex(qd1 * sympy.cos(q1))
    '\\dot{q}_{1} \\cos{\\left(q_{1} \\right)}'

    """
    x = np.asarray(x, dtype=object)
    value = sympy.Matrix(x.tolist()) if x.ndim else sympy.sympify(x[()])
    return str(sympy.latex(value, mat_str='bmatrix', mat_delim='', symbol_names={
        s: _latex_name(s.name) for s in value.free_symbols if _COORDINATE.fullmatch(s.name)}))


def python_source(name: str, outputs: Mapping[str, Any],
                  arguments: Sequence[Any] | None = None) -> str:
    """
    Return a Python function of the formulas, which needs only the module ``math``.

    Parameters
    ----------
    name : str
        Name of the function.
    outputs : mapping of str to expression or array
        What it returns: a dictionary of numbers and of flat lists of numbers.
    arguments : sequence of symbols, optional
        Its parameters, in order; by default all symbols, sorted by name.

    Returns
    -------
    str
        Source text, with what it imports.

    Raises
    ------
    InvalidValueError
        A symbol of the outputs is not among the arguments, or a name is no identifier.

    Examples
    --------
    >>> x, y = sympy.symbols('x y')
    >>> print(python_source('area', {'value': sympy.sin(x) * y}))
    from math import cos, sin, sqrt
    <BLANKLINE>
    <BLANKLINE>
    def area(x, y):
        return {
            'value': y * sin(x),
        }
    <BLANKLINE>

    """
    body, values, symbols = _statements(name, outputs, arguments)
    lines = ['from math import cos, sin, sqrt', '', '',
             f'def {name}({", ".join(map(str, symbols))}):']
    lines += [f'    {target} = {expression}' for target, expression in body]
    lines += ['    return {']
    for key, value in values.items():
        text = value if isinstance(value, str) else f'[{", ".join(value)}]'
        lines.append(f'        {key!r}: {text},')
    return '\n'.join([*lines, '    }', ''])


def c_source(name: str, outputs: Mapping[str, Any],
             arguments: Sequence[Any] | None = None) -> str:
    """
    Return a C99 function of the formulas, which needs only ``math.h``.

    Parameters
    ----------
    name : str
        Name of the function.
    outputs : mapping of str to expression or array
        What it writes: each through a pointer of that name, arrays row by row.
    arguments : sequence of symbols, optional
        Its parameters, in order; by default all symbols, sorted by name.

    Returns
    -------
    str
        Source text.

    Raises
    ------
    InvalidValueError
        A symbol of the outputs is not among the arguments, or a name is no identifier.

    Examples
    --------
    >>> x, y = sympy.symbols('x y')
    >>> print(c_source('area', {'value': sympy.sin(x) * y}))
    #include <math.h>
    <BLANKLINE>
    void area(double x, double y, double value[1])
    {
        value[0] = y * sin(x);
    }
    <BLANKLINE>

    """
    body, values, symbols = _statements(name, outputs, arguments)
    flat = {key: [value] if isinstance(value, str) else value for key, value in values.items()}
    parameters = [f'double {s}' for s in symbols]
    parameters += [f'double {key}[{len(value)}]' for key, value in flat.items()]
    lines = ['#include <math.h>', '', f'void {name}({", ".join(parameters)})', '{']
    lines += [f'    const double {target} = {expression};' for target, expression in body]
    lines += [f'    {key}[{i}] = {expression};'
              for key, value in flat.items() for i, expression in enumerate(value)]
    return '\n'.join([*lines, '}', ''])


def traced(values: Sequence[Any], symbols: Sequence[Any]) -> StraightLineProgram:
    """
    Return the straight-line program of expressions, which reads the symbols in order.

    They are made of numbers, symbols, sums, products, powers, sines, cosines and tangents.

    Raises
    ------
    InvalidValueError
        An expression has a symbol that is not among these, or a function of another kind.

    Examples
    --------
    >>> x, y = sympy.symbols('x y')
    >>> traced([sympy.sin(x) * y, sympy.sin(x)], [x, y]).count()
    {'mul': 1, 'sin': 1}

    """
    inputs = Graph().inputs(len(symbols))
    known: dict[Any, Any] = dict(zip(symbols, inputs))
    expressions = [sympy.sympify(x).replace(sympy.tan, lambda a: sympy.sin(a) / sympy.cos(a))
                   for x in values]
    for expression in expressions:
        for node in sympy.postorder_traversal(expression):
            if node not in known:
                known[node] = _value(node, known)
    return straight_line(len(symbols), [known[expression] for expression in expressions])


def _value(node: Any, known: Mapping[Any, Any]) -> Any:
    """Return what a node of an expression is, its operands known."""
    if node.is_number:
        return float(node)
    operands = [known[argument] for argument in node.args]
    if node.is_Add:
        return sum(operands[1:], operands[0])
    if node.is_Mul:
        return prod(operands[1:], start=operands[0])
    if node.is_Pow and node.exp.is_number:
        twice = round(float(2 * node.exp))
        if twice == 2 * node.exp:
            base = operands[0]
            whole = prod([base] * (abs(twice) // 2), start=base.sqrt() if twice % 2 else 1.0)
            return 1.0 / whole if twice < 0 else whole
    if isinstance(node, (sympy.sin, sympy.cos)):
        return (sin if isinstance(node, sympy.sin) else cos)(operands[0])
    what = 'symbol' if node.is_Symbol else 'expression'
    raise InvalidValueError(f'the {what} {node} cannot be written as a program of the symbols '
                            f'{", ".join(map(str, (s for s in known if s.is_Symbol)))}')


def _statements(name: str, outputs: Mapping[str, Any], arguments: Sequence[Any] | None) \
        -> tuple[tuple[tuple[str, str], ...], dict[str, Any], list[Any]]:
    """Return assignments, the expressions of each output after them, and the arguments."""
    arrays = {key: np.asarray(value, dtype=object) for key, value in outputs.items()}
    flat = [sympy.sympify(x) for value in arrays.values() for x in value.ravel()]
    present = set().union(*(x.free_symbols for x in flat))
    symbols = sorted(present, key=_natural) if arguments is None \
        else [s for group in arguments for s in np.ravel(group)]
    missing = sorted(map(str, present - set(symbols)))
    if missing:
        raise InvalidValueError(f'{name}: the outputs contain the symbols {missing}, which '
                                f'are not among the arguments {list(map(str, symbols))}')
    for word in (name, *map(str, symbols), *outputs):
        if not word.isidentifier() or not word.isascii() or keyword.iskeyword(word):
            raise InvalidValueError(f'{name}: {word!r} is no identifier of Python and C')
    taken = {*map(str, symbols), *outputs}
    letter = 't'
    while any(word.startswith(letter) for word in taken):
        letter += 't'
    text = assignments(traced(flat, symbols), list(map(str, symbols)),
                       (letter + '{}').format, reuse=False)
    values, start = {}, 0
    for key, array in arrays.items():
        part = text.outputs[start:start + array.size]
        values[key] = list(part) if array.ndim else part[0]
        start += array.size
    return text.body, values, symbols


def _natural(symbol: Any) -> list[Any]:
    """Sort q2 before q10."""
    return [int(p) if p.isdigit() else p for p in re.split(r'(\d+)', symbol.name)]


def _latex_name(name: str) -> str:
    match = _COORDINATE.fullmatch(name)
    assert match is not None
    letter, dots, index = match[1].replace('theta', r'\theta'), len(match[2]), match[3]
    return (f'{_DOTS[dots]}{{{letter}}}' if dots else letter) + f'_{{{index}}}'
