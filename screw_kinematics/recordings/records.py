# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What was done of many recordings, so that the next run does only what is missing."""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from hashlib import sha256
import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from .processing import Outcome, RobotOutcome, Task
from .summary import MotionSummary
from ..errors import ModelError
from ..models.uri import local_path

FOLDER = '_done'
"""Within the outputs; readers of data sets pass over names that begin so."""

_VERSION = 3    # of the results: another one does everything again


def done_before(task: Task) -> Outcome | None:
    """Return the outcome of an earlier run, if neither recording nor settings have changed."""
    try:
        kept = json.loads(_file(task).read_text())
        if kept['task'] != _fingerprint(task):
            return None
        outcome = _outcome(kept['outcome'])
    except (OSError, ValueError, LookupError, TypeError):
        return None
    return replace(outcome, before=True) if all(
        Path(file).exists() for file in outcome.files) else None


def known(task: Task) -> bool:
    """Return whether an earlier run has written the outputs, of whatever recording."""
    return _file(task).exists()


def keep(task: Task, outcome: Outcome) -> None:
    """Write down what was done, unless it failed."""
    if outcome.error:
        return
    file = _file(task)
    file.parent.mkdir(parents=True, exist_ok=True)
    unfinished = file.with_suffix('.unfinished')
    unfinished.write_text(json.dumps(
        {'task': _fingerprint(task), 'outcome': asdict(outcome)}, default=np.ndarray.tolist))
    os.replace(unfinished, file)


def _file(task: Task) -> Path:
    return task.folder / FOLDER / f'{task.name}.json'


def _fingerprint(task: Task) -> str:
    """Return what changes when another result is to be expected."""
    parts = [_VERSION, replace(task, folder=Path(), source=task.source._replace(place=''))]
    for robot in task.robots:
        try:
            parts.append(local_path(robot.description).read_bytes())
        except (ModelError, OSError):
            parts.append(robot.description)
    return sha256(repr(parts).encode()).hexdigest()


def _outcome(kept: Mapping[str, Any]) -> Outcome:
    robots = [RobotOutcome(**{**robot, 'summary': _summary(robot['summary'])})
              for robot in kept['robots']]
    return Outcome(**{**kept, 'robots': robots})


def _summary(kept: Mapping[str, Any] | None) -> MotionSummary | None:
    if kept is None:
        return None
    summary = MotionSummary()
    for name, value in kept.items():
        array = isinstance(getattr(summary, name), np.ndarray)
        setattr(summary, name, np.array(value) if array else value)
    return summary
