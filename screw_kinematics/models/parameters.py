# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Parameters of model files: names in place of lengths, with values or as symbols.

A file may declare ``parameters: {a: 0.25}`` and write ``a``, ``-a`` or ``2*a`` where a number
is expected. Formulas keep the names of lengths as symbols; everything else takes the values.
"""
from __future__ import annotations

from collections.abc import Callable, Mapping
import re
from typing import Any

from .fields import Fields, number
from ..errors import ModelError

_ENTRY = re.compile(
    r'\s*([+-]?)\s*(?:([0-9.]+(?:e[+-]?[0-9]+)?)\s*\*\s*)?([A-Za-z][A-Za-z0-9_]*)\s*', re.ASCII)
_LENGTHS = ('xyz', 'point', 'a', 'd')
_NUMBERS = (*_LENGTHS, 'rpy', 'axis', 'alpha', 'theta', 'pitch', 'matrix', 'offset', 'multiplier',
            'position', 'velocity_limit')
_NOT_NAMES = ('nan', 'inf', 'infinity')


def with_parameters(data: Any, source: str, symbol: Callable[[str], Any] | None = None) -> Any:
    """
    Return the content of a model file with its parameters put in.

    Their values, or, if given, what ``symbol`` makes of their names, in SI units; lengths then
    need no value.

    Examples
    --------
    >>> with_parameters({'parameters': {'a': 0.5}, 'home': {'xyz': ['-2*a', 0, 'a']}}, 'doc')
    {'home': {'xyz': [-1.0, 0, 0.5]}}

    """
    if not isinstance(data, Mapping) or not ('parameters' in data or symbol is not None):
        return data
    given = Fields(source, 'parameters', data.get('parameters', {}))
    values = {name: None if given.raw(name) in (None, '', 'null', '~') else given.number(name)
              for name in data.get('parameters', {})}
    for name in values:
        if not isinstance(name, str) or not _ENTRY.fullmatch(name) or number(name) is not None:
            raise ModelError(source, f'parameters: {name!r} is no name; allowed: letters, digits '
                                     'and _, a letter first')

    def put_in(entry: Any, key: str) -> Any:
        if isinstance(entry, Mapping):
            return {k: put_in(v, k) for k, v in entry.items()}
        if isinstance(entry, list):
            return [put_in(x, key) for x in entry]
        if key in _NUMBERS and isinstance(entry, str) and ' ' in entry.strip() \
                and '*' not in entry:
            return [put_in(x, key) for x in entry.split()]
        match = _ENTRY.fullmatch(entry) if key in _NUMBERS and isinstance(entry, str) else None
        if match is None or match[3].lower() in _NOT_NAMES:
            return entry
        sign, factor, name = match.groups()
        factor = 1.0 if factor is None else number(factor)
        if factor is None:
            return entry
        scale = -factor if sign == '-' else factor
        if symbol is not None and key in _LENGTHS:
            return (int(scale) if scale == int(scale) else scale) * symbol(name)
        if name not in values:
            return entry
        value = values[name]
        if value is None:
            what = 'only lengths can be symbols' if symbol is not None else 'only formulas (the ' \
                'tool derive) do without'
            raise ModelError(source, f'{key}: parameter {name!r} has no value; {what}')
        return scale * value

    return {key: put_in(value, key) for key, value in data.items() if key != 'parameters'}
