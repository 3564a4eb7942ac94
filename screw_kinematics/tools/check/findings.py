# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What the tool check finds: facts, remarks and problems, and how they are printed."""
from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from rich.console import Console
from rich.text import Text

FACT, REMARK, PROBLEM = 'fact', 'remark', 'problem'
_STYLES = {FACT: 'green', REMARK: 'yellow', PROBLEM: 'bold red'}


class Finding(NamedTuple):
    """One thing found: with its name and value, and what to do about it."""

    level: str    # fact; remark: works, but could be better; or problem: will not work
    what: str
    advice: str = ''


def print_findings(findings: Iterable[Finding]) -> None:
    """Print one line for each finding, and its advice below it."""
    console = Console(highlight=False, soft_wrap=True)
    for finding in findings:
        console.print(Text.assemble((f'{finding.level:<8}', _STYLES[finding.level]),
                                    finding.what))
        if finding.advice:
            console.print(Text(f'        -> {finding.advice}'))


def has_problem(findings: Iterable[Finding]) -> bool:
    """Return whether one of the findings is a problem."""
    return any(finding.level == PROBLEM for finding in findings)
