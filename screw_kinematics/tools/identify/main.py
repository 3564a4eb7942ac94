# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Find parameters of the node from measurements, and print them as a file of parameters.

Exit code 0: found; 1: found, but they cannot be trusted; 2: not found.
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from .payload import as_yaml, Identified, report
from .picture import draw_payload
from .. import console, live_recording, settings_options
from ..check.findings import Finding, has_problem, REMARK
from ..plot.histories import check_ending, ENDINGS
from ...errors import MalformedMessageError, ModelError, ParameterError, ToolError
from ...messages.wrench import TYPE
from ...pipeline.setting import numbers
from ...pipeline.settings import RobotSettings
from ...recordings.clock_offset import ClockOffset, find_offset, UNRELATED, VAGUE
from ...recordings.link_motion import link_motion, LinkMotion
from ...recordings.motion_streams import channels, Stream
from ...recordings.payload_fit import fit_payload
from ...recordings.recording import full_name, Recording
from ...recordings.wrenches import recorded_wrenches
from ...screws.se3 import Array

EXAMPLES = """\
  identify payload recording --robot arm.urdf --wrench /ft/wrench
  identify payload recording --robot arm.urdf --wrench /ft/wrench --frame tool0 > payload.yaml
  identify payload --params-file kinematic_states.yaml --wrench /ft/wrench --seconds 60
                                             of the running system
"""
_LEAST_OFFSET = 2e-4    # that is told [s]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the tool; see ``identify --help``."""
    options = console.parser('identify', __doc__ or '', EXAMPLES)
    kinds = options.add_subparsers(dest='kind', required=True, metavar='KIND')
    payload = kinds.add_parser('payload', help='mass, centre and inertia of what a force sensor '
                                               "carries, and the sensor's bias")
    live_recording.add_options(payload)
    payload.add_argument('--wrench', required=True, metavar='TOPIC',
                         help='topic of the sensor, geometry_msgs/WrenchStamped')
    payload.add_argument('--frame', '--tip', metavar='LINK',
                         help="the sensor's link (default: frame_id of its messages)")
    settings_options.add_options(payload, tip=False)
    payload.add_argument('--name', metavar='NAME', help='name of the robot in the parameters '
                         '(default: the only one of FILE, or robot)')
    payload.add_argument('--gravity', nargs=3, type=float, metavar=('X', 'Y', 'Z'),
                         help='acceleration of free fall in base axes [m/s^2] '
                              '(default: 0 0 -9.80665)')
    payload.add_argument('--plot', type=Path, metavar='FILE',
                         help='plot the wrench with and without the load into a file ending in '
                              f'{", ".join(ENDINGS)}')
    payload.set_defaults(find=_payload)
    return console.run(lambda arguments: int(arguments.find(arguments)), options, argv)


def _payload(arguments: argparse.Namespace) -> int:
    if arguments.plot is not None:
        check_ending(arguments.plot)
    robot = _robot(arguments)
    topic = full_name(arguments.namespace, arguments.wrench)
    with live_recording.recording_of(arguments, [robot], topic) as recording:
        frame, stamps, values = _wrenches(recording, topic)
        link = arguments.frame or robot.wrench_frame or frame.removeprefix(robot.frame_prefix)
        motion = _motion(recording, robot, arguments.namespace, topic, link)
        damage = [Finding(REMARK, f'damaged: {text}') for text in recording.damage]
    clock = _clock(motion, stamps, values)
    if clock is not None:
        stamps = stamps + round(1e9 * clock.offset)
    fit = fit_payload(motion, stamps, values, robot.gravity)
    found = Identified(robot, arguments.wrench, link, fit, clock)
    if arguments.plot is not None:
        draw_payload(arguments.plot, found)
    findings = [*damage, *report(found)]
    print(as_yaml(found, findings), end='')
    return console.FOUND_PROBLEMS if has_problem(findings) else console.OK


def _robot(arguments: argparse.Namespace) -> RobotSettings:
    """Return the one robot that is meant."""
    gravity = {}
    if arguments.gravity is not None:
        try:
            gravity = {'gravity': numbers(3, 1000.0)(arguments.gravity)}
        except ValueError:
            raise ParameterError('gravity', arguments.gravity,
                                 'three finite numbers of at most 1000') from None
    robots = settings_options.settings_of(arguments, gravity)
    named = [robot for robot in robots if arguments.name in (None, robot.name)]
    if len(named) != 1:
        raise ParameterError('name', arguments.name, 'one of '
                             + ', '.join(robot.name for robot in robots))
    return named[0]


def _wrenches(recording: Recording, topic: str) -> tuple[str, Array, Array]:
    """Return the frame, stamps that increase, and values of a force sensor."""
    samples = [sample for sample in recorded_wrenches(recording, topic)
               if not isinstance(sample, MalformedMessageError)
               and np.isfinite(sample.values).all()]
    if not samples:
        raise ToolError(f'{recording.path}: {topic}: no wrench is of finite numbers')
    frames = sorted({sample.frame_id for sample in samples})
    if len(frames) > 1:
        raise ToolError(f'{recording.path}: {topic}: wrenches are in the frames '
                        f'{", ".join(map(repr, frames))}; allowed: one')
    stamps, first = np.unique([sample.stamp_ns for sample in samples], return_index=True)
    return frames[0], stamps, np.array([samples[k].values for k in first])


def _motion(recording: Recording, robot: RobotSettings, namespace: str, topic: str, link: str,
            ) -> LinkMotion:
    """Return the motion of the sensor's link."""
    asked = replace(robot, tip_frame=link, tips=(), of_tips=(), tool_offset=(0.0,) * 6,
                    wrench_frame='')
    try:
        return link_motion(recording, asked, namespace)
    except ModelError as error:
        raise ModelError(error.source, f'{error.problem}, as the link of {topic}; name the '
                         "sensor's link by --frame") from None


def _clock(motion: LinkMotion, stamps: Array, values: Array) -> ClockOffset | None:
    """Return how far the sensor's clock is from that of the joint states, if that is certain."""
    stream = Stream(TYPE, stamps, values[:, :3])
    try:
        clock = find_offset(motion.stamps, stamps, channels(stream, motion))
    except ToolError:       # too short, or no motion: the fit says so
        return None
    certain = clock.deviation < VAGUE and clock.shares[0] > UNRELATED
    apart = abs(clock.offset) > max(_LEAST_OFFSET, 4 * clock.deviation)
    return clock if certain and apart else None
