# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Rows of equations as plain text and as LaTeX."""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from ...programs.quantities import Quantity

_DIGITS = 12


def _short(x: Any) -> Any:
    """Return an expression whose long fractions are decimal numbers."""
    import sympy
    x = sympy.sympify(x)
    return x.xreplace({r: sympy.Float(r, _DIGITS) for r in x.atoms(sympy.Rational)
                       if r.q > 10 ** 6})


class Text:
    """Plain text."""

    ending, direction, klein = '.txt', 'd/|d|', '{W; %s}'
    term, lie_product, multiple = '({})*{}', '[{}, {}]', '{}*{}'

    def comment(self, rows: Sequence[str]) -> str:
        """Return rows of words."""
        return '\n'.join(rows)

    def named(self, letter: str, index: str) -> str:
        """Return a letter with an index, given as _1."""
        return letter + index.replace('_', '')

    def labels(self, quantity: Quantity) -> list[str]:
        """Return the names of the components of a quantity."""
        return quantity.components()

    def expression(self, x: Any) -> str:
        """Return an expression."""
        return str(_short(x))

    def vector(self, vector: Any) -> str:
        """Return a vector or six-vector."""
        parts = [', '.join(map(self.expression, vector[k:k + 3]))
                 for k in range(0, len(vector), 3)]
        return f'[{"; ".join(parts)}]'

    def total(self, terms: Sequence[tuple[Any, Any]]) -> str:
        """Return a sum of coefficients times symbols."""
        kept = [(self.expression(x), self.expression(s)) for x, s in terms if x != 0]
        return ' + '.join(s if x == '1' else self.term.format(x, s) for x, s in kept) or '0'

    def bracket(self, left: str, right: str, factor: Any = 1) -> str:
        """Return a Lie product times a factor."""
        text = self.lie_product.format(left, right)
        return text if factor == 1 else self.times(factor, text)

    def times(self, factor: Any, name: str) -> str:
        """Return a vector times a factor."""
        return self.multiple.format(self.expression(factor), name)

    def block(self, title: str, rows: Iterable[tuple[str, str, str]]) -> str:
        """Return equations under a title."""
        return '\n'.join([title, *(f'{a} = {b}' + (f'    ({c})' if c else '')
                                   for a, b, c in rows)])

    def rows(self, rows: Iterable[tuple[str, str, str]]) -> str:
        """Return equations, each with a remark."""
        return '\n'.join(f'  {a} = {b}' + (f'    ({c})' if c else '') for a, b, c in rows)


class LaTeX(Text):
    """Aligned equations."""

    ending, direction, klein = '.tex', r'd / \lVert d \rVert', r'\{W; %s\}'
    term, lie_product, multiple = r'\left({}\right) {}', r'\left[{}, {}\right]', '{} {}'

    def comment(self, rows: Sequence[str]) -> str:
        """Return comments."""
        return '\n'.join(f'% {row}'.rstrip() for row in rows)

    def named(self, letter: str, index: str) -> str:
        """Return a letter with an index, given as _1."""
        return letter.replace('$', r'\$') + (f'_{{{index[1:]}}}' if index else '')

    def labels(self, quantity: Quantity) -> list[str]:
        """Return the names of the components of a quantity."""
        return quantity.latex_components()

    def expression(self, x: Any) -> str:
        """Return an expression."""
        from ...symbolic.printing import latex
        return latex(_short(x))

    def vector(self, vector: Any) -> str:
        """Return a column."""
        return r'\begin{bmatrix}' + r' \\ '.join(map(self.expression, vector)) + r'\end{bmatrix}'

    def block(self, title: str, rows: Iterable[tuple[str, str, str]]) -> str:
        """Return equations under a title."""
        return '\n'.join([f'% {title}', self.rows(rows)])

    def rows(self, rows: Iterable[tuple[str, str, str]]) -> str:
        """Return equations, each with a remark."""
        lines = [f'  {a} &= {b}' + (rf' && \text{{{_plain(c)}}}' if c else '')
                 for a, b, c in rows]
        return '\n'.join(['\\begin{aligned}', ' \\\\\n'.join(lines), '\\end{aligned}'])


def _plain(text: str) -> str:
    """Return text without what means something in LaTeX."""
    return ''.join(c if c.isalnum() or c in ' -;[]' else r'\_' if c == '_' else '?'
                   for c in text)
