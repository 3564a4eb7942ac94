# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The robot that a console program works on: options, model, reference motion."""
from __future__ import annotations

import argparse
from typing import Any

from .reference_motions import reference_motion, ReferenceMotion
from .. import models

PUMA = 'package://screw_kinematics/config/robots/puma560.yaml'


def add_options(options: argparse.ArgumentParser, default: str | None = None) -> None:
    """Add the choice of a robot model and its frames; positional without a default."""
    what = 'robot model: YAML or URDF file, or a file:// or package:// URI'
    if default is None:
        options.add_argument('robot', help=what)
    else:
        options.add_argument('--robot', default=default, metavar='MODEL',
                             help=f'{what} (default: {default})')
    options.add_argument('--base', metavar='FRAME', help='base frame (default: the root)')
    options.add_argument('--tip', metavar='FRAME', help='tip frame (default: the only leaf)')


def load(arguments: argparse.Namespace) -> Any:
    """
    Return the robot of the options.

    Raises
    ------
    ModelError
        The model cannot be read.

    """
    return models.load(arguments.robot, base_frame=arguments.base, tip_frame=arguments.tip)


def motion(robot: Any, name: str) -> ReferenceMotion:
    """
    Return the named reference motion for the measured joints of a robot.

    A parallel manipulator moves a little about its home posture, so that it stays within
    its workspace.
    """
    about_home = {} if not hasattr(robot, 'home') else {
        'centre': robot.home.actuated, 'size': 0.3}
    return reference_motion(name, robot.joint_kinds, **about_home)
