# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Formulas as text: LaTeX to read, Python and C to run.

What SymPy's printers make of the expressions of :mod:`~screw_kinematics.symbolic`, with
common subexpressions shared. For a fast program of a whole robot see
:meth:`~screw_kinematics.SerialChain.compile`, which needs no SymPy.
"""
from __future__ import annotations

from collections.abc import Mapping, Sequence
import keyword
import re
from typing import Any

import numpy as np

from ..errors import InvalidValueError, MissingExtraError

try:
    import sympy
except ImportError as error:
    raise MissingExtraError('sympy', 'symbolic', 'writing formulas') from error

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
        Source text of the function, after ``import math``.

    Raises
    ------
    InvalidValueError
        A symbol of the outputs is not among the arguments, or a name is no identifier.

    Examples
    --------
    >>> x, y = sympy.symbols('x y')
    >>> print(python_source('area', {'value': sympy.sin(x) * y}))
    import math
    <BLANKLINE>
    <BLANKLINE>
    def area(x, y):
        return {
            'value': y*math.sin(x),
        }
    <BLANKLINE>

    """
    shared, values, symbols = _shared(name, outputs, arguments)
    lines = ['import math', '', '', f'def {name}({", ".join(map(str, symbols))}):']
    lines += [f'    {symbol} = {sympy.pycode(x)}' for symbol, x in shared]
    lines += ['    return {']
    for key, value in values.items():
        text = sympy.pycode(value) if isinstance(value, sympy.Basic) else \
            '[' + ', '.join(sympy.pycode(x) for x in value) + ']'
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
        value[0] = y*sin(x);
    }
    <BLANKLINE>

    """
    shared, values, symbols = _shared(name, outputs, arguments)
    flat = {key: [value] if isinstance(value, sympy.Basic) else value
            for key, value in values.items()}
    parameters = [f'double {s}' for s in symbols]
    parameters += [f'double {key}[{len(value)}]' for key, value in flat.items()]
    lines = ['#include <math.h>', '', f'void {name}({", ".join(parameters)})', '{']
    lines += [f'    const double {symbol} = {sympy.ccode(x)};' for symbol, x in shared]
    lines += [f'    {key}[{i}] = {sympy.ccode(x)};'
              for key, value in flat.items() for i, x in enumerate(value)]
    return '\n'.join([*lines, '}', ''])


def _shared(name: str, outputs: Mapping[str, Any], arguments: Sequence[Any] | None) \
        -> tuple[list[Any], dict[str, Any], list[Any]]:
    """Return common subexpressions, what is left of each output, and the arguments."""
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
    fresh = (s for s in sympy.numbered_symbols('t') if str(s) not in taken)
    shared, reduced = sympy.cse(flat, symbols=fresh)
    values, start = {}, 0
    for key, array in arrays.items():
        part = reduced[start:start + array.size]
        values[key] = part if array.ndim else part[0]
        start += array.size
    return shared, values, symbols


def _natural(symbol: Any) -> list[Any]:
    """Sort q2 before q10."""
    return [int(p) if p.isdigit() else p for p in re.split(r'(\d+)', symbol.name)]


def _latex_name(name: str) -> str:
    match = _COORDINATE.fullmatch(name)
    assert match is not None
    letter, dots, index = match[1].replace('theta', r'\theta'), len(match[2]), match[3]
    return (f'{_DOTS[dots]}{{{letter}}}' if dots else letter) + f'_{{{index}}}'
