# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Show a robot and its measured motion in the browser.

From a recording, smoothed, or from a running node: links or skeleton, the tip's trail, twist,
acceleration and screw axis as arrows with their scales, time series, and the estimator's doubts.
The page answers this machine only, unless --host says otherwise.
"""
from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
import time

from .live import LiveRobots, look_around
from .motion import ShownMotion
from .page import open_server, Page, RATE, require_viser
from .recorded import recorded_motions
from .. import console, settings_options, stage
from ..processes import Children
from ...errors import ParameterError, ToolError
from ...node.stop_request import StopRequest
from ...pipeline.robot_model import build_model
from ...pipeline.settings import RobotSettings
from ...recordings.recording import full_name

EXAMPLES = """\
  view recording --robot panda.urdf --tip panda_hand_tcp
  view run.mcap --params-file kinematic_states.yaml --port 8090
  view --live                                what is published, with the model on robot_description
  view --live --params-file kinematic_states.yaml
  view recording --robot panda.urdf --output run.rrd      a file for Rerun, no page
"""
_PATIENCE = 60.0


def main(argv: Sequence[str] | None = None) -> int:
    """Run the tool; see ``view --help``."""
    options = console.parser('view', __doc__ or '', EXAMPLES)
    options.add_argument('recording', nargs='?', help='a bag, or a table of joint states')
    options.add_argument('--live', action='store_true', help='show the states of a running node')
    settings_options.add_options(options)
    options.add_argument('--name', help='name of the robot, with which its topics begin (default '
                                        'with --live: all that are published)')
    add_page_options(options)
    options.add_argument('--output', type=Path, metavar='FILE.rrd',
                         help='write a Rerun file of the recording and open no page')
    return console.run(_view, options, argv)


def add_page_options(options: argparse.ArgumentParser, *names: str) -> None:
    """Add where the page is, and how long, which may have other names beside."""
    options.add_argument('--host', default='127.0.0.1', help='address of the page (default: '
                         '127.0.0.1, for this machine only; 0.0.0.0: for the whole network)')
    options.add_argument('--port', type=int, default=8080, help='port of the page (default: 8080)')
    options.add_argument('--seconds', *names, type=float, default=float('inf'), metavar='S',
                         help='end after this time (default: at Ctrl-C)')


def check_page_options(arguments: argparse.Namespace) -> None:
    """Raise ParameterError if the time after which to end is none."""
    if not arguments.seconds > 0:
        raise ParameterError('seconds', arguments.seconds, 'more than 0')


def _view(arguments: argparse.Namespace) -> int:
    if bool(arguments.recording) == arguments.live:
        raise ParameterError('recording', arguments.recording, 'a recording or --live')
    if arguments.output is not None and not arguments.recording:
        raise ParameterError('output', str(arguments.output), 'with a recording')
    if arguments.output is not None and (
            arguments.output.suffix.lower() != '.rrd' or arguments.output.exists()):
        raise ParameterError('output', str(arguments.output), 'a new file ending in .rrd')
    check_page_options(arguments)
    settings = settings_options.settings_of(arguments)
    if arguments.output is None:
        require_viser()
    if arguments.live:
        with StopRequest() as stop:
            _show_live(arguments, settings, stop)
        return console.OK
    motions = recorded_motions(arguments.recording, settings, arguments.namespace)
    if arguments.output is not None:
        from .rerun_file import write_rerun
        write_rerun(arguments.output, motions)
        print(f'{arguments.output}: {sum(len(m.snapshots) for m in motions)} states')
        return console.OK
    with StopRequest() as stop:
        _show(arguments, motions, False, stop, time.sleep)
    return console.OK


def show_stage(arguments: argparse.Namespace, played: stage.Stage, stop: StopRequest) -> None:
    """Show the demo's robot, the node's states beside the truth, until asked to stop."""
    require_viser()
    motion = ShownMotion(played.name, played.robot, description=arguments.robot)
    with Children() as children:
        played.run(children)
        with LiveRobots([motion], [['joint_states']], played.namespace, played.exact) as robots:
            def listen(seconds: float) -> None:
                robots.listen(seconds)
                children.check()
            _wait(robots, [motion], listen, stop)
            _show(arguments, [motion], True, stop, listen)


def _show_live(arguments: argparse.Namespace, settings: Sequence[RobotSettings],
               stop: StopRequest) -> None:
    namespace = arguments.namespace
    topic_of = {robot.name: full_name(namespace, robot.description_topic)
                for robot in settings if not robot.description}
    names, texts = look_around(namespace, set(topic_of.values()))
    if arguments.name is None and arguments.params_file is None:
        if not names:
            raise ToolError('no twist and accel of a robot is published; is the node running, '
                            'and --namespace right?')
        settings = [replace(settings[0], name=name) for name in names]
        topic_of = {name: next(iter(topic_of.values())) for name in names if topic_of}
    motions = []
    for robot in settings:
        topic = topic_of.get(robot.name)
        if topic is not None and topic not in texts:
            raise ToolError(f'no robot description on {topic}; name a model with --robot')
        if robot.relative_to == 'world' and 'pose' not in robot.outputs:
            raise ParameterError(f'{robot.name}.outputs', list(robot.outputs), 'pose among them, '
                                 'which tells where the moving base is')
        if robot.reference_point == 'base':
            raise ParameterError(f'{robot.name}.reference_point', 'base', "'tip', whose motion "
                                 'is drawn')
        text = None if topic is None else texts[topic]
        motions.append(ShownMotion(robot.topic, build_model(robot, text),
                                   description=robot.description if text is None else text,
                                   world='odometry' if robot.relative_to == 'world' else ''))
    topics = [list(robot.joint_states_topic) for robot in settings]
    with LiveRobots(motions, topics, namespace) as robots:
        _wait(robots, motions, robots.listen, stop)
        _show(arguments, motions, True, stop, robots.listen)


def _wait(robots: LiveRobots, motions: Sequence[ShownMotion], listen: Callable[[float], None],
          stop: StopRequest) -> None:
    """Wait until there is a state of every robot."""
    end = time.monotonic() + _PATIENCE
    while not all(motion.snapshots for motion in motions):
        listen(0.1)
        if stop.made:
            raise KeyboardInterrupt
        if time.monotonic() > end:
            raise ToolError(f'no state within {_PATIENCE:.0f} s; nothing on: '
                            f'{", ".join(robots.silent()) or "none of the topics"}')


def _show(arguments: argparse.Namespace, motions: Sequence[ShownMotion], live: bool,
          stop: StopRequest, wait: Callable[[float], None]) -> None:
    server = open_server(arguments.host, arguments.port)
    try:
        page = Page(server, motions, live)
        print(f'http://{arguments.host}:{server.get_port()} shows '
              f'{", ".join(motion.name for motion in motions)}; Ctrl-C ends it', flush=True)
        begin = last = time.monotonic()
        with suppress(KeyboardInterrupt):
            while not stop.made and (now := time.monotonic()) - begin < arguments.seconds:
                page.step(now - last)
                last = now
                wait(max(1 / RATE - (time.monotonic() - now), 1e-3))
    finally:
        server.stop()
