# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Say what would be wrong: with a robot model, a running system, or a recording.

Exit code 0: no problem; 1: problems were found; 2: the check could not be made.
"""
from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .delay import recommend
from .findings import FACT, Finding, has_problem, print_findings, PROBLEM, REMARK
from .model import report_model
from .offset import compare_clocks
from .samples import label_of, report_streams
from .. import console, live_recording, robot_options, settings_options, table_options
from ..plot.histories import check_ending, ENDINGS
from ... import core, models
from ...errors import ParameterError, ScrewKinematicsError
from ...pipeline.robot_model import build_model, continuous_joints
from ...pipeline.settings import RobotSettings
from ...recordings.joint_streams import JointStream, JointStreams
from ...recordings.joint_table import JointTable
from ...recordings.recording import description_in, full_name
from ...recordings.sources import opened

EXAMPLES = """\
  check model panda.urdf --base panda_link0 --tip panda_hand_tcp
  check system                                robot_description and joint_states, 10 s
  check system --params-file kinematic_states.yaml --seconds 20
  check bag recording --robot config/robots/panda.yaml
  check delay recording --robot panda.urdf --against /wrench
  check delay --robot panda.urdf --against /wrench --seconds 30 --plot clocks.png
                                              of the running system
  check imu recording --robot panda.urdf --frame panda_hand --topic /imu/data
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the tool; see ``check --help``."""
    options = console.parser('check', __doc__ or '', EXAMPLES)
    kinds = options.add_subparsers(dest='kind', required=True, metavar='KIND')
    model = kinds.add_parser('model', help='a robot model')
    robot_options.add_options(model)
    model.set_defaults(find=_model)
    system = kinds.add_parser('system', help='a running system, by what it publishes')
    system.add_argument('--seconds', type=float, default=10.0,
                        help='how long to listen (default: 10); let the robot rest and move')
    system.set_defaults(find=_system)
    bag = kinds.add_parser('bag', help='the joint states in a recording')
    bag.add_argument('bag', help='a folder, a .mcap, .db3 or .bag file, a table, or a URL')
    table_options.add_options(bag)
    bag.set_defaults(find=_recording)
    delay = kinds.add_parser('delay', help='the clock of the joint states against another stream '
                                           'that saw the same motion')
    imu = kinds.add_parser('imu', help='an IMU on a link against the motion of that link')
    for against in (delay, imu):
        live_recording.add_options(against)
        against.add_argument('--plot', type=Path, metavar='FILE',
                             help='plot the correlation and the two signals into a file '
                                  f'ending in {", ".join(ENDINGS)}')
        against.set_defaults(find=_against)
    delay.add_argument('--against', required=True, metavar='TOPIC', help='topic of something '
                       'fixed to the tip: sensor_msgs/Imu, geometry_msgs/WrenchStamped or '
                       'PoseStamped, nav_msgs/Odometry')
    imu.add_argument('--topic', dest='against', default='imu/data', metavar='TOPIC',
                     help='topic of the IMU, sensor_msgs/Imu (default: imu/data)')
    imu.add_argument('--frame', dest='tip', metavar='LINK', help='link that the IMU is fixed to')
    for with_robots in (system, bag, delay):
        settings_options.add_options(with_robots)
    settings_options.add_options(imu, tip=False, topic='--joint-states')
    return console.run(_check, options, argv)


def _check(arguments: argparse.Namespace) -> int:
    build = core.build()
    findings = [*arguments.find(arguments), Finding(
        FACT if build.compiled else REMARK, f'the core is {build.state}', build.advice)]
    print_findings(findings)
    return console.FOUND_PROBLEMS if has_problem(findings) else console.OK


def _model(arguments: argparse.Namespace) -> Iterator[Finding]:
    try:
        robot = models.load(arguments.robot, arguments.base, arguments.tip)
    except ScrewKinematicsError as error:
        yield Finding(PROBLEM, str(error))
        return
    yield from report_model(robot)


def _system(arguments: argparse.Namespace) -> Iterator[Finding]:
    from .system import listen
    if not 0 < arguments.seconds <= 3600:
        raise ParameterError('seconds', arguments.seconds, 'more than 0, at most 3600')
    settings = settings_options.settings_of(arguments)
    heard = listen(_topics(settings, arguments.namespace),
                   {full_name(arguments.namespace, s.description_topic) for s in settings
                    if not s.description}, arguments.seconds)
    yield from heard.findings
    yield from _report(settings, arguments.namespace, heard.streams, heard.descriptions)


def _recording(arguments: argparse.Namespace) -> Iterator[Finding]:
    settings = settings_options.settings_of(arguments)
    streams = {topic: JointStreams() for topic in _topics(settings, arguments.namespace)}
    descriptions = {}
    with opened(arguments.bag, table_options.table_format(arguments)) as recording:
        if isinstance(recording, JointTable):
            for robot in settings:
                model = build_model(robot)
                topic = full_name(arguments.namespace, robot.joint_states_topic[0])
                for _, received, sample in recording.samples(
                        dict(zip(model.joint_names, model.joint_kinds))):
                    streams[topic].take(received, sample)
        else:
            for topic, received, sample in recording.samples(set(streams)):
                streams[topic].take(received, sample)
        for damage in recording.damage:
            yield Finding(PROBLEM, f'damaged: {damage}')
        for robot in settings:
            if not robot.description and not isinstance(recording, JointTable):
                topic = full_name(arguments.namespace, robot.description_topic)
                text = description_in(recording, topic)
                if text is not None:
                    descriptions[topic] = text
    yield from _report(settings, arguments.namespace, streams, descriptions)


def _against(arguments: argparse.Namespace) -> Iterator[Finding]:
    robots = settings_options.settings_of(arguments)
    if arguments.plot is not None:
        check_ending(arguments.plot)
        if len(robots) > 1:
            raise ParameterError('plot', str(arguments.plot), 'none with several robots')
    with live_recording.recording_of(arguments, robots, arguments.against) as recording:
        for robot in robots:
            if arguments.tip:
                robot = replace(robot, tip_frame=arguments.tip)
            yield from compare_clocks(recording, robot, arguments.namespace, arguments.against,
                                      arguments.plot)
        for damage in recording.damage:
            yield Finding(PROBLEM, f'damaged: {damage}')


def _topics(settings: Sequence[RobotSettings], namespace: str) -> list[str]:
    return [full_name(namespace, topic) for robot in settings
            for topic in robot.joint_states_topic]


def _report(settings: Sequence[RobotSettings], namespace: str,
            streams: Mapping[str, JointStreams], descriptions: Mapping[str, str],
            ) -> Iterator[Finding]:
    """Yield what is found about each robot: its model, its samples, its settings."""
    for robot in settings:
        text = None
        if not robot.description:
            topic = full_name(namespace, robot.description_topic)
            text = descriptions.get(topic)
            if text is None:
                yield Finding(PROBLEM, f'{robot.name}: no robot description on {topic}',
                              'is robot_state_publisher running? else name a model')
                continue
        try:
            model = build_model(robot, text)
        except ScrewKinematicsError as error:
            yield Finding(PROBLEM, f'{robot.name}: {error}')
            continue
        yield from report_model(model)
        topics = [full_name(namespace, topic) for topic in robot.joint_states_topic]
        come = {name for topic in topics for names in streams[topic].streams for name in names}
        for topic in topics:
            # What another topic of this robot brings is not missing here.
            here = {name for names in streams[topic].streams for name in names}
            wanted = {name: kind for name, kind in zip(model.joint_names, model.joint_kinds)
                      if name in here or name not in come}
            yield from report_streams(topic, streams[topic], wanted)
            for stream in streams[topic].streams.values():
                yield from _recommend(label_of(topic, stream, len(streams[topic].streams)), stream,
                                      model, robot.motion.delay)


def _recommend(label: str, stream: JointStream, model: Any, delay: float,
               ) -> Iterator[Finding]:
    columns = [i for i, name in enumerate(stream.names) if name in model.joint_names]
    if not columns or not len(stream):
        return
    wraps = dict(zip(model.joint_names, continuous_joints(model)))
    time = stream.times() if any(stream.stamps) else (
        (np.array(stream.received) - stream.received[0]) * 1e-9)
    position, velocity = stream.position()[:, columns], stream.velocity()[:, columns]
    latest = np.concatenate([[-np.inf], np.maximum.accumulate(time)[:-1]])
    good = np.isfinite(position).all(axis=1) & (time > latest)
    measured = velocity[good] if np.isfinite(velocity).any() else None
    names = [stream.names[i] for i in columns]
    yield from recommend(label, names, time[good], position[good], measured,
                         [wraps[name] for name in names], delay)
