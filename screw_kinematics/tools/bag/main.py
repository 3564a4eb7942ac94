# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Compute states from a recorded bag, smoothed without the lag a live node has.

Reads sensor_msgs/JointState out of mcap or sqlite3 bags, needs no ROS installation, and
writes a bag with the topics of the node, or a CSV or Parquet table.
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
import sys

from rich.console import Console
from rich.progress import MofNCompleteColumn, Progress, TimeRemainingColumn

from .smoothing_pool import SmoothingPool
from .. import console, robot_options
from ...errors import ParameterError
from ...pipeline.outputs import KINDS, RECORDED
from ...pipeline.parameter_file import read_robots, robot_settings
from ...pipeline.settings import RobotSettings
from ...recordings.comparison import Difference, table
from ...recordings.recorded_robots import full_name, JOINT_STATE, recorded_robots, RecordedRobot
from ...recordings.recording import Recording
from ...recordings.robot_states import LEFT_OUT, RobotStates, StateBlock
from ...recordings.stage_times import StageTimes
from ...recordings.writers import make_writer, StateWriter, values_of

EXAMPLES = """\
  bag recording --robot config/robots/panda.yaml --output states
  bag recording --params-file kinematic_states.yaml --output states.parquet
  bag run.mcap --robot panda.urdf --tip panda_hand_tcp --outputs pose,twist,accel,jerk \\
      --output states.csv
  bag recording --params-file kinematic_states.yaml --compare
"""
_AT_A_TIME = 5000
Differences = dict[str, tuple[RobotStates, Difference]]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the tool; see ``bag --help``."""
    options = console.parser('bag', __doc__ or '', EXAMPLES)
    options.add_argument('bag', type=Path, help='directory of a bag, or a .mcap or .db3 file')
    what = options.add_mutually_exclusive_group(required=True)
    what.add_argument('--params-file', type=Path, metavar='FILE',
                      help='robots and settings, as the node has them')
    what.add_argument('--robot', nargs='+', action=robot_options.Model, metavar='MODEL',
                      help='one robot: YAML, URDF or xacro, path or URI')
    options.add_argument('--base', metavar='FRAME', help='base frame, with --robot')
    options.add_argument('--tip', metavar='FRAME', help='tip frame, with --robot')
    options.add_argument('--name', default='robot', help='of that robot, which its topics begin '
                                                         'with (default: robot)')
    options.add_argument('--topic', default='joint_states', help='of the joint states, with '
                                                                 '--robot')
    options.add_argument('--outputs', metavar='A,B', help='of '
                         f'{", ".join(RECORDED)} (default: as the parameters say; twist,accel)')
    options.add_argument('--namespace', default='', help='of the node (default: none)')
    options.add_argument('--output', type=Path, metavar='PATH',
                         help='.csv or .parquet: a table for each robot; else: a new bag')
    options.add_argument('--storage', choices=('mcap', 'sqlite3'), default='mcap',
                         help='of a new bag (default: mcap)')
    options.add_argument('--processes', type=int, default=2, metavar='N',
                         help='that smooth long recordings side by side (default: 2)')
    options.add_argument('--compare', action='store_true',
                         help='compare what the node published with the states')
    return console.run(_bag, options, argv)


def _bag(arguments: argparse.Namespace) -> int:
    if arguments.output is None and not arguments.compare:
        raise ParameterError('output', None, 'a path, or --compare')
    stages = StageTimes()
    recording = Recording(arguments.bag)
    with SmoothingPool(arguments.processes) as smoothing:
        robots = recorded_robots(recording, _settings(arguments), arguments.namespace,
                                 smoothing, stages)
        differences = _run(arguments, recording, robots, stages)
    code = _report(recording, robots, differences)
    print(stages.report(smoothing.helped))
    return code


def _run(arguments: argparse.Namespace, recording: Recording,
         robots: Sequence[RecordedRobot], stages: StageTimes) -> Differences:
    """Make the states, and whatever is asked to be made of them."""
    differences = {full_name(arguments.namespace, f'{robot.states.settings.name}/{output}'):
                   (robot.states, Difference(output))
                   for robot in robots for output in robot.states.outputs
                   } if arguments.compare else {}
    if arguments.output is None:
        _process(recording, robots, differences, None, stages)
    else:
        with make_writer(arguments.output, [robot.states for robot in robots],
                         arguments.storage, arguments.namespace) as writer:
            _process(recording, robots, differences, writer, stages)
    return differences


def _settings(arguments: argparse.Namespace) -> list[RobotSettings]:
    chosen = {} if arguments.outputs is None else {
        'outputs': [word for word in arguments.outputs.split(',') if word]}
    if arguments.params_file is not None:
        return read_robots(arguments.params_file, chosen)
    return [robot_settings(arguments.name, {
        'description': arguments.robot, 'base_frame': arguments.base or '',
        'tip_frame': arguments.tip or '', 'joint_states_topic': arguments.topic, **chosen})]


def _process(recording: Recording, robots: Sequence[RecordedRobot], differences: Differences,
             writer: StateWriter | None, stages: StageTimes) -> None:
    """Read, compute, write and compare, some thousand messages at a time."""
    kinds = {JOINT_STATE} | {KINDS[d.output].type_name for _, d in differences.values()}

    def pass_on(robot: RobotStates, block: StateBlock) -> None:
        if writer is not None:
            with stages.stage('write'):
                writer.write(robot, block)
        for of, difference in differences.values():
            if of is robot:
                with stages.stage('compare'):
                    difference.add_states(block.stamps,
                                          values_of(robot, block, difference.output))

    messages = recording.messages(kinds)
    with Progress(*Progress.get_default_columns()[:3], MofNCompleteColumn(),
                  TimeRemainingColumn(), console=Console(stderr=True)) as progress:
        task = progress.add_task('messages', total=recording.message_count or None)
        while True:
            with stages.stage('read'):
                some = list(islice(messages, _AT_A_TIME))
            if not some:
                break
            for message in some:
                if message.topic in differences:
                    differences[message.topic][1].add_message(message.data)
            for robot in robots:
                for block in robot.take(some):
                    pass_on(robot.states, block)
            progress.advance(task, len(some))
        for robot in robots:
            for block in robot.states.finish():
                pass_on(robot.states, block)


def _report(recording: Recording, robots: Sequence[RecordedRobot],
            differences: Differences) -> int:
    """Print what became of the messages; return the exit code."""
    empty = False
    for robot in robots:
        states = robot.states
        account = states.account
        refused = ', '.join(f'{count} {reason}' for reason, count in
                            sorted(account.refused.items()) if count)
        print(f'{states.settings.name}: {account.received} joint samples on '
              f'{", ".join(robot.topics)}, {account.outputs} states of {", ".join(states.outputs)}'
              + (f'; not used: {refused}' if refused else ''))
        left_out = [name for name in states.settings.outputs if name in LEFT_OUT]
        if left_out:
            print(f'{states.settings.name}: not made from recordings: {", ".join(left_out)}')
        empty |= not account.outputs
    if differences:
        print(table((topic, difference) for topic, (_, difference) in differences.items()))
    for damage in recording.damage:
        print(f'bag: damaged: {damage}', file=sys.stderr)
    if recording.damage:
        saved = sum(robot.states.account.received for robot in robots)
        print(f'bag: {saved} joint samples were saved', file=sys.stderr)
    nothing_compared = bool(differences) and not any(
        difference.compared for _, difference in differences.values())
    return console.FOUND_PROBLEMS if recording.damage or empty or nothing_compared else (
        console.OK)


if __name__ == '__main__':
    sys.exit(main())
