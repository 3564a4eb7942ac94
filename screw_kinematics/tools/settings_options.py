# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The robots that a tool is about: those of a file of parameters, or one by options."""
from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

from ..pipeline.parameter_file import read_robots, robot_settings
from ..pipeline.settings import RobotSettings


def settings_of(arguments: argparse.Namespace, instead: Mapping[str, Any] | None = None,
                ) -> list[RobotSettings]:
    """
    Return the settings of each robot, and of each tip of several.

    Parameters
    ----------
    arguments : argparse.Namespace
        With params_file and namespace; robot, base, tip, name and topic of the only robot.
    instead : mapping of str to value, optional
        Parameters of robots that take precedence.

    Raises
    ------
    ToolError, ParameterError
        The file is not readable, or a parameter has a wrong value.

    """
    instead = instead or {}
    if arguments.params_file is not None:
        return read_robots(arguments.params_file, instead, arguments.namespace or '')
    return [robot_settings(arguments.name or 'robot', {
        'description': arguments.robot or '', 'base_frame': arguments.base or '',
        'tip_frame': arguments.tip or '', 'joint_states_topic': arguments.topic, **instead})]
