# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Replay beginnings of the field soak's streams as a busy machine leaves them, without ROS.

In each a robot begins at another moment; messages are lost in blocks of 1 to 20 as who reads
them catches up, at the beginning and after stalls of 10 to 300 ms, in which they are lost, or
held up and stamped late. Outputs that are wrong by more than ten times the deviation that they
state are counted by what the clock took its latest readings for. Ends with code 0 if none are.
"""
import argparse
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
import sys
from typing import NamedTuple

import numpy as np
from rich.table import Table

from screw_kinematics.messages.joint_state import JointSample
from screw_kinematics.motion import MotionEstimator
from screw_kinematics.motion.device_clock import Placed
from screw_kinematics.pipeline.group_motion import make_motion
from screw_kinematics.pipeline.kinematics import Kinematics, State
from screw_kinematics.pipeline.message_writers import message_writer
from screw_kinematics.pipeline.outputs import KINDS
from screw_kinematics.pipeline.parameter_file import robot_settings
from screw_kinematics.pipeline.robot_model import continuous_joints, plausible_velocities
from screw_kinematics.pipeline.robot_pipeline import RobotPipeline
from screw_kinematics.pipeline.robot_program import compile_tip, OneTip

from .checks import errors, FARTHEST
from .robots import arrival, FieldRobot, Message, OUTPUTS, RATE, ROBOTS, SAMPLES
from ..printing import conclude, console
from ..tally import decode

LENGTH = 1200
"""Messages of a beginning, those that are lost included."""

EVERY = 7.0
"""Between two settings of a clock [s]."""

START_NS = 1_700_000_000_000_000_000

MEMORY, PAUSE = 0.3, 0.008
"""For how long filters feel what the clock took a reading for; what is a pause [s]."""


def received(messages: list[Message], rng: np.random.Generator, held: bool) -> list[Message]:
    """Return what arrives of some messages; `held`: some stalls hold them up, and none is lost."""
    found: list[Message] = []
    k, free = 0, 0.0

    def take(count: int) -> None:
        nonlocal k, free
        for message in messages[k:k + count]:
            if message.sent < free:
                message = Message(message.reading, free, free, free)
            found.append(message)
            free += 1e-5
        k += count

    while k < len(messages):
        for _ in range(rng.integers(0, 12)):
            take(int(rng.geometric(0.12)))
            k += int(rng.integers(1, 21))
        take(int(rng.integers(50, 500)))
        stall = round(np.exp(rng.uniform(*np.log((10, 300)))))
        if held and rng.random() < 0.3 and k < len(messages):
            free = messages[k].sent + stall / RATE
        else:
            k += stall
    return found


class Trace(NamedTuple):
    """Of a message: when it was read, truly and by the clock [s], and what that knew."""

    reading: float
    time: float
    period: float
    proven: bool


class Player:
    """Plays messages of a robot to the pipeline of a node."""

    def __init__(self, robot: FieldRobot) -> None:
        self.robot, model = robot, robot.chains[0]
        given = dict(robot.parameters)
        given |= {f'estimator.{key}': value for key, value in given.pop('estimator').items()}
        settings = robot_settings(robot.name, given)
        needs = dict.fromkeys(need for output in OUTPUTS for need in KINDS[output].needs)
        program = compile_tip(model, [*needs], settings)
        self._kinematics = Kinematics(OneTip(program), covariance=True)
        self._writers = {output: message_writer(output, program.slices, model, settings)
                         for output in OUTPUTS}
        self._names, self._motion = tuple(model.joint_names), settings.motion
        self._joints = continuous_joints(model), plausible_velocities(settings.motion, model)
        self._readings = robot.readings()

    def samples(self, messages: list[Message]) -> Iterator[JointSample]:
        """Yield messages as the pipeline takes them."""
        for message in messages:
            position, velocity = self._readings[round(message.reading * RATE) % SAMPLES]
            yield JointSample(START_NS + round(message.stamp * 1e9), self._names,
                              tuple(position), tuple(velocity))

    def outputs(self, messages: list[Message]) -> tuple[list[int], dict[str, list[bytes]]]:
        """Return which messages lead to outputs, and these."""
        pipeline = RobotPipeline(self._names, self._motion, *self._joints)
        pipeline.activate(self._kinematics)
        which: list[int] = []
        found: dict[str, list[bytes]] = {output: [] for output in OUTPUTS}
        for k, sample in enumerate(self.samples(messages)):
            state = pipeline.take(sample)
            if isinstance(state, State):
                which.append(k)
                for output, written in found.items():
                    written.append(self._writers[output].encode(state))
        return which, found

    def traces(self, messages: list[Message]) -> list[list[Trace]]:
        """Return for each message those that the filters may still feel, the latest last."""
        estimator = make_motion(self._motion, *self._joints, 2, True).estimator
        assert isinstance(estimator, MotionEstimator)
        latest: list[Trace] = []
        found = []
        for message, sample in zip(messages, self.samples(messages)):
            placed = estimator.place((sample.stamp_ns - START_NS) * 1e-9,
                                     sample.position, sample.velocity or None)
            if isinstance(placed, Placed):
                clock = estimator.clock
                if placed.replay is not None:       # with this one, which comes last
                    again = placed.replay[:-1][-len(latest):]
                    latest = [old._replace(time=time) for old, (time, _) in zip(
                        latest[len(latest) - len(again):], again)]
                if placed.time is not None:
                    latest = [t for t in latest if message.reading - t.reading < MEMORY]
                    latest.append(Trace(message.reading, placed.time, clock.period,
                                        clock.proven and clock.share < 0.5))
            found.append(latest)
        return found


def cause(traces: list[Trace], period: float) -> str:
    """Return what the clock took the latest readings for, of a device whose period is known."""
    if not traces:
        return 'nothing is known'
    for before, at in zip(traces[-2::-1], traces[:0:-1]):
        passed = at.reading - before.reading
        slip = at.time - before.time - passed
        if at.proven and before.proven and abs(slip) > 0.5 * period:
            return 'ticks miscounted ' + ('in a pause' if passed > PAUSE else 'without a pause')
    now = traces[-1]
    ratio = now.period / period
    if now.period and abs(ratio - max(round(ratio), 1)) > 0.02 * ratio:
        return 'a wrong period'
    if any(b.reading - a.reading > PAUSE and not b.proven for a, b in zip(traces, traces[1:])):
        return 'a pause while stamps are believed'
    return 'other, ticks are known' if now.proven else 'other, stamps are believed'


@dataclass
class Result:
    """What was found."""

    judged: dict[str, int] = field(default_factory=dict)
    usual: dict[str, float] = field(default_factory=dict)
    worst: dict[str, float] = field(default_factory=dict)
    causes: dict[str, Counter[str]] = field(default_factory=dict)
    failures: list[str] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Return whether nothing was wrong."""
        return not self.failures


def run(robot: FieldRobot, beginnings: int, seed: int, result: Result) -> None:
    """Play some beginnings of a robot."""
    player = Player(robot)
    stream = robot.way(EVERY)
    judged, squares, worst = 0, 0.0, 0.0
    causes: Counter[str] = Counter()
    for number in range(beginnings):
        rng = np.random.default_rng([seed, number])
        whole = list(islice(stream, LENGTH))
        messages = received(whole, rng, robot.way is arrival)
        which, found = player.outputs(messages)
        instants = np.array([messages[k].instant for k in which]) - robot.delay
        traces: list[list[Trace]] = []
        for output, batch in found.items():
            if not batch:
                continue
            _, _, values, deviations = decode(batch, covariance=True)
            sizes = errors(robot, output, instants, values, deviations, 0)
            best = sizes[(sizes.clip(0, FARTHEST)**2).sum(1).argmin()]
            judged, worst = judged + len(best), max(worst, best.max())
            squares += (best.clip(0, 1e3)**2).sum()
            for i in np.flatnonzero(best > FARTHEST).tolist():
                traces = traces or player.traces(messages)
                device = float(np.median(np.diff(np.unique([m.reading for m in whole]))))
                why = cause(traces[which[i]], device)
                causes[why] += 1
                result.failures.append(
                    f'{robot.name}, beginning {number}: {output} of message {which[i]} is wrong '
                    f'by {best[i]:.1f} deviations: {why}')
    result.judged[robot.name], result.worst[robot.name] = judged, float(worst)
    result.usual[robot.name] = float(np.sqrt(squares / max(judged, 1)))
    result.causes[robot.name] = causes


def table(result: Result) -> Table:
    """Return the figures for reading."""
    shown = Table('robot', 'outputs', 'usual error', 'worst', 'beyond 10', 'cause',
                  title='errors in deviations as stated')
    for name, causes in result.causes.items():
        shown.add_row(name, f'{result.judged[name]:,}', f'{result.usual[name]:.2f}',
                      f'{result.worst[name]:.1f}', str(causes.total()),
                      '\n'.join(f'{why}: {count}' for why, count in causes.most_common()))
    return shown


def main() -> int:
    """Replay from the command line; return the exit code."""
    parser = argparse.ArgumentParser(
        prog='python -m benchmark.soak.field.losses', description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    names = [robot.name for robot in ROBOTS]
    parser.add_argument('--beginnings', type=int, default=250, help='of each robot (default: 250)')
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--robots', nargs='+', choices=names, default=names)
    parser.add_argument('--json', type=Path, help='file for all figures')
    options = parser.parse_args()
    result = Result()
    for robot in ROBOTS:
        if robot.name in options.robots:
            run(robot, options.beginnings, options.seed, result)
    return conclude(console(), result, [table(result)], options.json)


if __name__ == '__main__':
    sys.exit(main())
