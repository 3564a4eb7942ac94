# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What is printed of recordings: a bar while they are read, a line for each, a table of all."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
import sys
import time

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from ...recordings.history import QUANTITIES
from ...recordings.processing import explanation, Outcome, RobotOutcome, Task


class Bar:
    """One bar for all recordings: how much is read, how fast, and what is left."""

    def __init__(self, tasks: Sequence[Task]) -> None:
        console = Console(stderr=True)
        self._progress = Progress(
            TextColumn('{task.description}'), BarColumn(), TextColumn('{task.percentage:.0f} %'),
            TextColumn('{task.fields[rate]}'), TimeRemainingColumn(), console=console,
            disable=not console.is_terminal)
        self._size = {task.name: max(task.source.size, 1) for task in tasks}
        self._share = dict.fromkeys(self._size, 0.0)
        self._samples: dict[str, int] = {}
        self._finished = 0
        self._begin = time.monotonic()
        self._task = self._progress.add_task(
            'reading', total=max(sum(self._size.values()), 1), rate='')

    def __enter__(self) -> Bar:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def advance(self, task: Task, samples: int, expected: int) -> None:
        """Say how many joint samples are read of a recording that has so many, if known."""
        self._samples[task.name] = samples
        # A robot of several reads the recording again; tables do not tell how long they are.
        whole = expected * len(task.robots)
        self._share[task.name] = min(samples / whole, 1.0) if whole else 0.5
        self._show()

    def finish(self, task: Task, outcome: Outcome) -> None:
        """Say that a recording is done, and how."""
        self._samples[task.name] = outcome.samples
        self._share[task.name] = 1.0
        self._finished += 1
        self._progress.console.print(
            line(outcome, task), highlight=False, markup=False, soft_wrap=True)
        self._show()

    def _show(self) -> None:
        seconds = max(time.monotonic() - self._begin, 1e-3)
        rate = sum(self._samples.values()) / seconds
        of = f'{self._finished}/{len(self._size)} ' if len(self._size) > 1 else ''
        self._progress.update(
            self._task, rate=f'{of}{rate:,.0f} samples/s',
            completed=sum(self._size[name] * share for name, share in self._share.items()))


def print_single(outcome: Outcome, task: Task) -> None:
    """Print what became of a recording that is the only one."""
    for robot, settings in zip(outcome.robots, task.robots):
        print(f'{robot.name}: {_counts(robot)}')
        left_out = [name for name in settings.outputs if name not in robot.outputs]
        if left_out:
            print(f'{robot.name}: not made from recordings: {", ".join(left_out)}')
        without = [name for name in robot.outputs if name not in QUANTITIES]
        if without and task.form in ('csv', 'parquet', 'dataset'):
            print(f'{robot.name}: not in tables, but in bags: {", ".join(without)}')
        why = explanation(robot, settings)
        if why:
            print(f'bag: {robot.name}: no state: {why}', file=sys.stderr)
        for finding in robot.findings:
            print(f'{robot.name}: {finding}')
        if _accuracy(robot):
            print(f'{robot.name}: accelerations of the joints are expected to be right to '
                  f'{_accuracy(robot)}{_unknown(robot)}')
    for robot in outcome.robots:
        if robot.comparison:
            print(robot.comparison)
    for damage in outcome.damage:
        print(f'bag: damaged: {damage}', file=sys.stderr)
    if outcome.damage:
        print(f'bag: {outcome.samples} joint samples were saved', file=sys.stderr)
    print(f'{outcome.size / 1e6:.1f} MB in {outcome.seconds:.1f} s, '
          f'{outcome.samples / max(outcome.seconds, 1e-9):,.0f} samples/s')


def line(outcome: Outcome, task: Task) -> str:
    """Return what became of one recording of several, in a line."""
    if outcome.error:
        return f'{outcome.name}: {outcome.error}'
    parts = [f'{outcome.name}: {"; ".join(f"{r.name}: {_counts(r)}" for r in outcome.robots)}']
    parts += [f'no state: {why}' for robot, settings in zip(outcome.robots, task.robots)
              if (why := explanation(robot, settings))]
    parts += [f'damaged: {damage}' for damage in outcome.damage]
    return '; '.join(parts)


def summary_table(outcomes: Sequence[Outcome]) -> str:
    """Return a line for each robot of each recording, and one for all."""
    rows = [['recording', 'robot', 'samples', 'states', 'refused', 'stamps', 'accuracy expected',
             'seconds', 'MB', '']]
    for outcome in outcomes:
        state = ('failed' if outcome.error else 'damaged' if outcome.damage
                 else 'done before' if outcome.before else '')
        about = [f'{outcome.seconds:.1f}', f'{outcome.size / 1e6:.1f}', state]
        for cells in [_row(robot) for robot in outcome.robots] or [[''] * 6]:
            rows.append([outcome.name, *cells, *about])
    robots = [robot for outcome in outcomes for robot in outcome.robots]
    rows.append([f'{len(outcomes)} recordings', '', str(sum(r.received for r in robots)),
                 str(sum(r.states for r in robots)), '', '', '',
                 f'{sum(o.seconds for o in outcomes):.1f}',
                 f'{sum(o.size for o in outcomes) / 1e6:.1f}',
                 f'{sum(not o.sound for o in outcomes)} with problems'])
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return '\n'.join('  '.join(
        cell.rjust(width) if i in (2, 3, 7, 8) else cell.ljust(width)
        for i, (cell, width) in enumerate(zip(row, widths))).rstrip() for row in rows)


def _row(robot: RobotOutcome) -> list[str]:
    stamps = f'{1 / robot.period:.1f} Hz' if robot.period > 0 else ''
    if robot.longest_pause > max(5 * robot.period, 0.1):
        stamps += f', a pause of {robot.longest_pause:.2f} s'
    stamps += ''.join(f', {finding}' for finding in robot.findings)
    return [robot.name, str(robot.received), str(robot.states), _refused(robot.refused),
            stamps, _accuracy(robot)]


def _counts(robot: RobotOutcome) -> str:
    refused = _refused(robot.refused)
    return (f'{robot.received} joint samples on {", ".join(robot.topics)}, {robot.states} states '
            f'of {", ".join(robot.outputs)}' + (f'; not used: {refused}' if refused else ''))


def _refused(refused: Mapping[str, int]) -> str:
    return ', '.join(f'{count} {reason}' for reason, count in refused.items())


def _accuracy(robot: RobotOutcome) -> str:
    """Return the expected error of the joints' accelerations, absolute and of the signal."""
    if not robot.accuracy > 0:
        return ''
    share = 100 * robot.accuracy / robot.signal if robot.signal > 0 else float('inf')
    return f'{robot.accuracy:.2g} rad/s2' + (
        f' ({share:.0f} %)' if 10 <= share < 1000 else f' ({share:.2g} %)' if share < 10 else '')


def _unknown(robot: RobotOutcome) -> str:
    """Return of how many states the accelerations are hardly known."""
    return f'; those of {robot.unknown} states, where samples begin or end, are hardly known' if (
        robot.unknown) else ''
