# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""One recording, from its path to the states of its robots in their place."""
from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
import time
from typing import Any

import numpy as np

from .comparison import Difference, table
from .joint_table import JointTable, TableFormat
from .recording import full_name, Recording
from .sources import opened, Source, without_password
from .states import LEFT_OUT, recorded_robot, RecordedRobot, Run, StateBlock
from .summary import CLASSES, class_of, MotionSummary, Summarizer
from .unfinished import Unfinished
from .writers import BagWriter, DataSetWriter, StateWriter, TablesWriter, values_of
from ..errors import Reason, ScrewKinematicsError, ToolError
from ..pipeline.outputs import KINDS, RECORDED
from ..pipeline.settings import RobotSettings

FORMS = ('mcap', 'sqlite3', 'csv', 'parquet', 'dataset')
"""A bag of ROS 2 in either storage, a table for each robot, or parts of a Parquet data set."""

_KNOWN = 3.0    # times the usual acceleration: what is less certain is not known


@dataclass(frozen=True)
class Task:
    """
    What is to be made of a recording; may be sent to other machines.

    The form is one of FORMS, or empty, if nothing is written; folder and name are of the outputs.
    Without a stop limit [m/s^2] the motion is not summed up.
    """

    source: Source
    robots: tuple[RobotSettings, ...]
    namespace: str = ''
    form: str = ''
    folder: Path = Path()
    name: str = ''
    table: TableFormat = field(default_factory=TableFormat)
    compare: bool = False
    stop_limit: float | None = None

    def table_name(self, robot: str) -> str:
        """Return the name of a robot's table."""
        several = f'_{robot.replace("/", "_")}' if len(self.robots) > 1 else ''
        return f'{self.name}{several}.{self.form}'

    def places(self) -> list[Path]:
        """Return what will be written, as far as it is known before."""
        if self.form in ('mcap', 'sqlite3'):
            return [self.folder / self.name]
        if self.form in ('csv', 'parquet'):
            return [self.folder / self.table_name(robot.name) for robot in self.robots]
        return []

    def writer(self, folder: Path) -> StateWriter:
        """Return what writes the states into a folder."""
        if self.form == 'dataset':
            return DataSetWriter(folder, self.name)
        if self.form in ('csv', 'parquet'):
            return TablesWriter(lambda robot: folder / self.table_name(robot))
        return BagWriter(folder / self.name, self.form, self.namespace)


@dataclass
class RobotOutcome:
    """
    What became of one robot's samples.

    States were made of the joint samples that were received and not refused, by reason; missing
    is of which joints nothing came, and what came instead. The period is the median time between
    samples of the joints that come most seldom, the longest pause between two states [s].
    Accuracy and signal are the RMS of the accelerations' expected errors, and of the accelerations
    themselves, over the joints; NaN where they are not estimated. Unknown are states left out of
    both: next to nothing is known of their accelerations, as where slow samples begin and end.
    """

    name: str
    topics: list[str]
    outputs: list[str]
    received: int = 0
    states: int = 0
    refused: dict[str, int] = field(default_factory=dict)
    missing: str = ''
    period: float = float('nan')
    longest_pause: float = 0.0
    accuracy: float = float('nan')
    signal: float = float('nan')
    unknown: int = 0
    summary: MotionSummary | None = None
    findings: list[str] = field(default_factory=list)
    comparison: str = ''
    compared: int = 0
    error: str = ''


@dataclass
class Outcome:
    """What became of a recording."""

    name: str
    place: str
    size: int                                          # in bytes
    robots: list[RobotOutcome] = field(default_factory=list)
    damage: list[str] = field(default_factory=list)    # what is broken in it
    error: str = ''                                    # why nothing could be made of it
    seconds: float = 0.0
    files: list[str] = field(default_factory=list)     # what was written
    before: bool = False                               # whether this is from an earlier run

    @property
    def samples(self) -> int:
        """Return how many joint samples there were."""
        return sum(robot.received for robot in self.robots)

    @property
    def sound(self) -> bool:
        """Whether nothing is wrong with it."""
        return not (self.error or self.damage) and all(
            robot.states and (robot.compared or not robot.comparison) for robot in self.robots)


def process(task: Task, run: Run = map,
            progress: Callable[[int, int], None] | None = None) -> Outcome:
    """
    Make the states of a recording and write them.

    What goes wrong is in the outcome; nothing unfinished is left. Blocks are smoothed by ``run``,
    in their order; progress gets the joint samples read so far, and how many are expected or 0.
    """
    outcome = Outcome(task.name or task.source.name, without_password(task.source.place),
                      task.source.size)
    begin = time.perf_counter()
    try:
        with opened(task.source.place, task.table) as recording, ExitStack() as stack:
            output = _Output(task, stack) if task.form else None
            for settings in task.robots:
                robot = None
                try:
                    robot = recorded_robot(recording, settings, task.namespace,
                                           0 if task.stop_limit is None else 2)
                    outcome.robots.append(_process_robot(
                        task, recording, robot, run, output,
                        lambda done: progress(outcome.samples + done, _expected(recording))
                        if progress else None))
                except ToolError as error:      # as of a topic that was not recorded
                    if robot is not None and robot.account.outputs:
                        raise
                    outcome.robots.append(_without_states(task, settings, str(error)))
            if all(robot.error for robot in outcome.robots):
                raise ToolError('; '.join(dict.fromkeys(r.error for r in outcome.robots)))
            if output is not None:
                output.close()
            outcome.damage = list(recording.damage)
        if output is not None and output.unfinished is not None:
            outcome.files = [str(path) for path in output.unfinished.finished]
    except (ScrewKinematicsError, OSError) as error:
        outcome.error = str(error)
    outcome.seconds = time.perf_counter() - begin
    return outcome


def _without_states(task: Task, settings: RobotSettings, error: str) -> RobotOutcome:
    return RobotOutcome(
        settings.name, [full_name(task.namespace, t) for t in settings.joint_states_topic],
        [name for name in settings.outputs if name not in LEFT_OUT], error=error)


class _Output:
    """The writer of a task, opened when there is something to write."""

    def __init__(self, task: Task, stack: ExitStack) -> None:
        self._task, self._stack = task, stack
        self.unfinished: Unfinished | None = None
        self._writer: StateWriter | None = None

    def write(self, robot: RecordedRobot, block: StateBlock) -> None:
        if self._writer is None:
            self.unfinished = self._stack.enter_context(
                Unfinished(self._task.folder, self._task.name))
            self._writer = self._task.writer(self.unfinished.make())
        self._writer.write(robot, block)

    def close(self) -> None:
        if self._writer is not None:
            self._writer.close()


def _process_robot(task: Task, recording: Recording | JointTable, robot: RecordedRobot, run: Run,
                   output: _Output | None, progress: Callable[[int], Any]) -> RobotOutcome:
    """Make the states of one robot, and whatever is asked to be made of them."""
    differences = list(_differences(task, recording, robot))
    summarizer = None if task.stop_limit is None else Summarizer(robot, task.stop_limit)
    accuracy = _Accuracy()
    last, longest = None, 0.0
    for block in robot.states(recording, run):
        if output is not None:
            output.write(robot, block)
        for difference in differences:
            difference.add_states(block.stamps, values_of(robot, block, difference.output))
        if summarizer is not None:
            summarizer.add(block)
        steps = np.diff(block.stamps, prepend=block.stamps[0] if last is None else last)
        last, longest = block.stamps[-1], max(longest, float(steps.max()) * 1e-9)
        accuracy.add(block)
        progress(robot.account.received)
    for difference in differences:
        difference.finish()
    account = robot.account
    return RobotOutcome(
        robot.settings.name, list(robot.topics), list(robot.outputs), account.received,
        account.outputs,
        {account.told(reason): n for reason, n in sorted(account.refused.items()) if n},
        robot.groups.describe_missing(), robot.period, longest, *accuracy.result(),
        None if summarizer is None or not account.outputs else summarizer.summary,
        [*robot.findings, *(robot.sensor.findings(account.outputs) if robot.sensor else ())],
        table(differences) if differences else (
            'nothing to compare: no output of the node is in a table' if task.compare else ''),
        sum(d.compared for d in differences))


def _differences(task: Task, recording: Recording | JointTable, robot: RecordedRobot,
                 ) -> Iterator[Difference]:
    if task.compare and isinstance(recording, Recording):
        for output in RECORDED.keys() & set(robot.outputs):
            topic = full_name(task.namespace, f'{robot.settings.topic}/{output}')
            yield Difference(topic, output, recording.messages({KINDS[output].type_name}, {topic}))


def _expected(recording: Recording | JointTable) -> int:
    return recording.joint_state_count if isinstance(recording, Recording) else 0


class _Accuracy:
    """How wrong the joints' accelerations are expected to be, and how large they are."""

    def __init__(self) -> None:
        # By classes of the expected error: states, and sums of its square and of the signal's.
        self._sums = np.zeros((3, CLASSES))

    def add(self, block: StateBlock) -> None:
        if len(block.motion) > 2:
            variance = block.variances[2].mean(axis=1)
            known = np.isfinite(variance)
            variance, square = variance[known], (block.motion[2][known]**2).mean(axis=1)
            classes = class_of(np.sqrt(variance))
            for i, weights in enumerate((np.ones(len(classes)), variance, square)):
                self._sums[i] += np.bincount(classes, weights, CLASSES)

    def result(self) -> tuple[float, float, int]:
        count, error, square = np.cumsum(self._sums, axis=1)
        if not count[-1]:
            return float('nan'), float('nan'), 0
        # Classes of states that tell something, but at least the better half of all.
        known = np.flatnonzero(self._sums[1] * count < _KNOWN**2 * square * self._sums[0])
        last = max([*known[-1:], np.searchsorted(count, 0.5 * count[-1])])
        return (float(np.sqrt(error[last] / count[last])),
                float(np.sqrt(square[last] / count[last])), int(count[-1] - count[last]))


def explanation(robot: RobotOutcome, settings: RobotSettings) -> str:
    """Return why there are no states of a robot, and what to do; empty if there are."""
    if robot.states:
        return ''
    if robot.error:
        return robot.error
    if not robot.received:
        return f'no joint samples came on {", ".join(robot.topics)}'
    if robot.missing:
        return robot.missing
    short = robot.refused.get(Reason.RUN_TOO_SHORT, 0)
    gap = settings.motion.options['max_gap']
    if short > 0.5 * robot.received and robot.period <= gap:
        return (f'between pauses of more than {settings.name}.estimator.max_gap ({gap:g} s), and '
                'stamps that go back, there are fewer than 8 samples in a row')
    if short and robot.period > gap:
        return (f'samples come every {robot.period:.3g} s, and pauses that exceed '
                f'{settings.name}.estimator.max_gap ({gap:g} s) leave fewer than 8 of them in a '
                f'row; raise it, or set {settings.name}.velocity_source: measured')
    return 'every sample was refused'
