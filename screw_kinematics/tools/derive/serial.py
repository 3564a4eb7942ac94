# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Kinematics of open chains: formulas as text and LaTeX, functions in Python and C."""
from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from .layout import LaTeX, Text
from .request import heading, near_notes, printable, Request
from ...chains.program import trace_chain
from ...chains.serial_chain import SerialChain
from ...errors import ToolError
from ...programs.c_text import c_header, c_source
from ...programs.latex_text import latex_rows
from ...programs.program import DERIVATIVES
from ...programs.python_text import named_source
from ...programs.quantities import Quantity
from ...programs.straight_line_program import StraightLineProgram
from ...screws.rigid import row_of_pose
from ...screws.se3 import Array


def serial_files(robot: Any, request: Request) -> dict[str, str]:
    """Return what is asked for of an open chain: text by the ending of its file."""
    if not isinstance(robot, SerialChain):
        raise ToolError(
            f'{robot.name}: a parallel robot has no closed form of its motion and no '
            'straight-line program, since its posture is searched for; as text and LaTeX in '
            'closed form there are its equations')
    if request.is_code:
        return _code(robot, request)
    if request.form == 'straight':
        return _straight_text(robot, request)
    return _closed_text(robot, request)


def _closed_text(robot: SerialChain, request: Request) -> dict[str, str]:
    """Return one formula a line."""
    write: Text = Text() if request.language == 'text' else LaTeX()
    notes = near_notes([robot], request.tolerance)
    blocks = [write.comment(heading(robot, request, notes))]
    for quantity in request.quantities:
        values = _derived(robot, quantity, request)
        rows: list[tuple[str, str, str]]
        if quantity.per:
            names = robot.joint_names if quantity.name == 'jacobian' \
                else tuple(joint.name for joint in robot.joints)
            letter = '$' if quantity.name == 'screws' else 'J'
            rows = [(write.named(letter, f'_{k}'), write.vector(column), printable(name))
                    for k, (name, column) in enumerate(zip(names, values), start=1)]
        else:
            labels = write.labels(quantity)
            rows = [(label, write.expression(x), '') for label, x in zip(labels, values.ravel())]
        blocks.append(write.block(quantity.described(), rows))
    return {write.ending: '\n\n'.join(blocks) + '\n'}


def _straight_text(robot: SerialChain, request: Request) -> dict[str, str]:
    """Return named terms, each computed once, and the quantities made of them."""
    line, inputs, outputs = _straight(robot, request)
    if request.language == 'text':
        return {'.txt': named_source(line, request.function, inputs, outputs,
                                     '\n'.join(_about(robot, request)))}
    labels = [label for quantity in request.quantities for label in _labels(robot, quantity)]
    rows = latex_rows(line, [f'{key}{k}' for key, n in inputs.items()
                             for k in range(1, n + 1)], labels)
    write = LaTeX()
    blocks = [write.comment(_about(robot, request)),
              '\n'.join(['\\begin{align*}', ' \\\\\n'.join(f'  {a} &= {b}' for a, b in rows),
                         '\\end{align*}'])]
    return {'.tex': '\n'.join(blocks) + '\n'}


def _labels(robot: SerialChain, quantity: Quantity) -> list[str]:
    """Return the LaTeX names of the numbers of a quantity."""
    if not quantity.per:
        return quantity.latex_components()
    count = quantity.size(robot.dof, len(robot.joints)) // 6
    if quantity.name == 'screws':
        return [rf'\${{}}_{{{j},{k}}}' for j in range(1, count + 1) for k in range(1, 7)]
    return [f'J_{{{k},{j}}}' for k in range(1, 7) for j in range(1, count + 1)]


def _code(robot: SerialChain, request: Request) -> dict[str, str]:
    """Return a function that runs; both forms have the same parameters and results."""
    make = _straight if request.form == 'straight' else _closed
    line, inputs, outputs = make(robot, request)
    about = '\n'.join(_about(robot, request))
    name = request.function
    if request.language == 'c':
        return {'.c': c_source(line, name, inputs, outputs),
                '.h': c_header(name, inputs, outputs, about)}
    return {'.py': 'from math import cos, sin, sqrt\n\n\n'
                   + named_source(line, name, inputs, outputs, about)}


def _straight(robot: SerialChain, request: Request,
              ) -> tuple[StraightLineProgram, dict[str, int], dict[str, int]]:
    names = tuple(quantity.name for quantity in request.quantities)
    line = trace_chain(robot, names, request.axes, request.pole)
    return line, _inputs(robot, request), _outputs(robot, request)


def _closed(robot: SerialChain, request: Request,
            ) -> tuple[StraightLineProgram, dict[str, int], dict[str, int]]:
    from ...symbolic.expressions import joint_symbols
    from ...symbolic.printing import traced
    values = [x for quantity in request.quantities
              for x in _by_rows(quantity, _derived(robot, quantity, request))]
    symbols = np.concatenate(joint_symbols(robot.dof, request.order))
    return traced(values, list(symbols)), _inputs(robot, request), _outputs(robot, request)


def _inputs(robot: SerialChain, request: Request) -> dict[str, int]:
    return {key: robot.dof for key in DERIVATIVES[:request.order + 1]}


def _outputs(robot: SerialChain, request: Request) -> dict[str, int]:
    return {quantity.name: quantity.size(robot.dof, len(robot.joints))
            for quantity in request.quantities}


def _by_rows(quantity: Quantity, values: Array) -> Iterator[Any]:
    """Give the numbers as programs have them: a Jacobian's columns are not its rows."""
    yield from (values.T if quantity.name == 'jacobian' else values).ravel()


def _about(robot: SerialChain, request: Request) -> list[str]:
    rows = heading(robot, request)
    if request.is_code or request.form == 'straight':
        rows += ['', 'Inputs: ' + ', '.join(f'{key} ({robot.dof})' for key in
                                            _inputs(robot, request)) + '. Results:']
    for quantity, size in zip(request.quantities, _outputs(robot, request).values()):
        by = {'screws': ', joint after joint', 'jacobian': ', six rows'}.get(quantity.name, '')
        rows.append(f'{quantity.name} ({size}{by}): {quantity.described()}')
    return rows


def _derived(robot: SerialChain, quantity: Quantity, request: Request) -> Array:
    """Return a quantity in symbols, shape (6,), (12,), or (joints, 6) for screws, columns."""
    from ...symbolic.exact import exact_chain, sympy_array
    from ...symbolic.expressions import joint_symbols, simplify, symbolic_state
    order = max(quantity.order, 1)
    q, *rates = joint_symbols(robot.dof, order)
    found = symbolic_state(robot, order, simplified=False, tolerance=request.tolerance)
    exact = exact_chain(robot, request.tolerance)
    if quantity.name == 'pose':
        values = row_of_pose(found.pose)
    elif quantity.name == 'jacobian':
        values = exact.jacobian(q, request.pole, request.axes).T
    elif quantity.name == 'screws':
        values = exact.screws(q, request.pole)
        if request.axes == 'tip':
            values = values.reshape(-1, 2, 3) @ found.pose[:3, :3]
            values = values.reshape(-1, 6)
    elif quantity.name == 'coriolis_lie':
        values = exact.coriolis_lie(q, rates[0], request.pole, request.axes)
    else:
        values = quantity.of(found.about(request.pole).expressed_in(request.axes))
    values = sympy_array(values)
    return np.asarray(simplify(values, rates) if request.simplified else values)
