# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The program as the text of one Python function of floats, which needs nothing but ``math``."""
from __future__ import annotations

from collections.abc import Callable, Mapping
import math
from typing import Any

from .assignments import assignments
from .straight_line_program import StraightLineProgram


def named_source(line: StraightLineProgram, name: str, inputs: Mapping[str, int],
                 outputs: Mapping[str, int], comment: str = '') -> str:
    """
    Return the text of a Python function whose parameters and results have names.

    Inputs and outputs are names of the sequences it takes and of those in the dictionary it
    returns, and how many numbers each has; the comment is for its docstring.

    Examples
    --------
    >>> from screw_kinematics.programs.tracing import Graph, straight_line
    >>> x, y = Graph().inputs(2)
    >>> print(named_source(straight_line(2, [x.sin() * y, x]), 'f', {'q': 2}, {'a': 2}))
    def f(q):
        q1, q2, = q
        return {
            'a': (q2 * sin(q1), q1),
        }
    <BLANKLINE>

    """
    names = [f'{key}{k}' for key, n in inputs.items() for k in range(1, n + 1)]
    text = assignments(line, names)
    rows = [f'def {name}({", ".join(inputs)}):']
    if comment:
        safe = comment.replace('\\', '\\\\').replace('"', "'")     # names hold anything
        rows += [f'    {row}'.rstrip() for row in ['"""', *safe.splitlines(), '', '"""']]
    for key, n in inputs.items():
        if n:
            rows.append(f'    {", ".join(f"{key}{k}" for k in range(1, n + 1))}, = {key}')
    rows += [f'    {target} = {expression}' for target, expression in text.body]
    rows.append('    return {')
    values = iter(text.outputs)
    for key, n in outputs.items():
        rows.append(f'        {key!r}: ({", ".join(next(values) for _ in range(n))}'
                    + (',' if n == 1 else '') + '),')
    return '\n'.join([*rows, '    }', ''])


def python_function(line: StraightLineProgram, sin: Callable[..., Any], cos: Callable[..., Any],
                    sqrt: Callable[..., Any] = math.sqrt) -> Callable[..., Any]:
    """Return the program as a function from a sequence, of floats or arrays, to a tuple."""
    names = [f'i{k}' for k in range(line.n_inputs)]
    text = assignments(line, names)
    # The functions are defaults, so that the interpreter finds them among the locals.
    rows = ['def evaluate(values, sin=sin, cos=cos, sqrt=sqrt):']
    if names:
        rows += [f'    {", ".join(names)}, = values']
    rows += [f'    {target} = {expression}' for target, expression in text.body]
    rows += [f'    return {", ".join(text.outputs)},']
    scope = {'sin': sin, 'cos': cos, 'sqrt': sqrt}
    exec(compile('\n'.join(rows), '<screw_kinematics program>', 'exec'), scope)
    return scope['evaluate']
