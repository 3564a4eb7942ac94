# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A compiled chain as a C99 function, with its header."""
from __future__ import annotations

from collections.abc import Sequence

from ..backends.statements import assignments
from ..program import DERIVATIVES, Program


def c_files(program: Program, name: str, about: Sequence[str]) -> dict[str, str]:
    """
    Return source and header of a function that needs only ``math.h``.

    Parameters
    ----------
    program : Program
        What it computes.
    name : str
        Name of the function and of its files.
    about : sequence of str
        What to say of it: frames, order of the joints, units.

    Returns
    -------
    dict of str to str
        Text by the ending of its file.

    """
    motion = DERIVATIVES[:program.order + 1]
    parameters = [f'const double {derivative}[{program.dof}]' for derivative in motion]
    parameters += [f'double {output}[{part.stop - part.start}]'
                   for output, part in program.slices.items()]
    prototype = f'void {name}(' + ',\n    '.join(parameters) + ')'
    comment = '\n'.join(f' * {row}'.rstrip() for row in about)
    return {'.c': _source(program, name, motion, prototype, comment),
            '.h': _header(program, name, prototype, comment)}


def _source(program: Program, name: str, motion: Sequence[str], prototype: str,
            comment: str) -> str:
    inputs = [f'{derivative}[{k}]' for derivative in motion for k in range(program.dof)]
    text = assignments(program.line, inputs)
    rows = ['/*', comment, ' */', f'#include "{name}.h"', '', '#include <math.h>', '',
            prototype, '{']
    for k in range(0, len(text.names), 10):
        rows.append(f'    double {", ".join(text.names[k:k + 10])};')
    # Not every motion moves every output: without this, compilers warn of unused arguments.
    rows += [f'    (void){derivative};' for derivative in motion]
    rows += [f'    {target} = {expression};' for target, expression in text.body]
    for output, part in program.slices.items():
        rows += [f'    {output}[{k}] = {expression};'
                 for k, expression in enumerate(text.outputs[part])]
    return '\n'.join([*rows, '}', ''])


def _header(program: Program, name: str, prototype: str, comment: str) -> str:
    guard = f'{name.upper()}_H'
    lengths = ', '.join(DERIVATIVES[:program.order + 1])
    return '\n'.join([
        '/*', comment, ' */', f'#ifndef {guard}', f'#define {guard}', '',
        f'/* Number of measured joints, the length of {lengths}. */',
        f'#define {name.upper()}_DOF {program.dof}', '',
        '#ifdef __cplusplus', 'extern "C" {', '#endif', '', f'{prototype};', '',
        '#ifdef __cplusplus', '}', '#endif', '', f'#endif /* {guard} */', ''])
