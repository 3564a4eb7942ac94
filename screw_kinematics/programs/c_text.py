# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The program as C99 source, for controllers: no allocation, no branches, only ``math.h``."""
from __future__ import annotations

from collections.abc import Mapping
import re

from .assignments import assignments
from .straight_line_program import StraightLineProgram
from ..errors import InvalidValueError

KEYWORDS = frozenset(
    'auto break case char const continue default do double else enum extern float for goto '
    'if inline int long main register restrict return short signed sizeof static struct '
    'switch typedef union unsigned void volatile while sin cos sqrt'.split())


def c_header(name: str, inputs: Mapping[str, int], outputs: Mapping[str, int],
             comment: str) -> str:
    """Return the header of :func:`c_source`."""
    guard = f'{name.upper()}_H'
    comment = comment.replace('*/', '* /').replace('/*', '/ *')    # names may hold anything
    return '\n'.join([
        f'#ifndef {guard}', f'#define {guard}', '',
        '#ifdef __cplusplus', 'extern "C" {', '#endif', '',
        '/*', *[f' * {row}'.rstrip() for row in comment.splitlines()], ' */',
        f'{_prototype(name, inputs, outputs)};', '',
        '#ifdef __cplusplus', '}', '#endif', '', '#endif', ''])


def c_source(line: StraightLineProgram, name: str, inputs: Mapping[str, int],
             outputs: Mapping[str, int]) -> str:
    """
    Return a C function that computes the program; it includes its header, ``name.h``.

    Inputs and outputs are names of arrays, and how many numbers each has; outputs may be the same
    memory as inputs.
    """
    entries = [f'{array}[{k}]' for array, n in inputs.items() for k in range(n)]
    local = [entry.replace('[', '_').replace(']', '') for entry in entries]
    text = assignments(line, local)
    used = line.uses()
    # All inputs are read before the first output is written.
    rows = [f'    const double {variable} = {entry};'
            for k, (variable, entry) in enumerate(zip(local, entries)) if used[k]]
    read = {entry.split('[')[0] for k, entry in enumerate(entries) if used[k]}
    rows += [f'    (void){array};' for array in inputs if array not in read]
    if text.names:
        rows += [f'    double {", ".join(text.names[k:k + 12])};'
                 for k in range(0, len(text.names), 12)]
    rows += ['', *[f'    {target} = {expression};' for target, expression in text.body], '']
    targets = [f'{array}[{k}]' for array, n in outputs.items() for k in range(n)]
    rows += [f'    {target} = {expression};' for target, expression in zip(targets, text.outputs)]
    return '\n'.join([f'#include "{name}.h"', '', '#include <math.h>', '',
                      _prototype(name, inputs, outputs), '{', *rows, '}', ''])


def _prototype(name: str, inputs: Mapping[str, int], outputs: Mapping[str, int]) -> str:
    if not re.fullmatch('[A-Za-z][A-Za-z0-9_]*', name) or name in KEYWORDS:
        raise InvalidValueError(f'{name!r} is no name of a C function; allowed: letters, '
                                'digits and _, a letter first, no word of the language')
    # C has no arrays without elements; a robot without joints has no inputs.
    arguments = [f'const double {array}[{max(n, 1)}]' for array, n in inputs.items()]
    arguments += [f'double {array}[{n}]' for array, n in outputs.items()]
    indent = ' ' * len(f'void {name}(')
    return f'void {name}(' + f',\n{indent}'.join(arguments) + ')'
