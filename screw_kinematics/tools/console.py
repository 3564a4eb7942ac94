# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
What all console programs share: help with examples, exit codes, one-line errors.

Exit codes are those of diff and grep: 0 all is well, 1 the tool ran and found something
wrong, 2 it could not do its work (wrong option, broken file, missing package).
"""
from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Sequence
from functools import partial
import os
from pathlib import Path
import re
import sys
from typing import Any, NoReturn

from .interruption import interruptible
from .. import __version__, core
from ..errors import ScrewKinematicsError, ToolError
from ..node.main import without_ros_arguments

OK, FOUND_PROBLEMS, FAILED = 0, 1, 2
INTERRUPTED = 130

COMMAND = 'screw-kinematics'
"""The one command that pip installs for all tools."""

COMPLETING = '_ARGCOMPLETE'
"""Environment variable of a run in which the shell asks for words to complete."""


class _Version(argparse.Action):
    """Tells the version when asked: to see how the core runs takes longer than to parse."""

    def __init__(self, option_strings: Sequence[str], dest: str) -> None:
        super().__init__(option_strings, argparse.SUPPRESS, 0, default=argparse.SUPPRESS,
                         help="show program's version number and exit")

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> NoReturn:
        """Print it and end."""
        print(f'{parser.prog} {__version__}; {core.build()}')
        parser.exit()


class Parser(argparse.ArgumentParser):
    """A parser with a version, help that ends with examples, and errors that show one."""

    def __init__(self, prog: str, description: str = '', examples: str = '',
                 **others: Any) -> None:
        # What a tool does with a word of its own behind its name has those that begin so.
        own = examples if description else ''.join(
            re.findall(rf'(?m)^  {re.escape(prog)}\b.*\n(?:   .*\n)*', examples))
        super().__init__(prog, description=description.strip(),
                         epilog=f'examples:\n{own}' if own else '',
                         formatter_class=argparse.RawDescriptionHelpFormatter, **others)
        self._examples = examples
        self.add_argument('--version', action=_Version)

    def add_subparsers(self, **options: Any) -> Any:
        """Let the parsers of what the tool does show examples, too."""
        options['parser_class'] = partial(Parser, examples=self._examples)
        return super().add_subparsers(**options)

    def error(self, message: str) -> NoReturn:
        """End with one line."""
        # Without the remark that stands behind it, and not those that go on in another line.
        fitting = re.search(rf'(?m)^  ({re.escape(self.prog)}\b.*?)(?:  .*)?(?<!\\)$',
                            self._examples)
        example = f'; for example: {fitting[1]}' if fitting else ''
        self.exit(FAILED, f'{self.prog}: {message}{example} (see {self.prog} --help)\n')


def parser(tool: str, description: str, examples: str) -> Parser:
    """Return a tool's parser; its name and its examples are as the user has to type them."""
    command = command_of(tool, Path(sys.argv[0]))
    return Parser(command, description, re.sub(rf'(?m)^  {tool}\b', f'  {command}', examples))


def command_of(tool: str, program: Path) -> str:
    """Return what is typed to run a tool, from the file of the program that runs."""
    if program.name == tool:
        # Where colcon puts executables for `ros2 run`, which are on nobody's path.
        in_workspace = program.parent.parts[-2:] == ('lib', 'screw_kinematics')
        return f'ros2 run screw_kinematics {tool}' if in_workspace else tool
    return f'{COMMAND} {tool}'


def complete(options: argparse.ArgumentParser) -> None:
    """Answer the shell and end, if it has asked for words to complete."""
    if COMPLETING in os.environ:
        from argcomplete import autocomplete
        autocomplete(options)


def keep_existing(places: Iterable[Path], force: bool) -> None:
    """Raise ToolError if something exists where outputs shall go, unless it is to be lost."""
    for place in places:
        if place.exists() and not force:
            raise ToolError(f'{place} exists already; choose another output, or --force')


def run(tool: Callable[[argparse.Namespace], int], options: argparse.ArgumentParser,
        argv: Sequence[str] | None) -> int:
    """Run a tool; return its exit code, 2 after an error told in one line, 130 after Ctrl-C."""
    complete(options)
    arguments = options.parse_args(without_ros_arguments(sys.argv[1:] if argv is None else argv))
    try:
        with interruptible():
            code = tool(arguments)
            _flush()
        return code
    except (ScrewKinematicsError, OSError) as error:
        try:
            _flush()
        except OSError:
            # Nobody reads on (head, less), or the disk is full: Python would complain at exit.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            return OK       # the reader has seen enough
        print(f'{options.prog}: {error}', file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        return INTERRUPTED


def _flush() -> None:
    if sys.stdout is not None:
        sys.stdout.flush()
