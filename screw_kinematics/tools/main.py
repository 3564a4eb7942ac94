# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Kinematic states of robots: the tools beside the node.

Each folder here that has a ``main`` is a tool; the first line of its package says what it does.
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from importlib import import_module
from importlib.util import find_spec
import os
import pkgutil
import sys

from . import console
from .. import tools
from ..node.main import without_ros_arguments

EXAMPLES = """\
  screw-kinematics demo --once               one state beside the exact one, without a robot
  screw-kinematics check model robot.urdf    what is odd about a robot description
  screw-kinematics bag --help                options and examples of a tool
  eval "$(screw-kinematics --completion bash)"
                                             lets the Tab key complete names and options
"""
SHELLS = ('bash', 'zsh', 'fish')


def main(argv: Sequence[str] | None = None) -> int:
    """Run the tool that the first argument names; see ``screw-kinematics --help``."""
    try:
        return _run(argv)
    except KeyboardInterrupt:       # while a tool is imported, which takes a while
        return console.INTERRUPTED


def _run(argv: Sequence[str] | None) -> int:
    words = list(sys.argv[1:] if argv is None else argv)
    names = tool_names()
    options = _parser(names)
    if console.COMPLETING in os.environ:
        _complete(options, names)
    if words[:1] and words[0] in names:
        return int(import_module(f'{__package__}.{words[0]}.main').main(words[1:]))
    arguments = options.parse_args(without_ros_arguments(words))
    if arguments.completion is None:
        options.error(f'which tool? {", ".join(names)}')
    from argcomplete import shellcode
    print(shellcode([console.COMMAND], shell=arguments.completion))
    return console.OK


def tool_names() -> list[str]:
    """Return the names of the tools."""
    return [module.name for module in pkgutil.iter_modules(tools.__path__)
            if module.ispkg and find_spec(f'{__package__}.{module.name}.main')]


def _parser(names: Sequence[str]) -> argparse.ArgumentParser:
    """Return the parser of what comes before the name of a tool."""
    described = '\n'.join(f'  {name:{max(map(len, names))}}  {_purpose(name)}' for name in names)
    title = (__doc__ or '').strip().splitlines()[0]
    options = console.Parser(console.COMMAND, f'{title}\n\ntools:\n{described}', EXAMPLES)
    options.add_argument('tool', choices=names, nargs='?', metavar='TOOL', help='see above')
    options.add_argument('--completion', choices=SHELLS,
                         help='print the text that makes a shell complete this command')
    return options


def _purpose(name: str) -> str:
    text = import_module(f'{__package__}.{name}').__doc__ or ''
    return text.strip().partition('\n')[0]


def _complete(options: argparse.ArgumentParser, names: Sequence[str]) -> None:
    """Answer a shell that asks for words: itself up to the name of a tool, which does the rest."""
    line = os.environ['COMP_LINE'][:int(os.environ['COMP_POINT'])]
    before = line.split()[1:] if line[-1:].isspace() else line.split()[1:-1]
    if before[:1] and before[0] in names:
        # As `python script.py` is completed: the command proper begins with the second word.
        os.environ[console.COMPLETING] = '2'
        import_module(f'{__package__}.{before[0]}.main').main([])
    console.complete(options)
