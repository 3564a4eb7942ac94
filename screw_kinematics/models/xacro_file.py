# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""URDF from xacro files, with the arguments that they take: ``FILE ARG:=VALUE ...``."""
from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
import re
import shlex

from .fields import listed, MAX_TEXT
from ..errors import ModelError, optional_module

_ARGUMENT = r'[A-Za-z_][\w.-]*:='
_VALUE = r'''(?:"[^"]*"|'[^']*'|[^\s"'])*'''
_CALL = re.compile(rf'(.*?)((?:\s+{_ARGUMENT}{_VALUE})*)\s*', re.DOTALL)
_DECLARED = re.compile(r'<xacro:arg\s[^>]*?\bname\s*=\s*(["\'])(.*?)\1')


def split_arguments(text: str) -> tuple[str, dict[str, str]]:
    """
    Return file and arguments of ``FILE ARG:=VALUE ...``.

    Values with blanks are in quotes; a file's name may have blanks as it is.

    Examples
    --------
    >>> split_arguments('my arm.xacro name:=ur greeting:="hello there"')
    ('my arm.xacro', {'name': 'ur', 'greeting': 'hello there'})

    """
    match = _CALL.fullmatch(text)
    if match is None:
        return text, {}
    words = [word.partition(':=') for word in shlex.split(match[2])]
    return match[1], {name: value for name, _, value in words}


def joined_arguments(file: str, arguments: Mapping[str, str]) -> str:
    """
    Return ``FILE ARG:=VALUE ...``, from which :func:`split_arguments` gives the same back.

    Examples
    --------
    >>> joined_arguments('arm.xacro', {'greeting': 'hello there'})
    "arm.xacro greeting:='hello there'"

    """
    return ' '.join([file, *(f'{name}:={shlex.quote(value)}'
                             for name, value in arguments.items())])


def expand(source: str, path: Path, arguments: Mapping[str, str]) -> tuple[str, list[str]]:
    """Return the URDF of a xacro file, and warnings of arguments that it does not declare."""
    xacro = optional_module('xacro', 'xacro', f'reading {source}')
    noted = _Arguments(arguments)
    try:
        text: str = xacro.process_file(str(path), mappings=noted).toxml()
    except Exception as error:      # xacro raises whatever the file's expressions raise
        if noted.missing is None:
            raise ModelError(source, f'xacro: {error}') from error
        declared = dict.fromkeys([*_declared(path), *noted.declared])
        raise ModelError(
            source, f'argument {noted.missing!r} has no value; give one as '
            f"'{path.name} {noted.missing}:=VALUE'; the file declares: "
            f'{listed(declared, near=noted.missing)}') from error
    return text, [f'argument {name!r} is not declared by the file; it declares: '
                  f'{listed(noted.declared, near=name)}'
                  for name in arguments if name not in noted.declared]


class _Arguments(dict[str, str]):
    """Values of arguments; notes those that the file declares, and one that it misses."""

    def __init__(self, values: Mapping[str, str]) -> None:
        super().__init__(values)
        self.declared: dict[str, None] = {}
        self.missing: str | None = None

    def __contains__(self, name: object) -> bool:
        """Take note of a declaration: before it sets a default xacro asks for a value."""
        self.declared[str(name)] = None
        return super().__contains__(name)

    def __missing__(self, name: str) -> str:
        self.missing = name[:MAX_TEXT]
        raise KeyError(name)


def _declared(path: Path) -> list[str]:
    """Return the arguments that the text of a file declares, used before or not."""
    return [name for _, name in _DECLARED.findall(path.read_text(errors='replace'))]
