# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
What all console programs share: help with examples, exit codes, one-line errors.

Exit codes are those of diff and grep: 0 all is well, 1 the tool ran and found something
wrong, 2 it could not do its work (wrong option, broken file, missing package).
"""
from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
import os
import sys
from typing import NoReturn

from ..errors import ScrewKinematicsError

OK, FOUND_PROBLEMS, FAILED = 0, 1, 2
INTERRUPTED = 130


class _Parser(argparse.ArgumentParser):
    """An argument parser whose errors are one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(FAILED, f'{self.prog}: {message} (see {self.prog} --help)\n')


def parser(prog: str, description: str, examples: str) -> argparse.ArgumentParser:
    """
    Return a parser whose help ends with examples, printed as they are written.

    Parameters
    ----------
    prog : str
        Name of the tool.
    description : str
        What it does; the docstring of its module.
    examples : str
        Command lines with a remark each.

    """
    return _Parser(prog=prog, description=description.strip(), epilog='examples:\n' + examples,
                   formatter_class=argparse.RawDescriptionHelpFormatter)


def run(tool: Callable[[argparse.Namespace], int], options: argparse.ArgumentParser,
        argv: Sequence[str] | None) -> int:
    """
    Run a tool and turn what goes wrong into one line and an exit code.

    Returns
    -------
    int
        Exit code: what the tool returns, or 2 after an error, or 130 after Ctrl-C.

    """
    arguments = options.parse_args(argv)
    try:
        return tool(arguments)
    except (ScrewKinematicsError, OSError) as error:
        if isinstance(error, BrokenPipeError):
            # The reader (head, less) has seen enough; keep Python from complaining at exit.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return OK
        print(f'{options.prog}: {error}', file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        return INTERRUPTED
