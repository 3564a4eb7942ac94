# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The robots that a tool is about: those of a file of parameters, or one by options."""
from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .robot_options import Model
from ..pipeline.parameter_file import read_robots, robot_settings
from ..pipeline.settings import RobotSettings


def add_options(options: argparse.ArgumentParser, required: bool = False, tip: bool = True,
                topic: str = '--topic') -> None:
    """Add which robots are meant, by a file or by one model; where the joint states come."""
    which = options.add_mutually_exclusive_group(required=required)
    which.add_argument('--params-file', type=Path, metavar='FILE',
                       help='parameter file of the node: robots and settings')
    which.add_argument('--robot', nargs='+', action=Model, metavar='MODEL',
                       help='one robot: YAML, URDF or xacro, path or URI'
                            + ('' if required else ' (default: the one on robot_description)'))
    options.add_argument('--base', metavar='FRAME', help='base frame, with --robot')
    if tip:
        options.add_argument('--tip', metavar='FRAME', help='tip frame, with --robot')
    options.add_argument(topic, dest='topic', default='joint_states', metavar='TOPIC',
                         help='topic of the joint states, without --params-file '
                              '(default: joint_states)')
    options.add_argument('--namespace', default='',
                         help='ROS namespace of the node (default: none)')
    options.set_defaults(name=None, **({} if tip else {'tip': None}))


def settings_of(arguments: argparse.Namespace, instead: Mapping[str, Any] | None = None,
                ) -> list[RobotSettings]:
    """
    Return the settings of each robot, and of each tip of several.

    Parameters given instead take precedence over those of the file.
    """
    instead = instead or {}
    if arguments.params_file is not None:
        return read_robots(arguments.params_file, instead, arguments.namespace)
    return [robot_settings(arguments.name or 'robot', {
        'description': arguments.robot or '', 'base_frame': arguments.base or '',
        'tip_frame': arguments.tip or '', 'joint_states_topic': arguments.topic, **instead})]
