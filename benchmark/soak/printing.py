# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How a soak is run from the command line, and what it found is told."""
from collections.abc import Iterator
from contextlib import contextmanager
import json
import os
from pathlib import Path
import tempfile
from typing import Any

import domain_coordinator
from rich.console import Console
from rich.table import Table


@contextmanager
def own_domain() -> Iterator[Path]:
    """Give a folder, and a ROS domain of this computer that nobody else uses."""
    with domain_coordinator.domain_id() as domain, tempfile.TemporaryDirectory() as directory:
        os.environ.update(
            ROS_DOMAIN_ID=str(domain), ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST')
        yield Path(directory)


def console() -> Console:
    """Return where results are printed."""
    made = Console()
    if not made.is_terminal:
        made.width = 150
    return made


def look_for_tracebacks(result: Any, directory: Path, *processes: str) -> None:
    """Have it a failure that a process printed a traceback."""
    for name in processes:
        log = Path(directory, f'{name}.log').read_text(errors='replace')
        if 'Traceback' in log:
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
