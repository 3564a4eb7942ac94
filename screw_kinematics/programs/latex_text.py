# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The program as LaTeX: named intermediate terms, each written once, as a paper prints them."""
from __future__ import annotations

from collections.abc import Sequence
import re

from .assignments import assignments
from .straight_line_program import StraightLineProgram

_DOTS = {'q': 'q', 'qd': r'\dot{q}', 'qdd': r'\ddot{q}', 'qddd': r'\dddot{q}',
         'qdddd': r'\ddddot{q}'}
_TOKEN = re.compile(r'(?P<number>\d+\.?\d*(?:e[+-]?\d+)?)|(?P<name>[A-Za-z]+)(?P<index>\d*)')


def latex_rows(line: StraightLineProgram, input_names: Sequence[str],
               output_names: Sequence[str]) -> list[tuple[str, str]]:
    r"""
    Return the equations of a program, left and right sides: its terms, then its outputs.

    Examples
    --------
    >>> from screw_kinematics.programs.tracing import Graph, straight_line
    >>> x, y = Graph().inputs(2)
    >>> latex_rows(straight_line(2, [x.sin() * y, x.sin() + 2]), ['q1', 'qd1'], ['a', 'b'])[0]
    ('t_{1}', '\\sin \\left( q_{1} \\right)')

    """
    text = assignments(line, input_names, lambda k: f't{k + 1}', reuse=False)
    return [(_latex(name), _latex(expression)) for name, expression in text.body] + [
        (name, _latex(expression)) for name, expression in zip(output_names, text.outputs)]


def _latex(text: str) -> str:
    """Return an expression in the syntax of Python and C as LaTeX."""
    text = _TOKEN.sub(_token, text)
    text = text.replace(' * ', r' \, ').replace('(', r'\left( ').replace(')', r' \right)')
    return re.sub(r'(sin|cos|sqrt)\\left', r'\\\1 \\left', text)


def _token(match: re.Match[str]) -> str:
    if match['number']:
        mantissa, _, exponent = match['number'].partition('e')
        mantissa = mantissa[:-2] if mantissa.endswith('.0') else mantissa
        return mantissa + (rf' \cdot 10^{{{int(exponent)}}}' if exponent else '')
    if not match['index']:
        return match['name']
    return f'{_DOTS.get(match["name"], match["name"])}_{{{match["index"]}}}'
