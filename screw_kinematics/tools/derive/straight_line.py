# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Kinematics of open chains as straight-line programs in Python or C."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .closed_form import heading
from ...chains.serial_chain import SerialChain
from ...errors import ToolError
from ...programs.c_text import c_header, c_source
from ...programs.program import DERIVATIVES
from ...programs.python_text import python_source
from ...programs.quantities import Quantity


def straight_line_files(robot: Any, quantities: Sequence[Quantity], language: str, name: str,
                        axes: str, pole: str) -> dict[str, str]:
    """
    Return the program of some quantities as source text.

    Parameters
    ----------
    robot : SerialChain
        An open chain.
    quantities : sequence of Quantity
        The outputs, in order.
    language : {'text', 'python', 'c'}
        Text is Python without the rest of the file.
    name : str
        Name of the function.
    axes, pole : {'base', 'tip'}
        Axes of the vectors, and reference point of the linear parts.

    Returns
    -------
    dict of str to str
        Text by the ending of its file.

    Raises
    ------
    ToolError
        The robot is not an open chain.

    """
    if not isinstance(robot, SerialChain):
        raise ToolError(f'{robot.name}: there are straight-line programs of open chains only')
    program = robot.compile(tuple(q.name for q in quantities), axes, pole)
    about = [*heading(robot, name, axes, pole), '', 'Returns, one after the other:']
    about += [f'{part.start:>3} ... {part.stop - 1}  {q.name}: {q.described()}'
              for q, part in zip(quantities, program.slices.values())]
    if language == 'c':
        inputs = {derivative: program.dof for derivative in DERIVATIVES[:program.order + 1]}
        sizes = {output: part.stop - part.start for output, part in program.slices.items()}
        return {'.c': c_source(program.line, name, inputs, sizes),
                '.h': c_header(name, inputs, sizes, '\n'.join(about))}
    docstring = '\n'.join(['', *(f'    {row}'.rstrip() for row in about), '', '    '])
    source = python_source(program.line, program.input_names, name, docstring)
    if language == 'text':
        return {'.txt': source}
    return {'.py': 'from math import cos, sin, sqrt\n\n\n' + source}
