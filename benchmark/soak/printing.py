# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How a soak is run from the command line, and what it found is told."""
import json
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table


def console() -> Console:
    """Return where results are printed."""
    made = Console()
    if not made.is_terminal:
        made.width = 150
    return made


def look_for_tracebacks(result: Any, directory: Path, *processes: str) -> None:
    """Have it a failure that a process printed a traceback, of Python or of a crash."""
    for name in processes:
        log = Path(directory, f'{name}.log').read_text(errors='replace')
        if 'Traceback' in log or 'Fatal Python error' in log:
            result.failures.append(f'{name} printed a traceback:\n{log[-3000:]}')


def conclude(screen: Console, result: Any, tables: list[Table], file: Path | None) -> int:
    """Print what was found, and write it into a file; return the exit code."""
    for table in tables:
        screen.print(table)
    for failure in result.failures:
        screen.print(failure, markup=False)
    screen.print('passed' if result.passed else 'FAILED')
    if file:
        write(result, file)
    return 0 if result.passed else 1


def write(result: Any, file: Path) -> None:
    """Write all figures so far."""
    file.write_text(json.dumps(
        vars(result) | {'passed': result.passed}, indent=1, default=vars))
