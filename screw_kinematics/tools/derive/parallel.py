# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Equations of parallel robots as text and LaTeX."""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from ...errors import ToolError
from ...programs.quantities import Quantity

_DIGITS = 12


def parallel_form(robot: Any, quantities: Sequence[Quantity], language: str, name: str,
                  ) -> dict[str, str]:
    """
    Return a parallel robot's equations of velocity and acceleration.

    Parameters
    ----------
    robot : ParallelManipulator
        The robot.
    quantities : sequence of Quantity
        Of 'twist', 'reduced_accel' and 'accel', which asks for the same equations.
    language : {'text', 'latex'}
        How to write it.
    name : str
        Name of the robot in the title.

    Returns
    -------
    dict of str to str
        Text by the ending of its file.

    Raises
    ------
    ToolError
        Another quantity is wanted.

    """
    from ...symbolic.parallel import ParallelFormulas
    for quantity in quantities:
        if quantity.order not in (1, 2):
            raise ToolError(f'{robot.name}: {quantity.name}: for parallel robots there are the '
                            'equations of twist, accel and reduced_accel')
    order = max(quantity.order for quantity in quantities)
    write = _Text() if language == 'text' else _Latex()
    formulas = ParallelFormulas(robot)
    blocks = [write.comment(_heading(robot, formulas, name, order))]
    for limb in formulas.limbs:
        blocks.append(write.comment([f'{limb.name}: unit screws [w; v] about p']))
        blocks.append(write.rows(
            (write.named('$', f'_{k}'), write.vector(screw), joint) for k, (joint, screw)
            in enumerate(zip(limb.joints, limb.screws), start=1)))
        if order > 1:
            pairs = [write.product(i + 1, j + 1, limb.rates[i] * limb.rates[j])
                     for i, j in combinations(range(len(limb.joints)), 2)]
            blocks.append(write.rows([(write.named('L', ''), ' + '.join(pairs), '')]))
        for wrench in limb.wrenches:
            what = 'constraint' if wrench.constraint else 'actuation'
            blocks.append(write.comment([f'{limb.name}, {what}: {wrench.meaning}']))
            rows = []
            if wrench.along is not None:
                rows = [(write.named('d', ''), write.vector(wrench.along), ''),
                        (write.vector(wrench.unit), write.direction, '')]
            rows.append((write.named('W', ''), write.vector(wrench.screw), '[force; moment]'))
            rows += [(*row, '') for row in _equations(write, formulas, wrench, order)]
            blocks.append(write.rows(rows))
    ending = '.txt' if language == 'text' else '.tex'
    return {ending: '\n'.join(blocks) + '\n'}


def _heading(robot: Any, formulas: Any, name: str, order: int) -> list[str]:
    """Return lines that say what the symbols are."""
    angles = [f'theta{k} = {joint}' for k, joint in enumerate(robot.passive_joint_names, 1)]
    rows = [
        f'{name}: motion of {robot.tip_frame} relative to {robot.base_frame}; '
        f'mobility {robot.mobility}',
        f'axes of {robot.base_frame}; p is the origin of {robot.tip_frame}, the reference point',
        'rotation matrix of the platform, by rows: '
        + ', '.join(map(str, formulas.rotation.ravel())),
        'actuated: ' + ', '.join(f'q{k} = {j}' for k, j in enumerate(robot.joint_names, 1)),
        'passive: ' + ', '.join(angles),
        'qd, qdd, thetad: time derivatives; rad, m, s',
        'twist [w; v]: what is not named is always zero']
    if order > 1:
        rows.append('reduced acceleration [alpha; A]: A = a - w x v with the classical a')
        rows.append('L: Lie products of the screws times the rates of their joints, {W; L} is '
                    'the Klein form')
    return [''.join(c if c.isprintable() else '?' for c in row) for row in rows]


def _equations(write: Any, formulas: Any, wrench: Any, order: int) -> Iterable[tuple[str, str]]:
    """Give the equations of a wrench: left and right sides."""
    import sympy
    row = np.roll(wrench.screw, 3)
    for n, (angular, linear) in enumerate((('w', 'v'), ('alpha', 'A'))[:order], start=1):
        names = [sympy.Symbol(f'{part}_{axis}') for part in (angular, linear) for axis in 'xyz']
        left = write.total([(row[k], names[k]) for k in formulas.moving[n - 1]])
        right = write.total([(x, formulas.q[n][k]) for k, x in wrench.work.items()])
        if n == 2:
            product = write.klein
            right = product if not wrench.work else f'{right} + {product}'
        if (left, right) != ('0', '0'):
            yield left, right


def _short(x: Any) -> Any:
    """Return an expression whose long fractions are decimal numbers."""
    import sympy
    x = sympy.sympify(x)
    return x.xreplace({r: sympy.Float(r, _DIGITS) for r in x.atoms(sympy.Rational)
                       if r.q > 1000})


class _Text:
    """Plain text."""

    direction, klein = 'd/|d|', '{W; L}'

    def comment(self, rows: Sequence[str]) -> str:
        return '\n'.join(['', *rows])

    def named(self, letter: str, index: str) -> str:
        return letter + index.replace('_', '')

    def expression(self, x: Any) -> str:
        return str(_short(x))

    def vector(self, vector: Any) -> str:
        parts = [', '.join(map(self.expression, vector[k:k + 3]))
                 for k in range(0, len(vector), 3)]
        return f'[{"; ".join(parts)}]'

    def total(self, terms: Sequence[tuple[Any, Any]]) -> str:
        kept = [(self.expression(x), symbol) for x, symbol in terms if x != 0]
        return ' + '.join(str(s) if x == '1' else f'({x})*{s}' for x, s in kept) or '0'

    def product(self, i: int, j: int, factor: Any) -> str:
        return f'{self.expression(factor)}*[${i}, ${j}]'

    def rows(self, rows: Iterable[tuple[str, str, str]]) -> str:
        return '\n'.join(f'  {a} = {b}' + (f'    ({c})' if c else '') for a, b, c in rows)


class _Latex(_Text):
    """Aligned equations."""

    direction, klein = r'd / \lVert d \rVert', r'\{W; L\}'

    def comment(self, rows: Sequence[str]) -> str:
        return '\n'.join(['', *(f'% {row}' for row in rows)])

    def named(self, letter: str, index: str) -> str:
        return letter.replace('$', r'\$') + index

    def expression(self, x: Any) -> str:
        from ...symbolic.printing import latex
        return latex(_short(x))

    def vector(self, vector: Any) -> str:
        return r'\begin{bmatrix}' + r' \\ '.join(map(self.expression, vector)) + r'\end{bmatrix}'

    def total(self, terms: Sequence[tuple[Any, Any]]) -> str:
        kept = [(self.expression(x), self.expression(s)) for x, s in terms if x != 0]
        return ' + '.join(s if x == '1' else rf'\left({x}\right) {s}' for x, s in kept) or '0'

    def product(self, i: int, j: int, factor: Any) -> str:
        return rf'{self.expression(factor)} \left[\$_{i}, \$_{j}\right]'

    def rows(self, rows: Iterable[tuple[str, str, str]]) -> str:
        lines = [f'  {a} &= {b}' + (rf' && \text{{{self._plain(c)}}}' if c else '')
                 for a, b, c in rows]
        return '\n'.join(['\\begin{aligned}', ' \\\\\n'.join(lines), '\\end{aligned}'])

    @staticmethod
    def _plain(text: str) -> str:
        """Return text without what means something in LaTeX."""
        return ''.join(c if c.isalnum() or c in ' -;[]' else r'\_' if c == '_' else '?'
                       for c in text)
