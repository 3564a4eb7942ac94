# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Kinematics of open chains as formulas: text, LaTeX, or a Python or C function of them."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...chains.serial_chain import SerialChain
from ...errors import ToolError
from ...programs.quantities import Quantity
from ...screws.rigid import row_of_pose
from ...screws.se3 import Array


def closed_form(robot: Any, quantities: Sequence[Quantity], language: str, name: str,
                axes: str, pole: str, simplified: bool) -> dict[str, str]:
    """
    Return the formulas of quantities, one component a line.

    Parameters
    ----------
    robot : SerialChain
        An open chain.
    quantities : sequence of Quantity
        What to derive.
    language : {'text', 'latex'}
        How to write it.
    name : str
        Name of the robot in the title.
    axes, pole : {'base', 'tip'}
        Axes of the vectors, and reference point of the linear parts.
    simplified : bool
        Whether to simplify.

    Returns
    -------
    dict of str to str
        Text by the ending of its file.

    Raises
    ------
    ToolError
        The robot is not an open chain.

    """
    from ...symbolic.printing import latex
    is_text = language == 'text'
    blocks = ['\n'.join(('' if is_text else '% ') + row
                        for row in heading(robot, name, axes, pole))]
    for quantity in quantities:
        values = _derive(robot, quantity, axes, pole, simplified)
        title = quantity.described()
        if is_text:
            rows = [f'{label} = {value}' for label, value in _labelled(quantity, values, False)]
            blocks.append('\n'.join([title, *rows]))
        else:
            rows = [f'  {label} &= {latex(value)}'
                    for label, value in _labelled(quantity, values, True)]
            blocks.append('\n'.join([f'% {title}', '\\begin{aligned}', ' \\\\\n'.join(rows),
                                     '\\end{aligned}']))
    return {'.txt' if is_text else '.tex': '\n\n'.join(blocks) + '\n'}


def closed_source(robot: Any, quantities: Sequence[Quantity], language: str, name: str,
                  axes: str, pole: str, simplified: bool) -> dict[str, str]:
    """
    Return a Python or C function of the formulas; parameters as :func:`closed_form`.

    Raises
    ------
    ToolError
        The robot is not an open chain.

    """
    from ...symbolic.expressions import coordinates
    from ...symbolic.printing import c_source, python_source
    outputs = {q.name: _derive(robot, q, axes, pole, simplified) for q in quantities}
    order = max(q.order for q in quantities)
    make, mark = (python_source, '#') if language == 'python' else (c_source, '//')
    meaning = [f'{q.name}: {q.described()}' for q in quantities]
    comments = [f'{mark} {row}' for row in [*heading(robot, name, axes, pole), *meaning]]
    text = '\n'.join([*comments, make(name, outputs, coordinates(robot.dof, order))])
    return {'.py' if language == 'python' else '.c': text}


def heading(robot: Any, name: str, axes: str, pole: str) -> list[str]:
    """Return lines that say what is derived: robot, frames, joints."""
    frame = {'base': robot.base_frame, 'tip': robot.tip_frame}
    where = f'origin of {robot.tip_frame}' if pole == 'tip' else (
        f'the point of {robot.tip_frame} now at the origin of {robot.base_frame}')
    joints = ', '.join(f'q{i} = {joint}' for i, joint in enumerate(robot.joint_names, 1))
    rows = [f'{name}: motion of {robot.tip_frame} relative to {robot.base_frame}',
            f'axes of {frame[axes]}; reference point: {where}',
            f'{joints}; qd, qdd, ... their time derivatives; rad, m, s']
    # The rows become comments in source text, which names out of a file must not end.
    return [''.join(c if c.isprintable() and c not in '"\\*' else '?' for c in row)
            for row in rows]


def _derive(robot: Any, quantity: Quantity, axes: str, pole: str, simplified: bool) -> Array:
    """Return a quantity in symbols, shape (6,), or (12,) for the pose as programs have it."""
    from ...symbolic.expressions import coordinates, simplify, state
    if not isinstance(robot, SerialChain):
        raise ToolError(f'{robot.name}: there are closed forms of open chains only')
    found = state(robot, max(quantity.order, 1), simplified=False)
    if quantity.order == 0:
        values = row_of_pose(found.pose)
    else:
        found = found.about(pole).expressed_in(axes)
        values = found.reduced[quantity.order - 1] if quantity.name.startswith('reduced') \
            else found.classical(quantity.order)
    if simplified:
        values = simplify(values, coordinates(robot.dof, quantity.order)[1:])
    return np.asarray(values)


def _labelled(quantity: Quantity, values: Array, latex: bool) -> list[tuple[str, Any]]:
    if quantity.order:
        labels = quantity.latex_components() if latex else quantity.components()
        return list(zip(labels, values))
    left, right = ('_{', '}') if latex else ('_', '')
    labels = [f'p{left}{axis}{right}' for axis in 'xyz']
    labels += [f'R{left}{i}{j}{right}' for i in '123' for j in '123']
    return list(zip(labels, values))
