# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The robot that a console program works on: options, model, reference motion."""
from __future__ import annotations

import argparse
import sys
from typing import Any

from .reference_motions import reference_motion, ReferenceMotion
from .. import models
from ..models.xacro_file import joined_arguments

PUMA = 'package://screw_kinematics/config/robots/puma560.yaml'


def add_options(options: argparse.ArgumentParser, default: str | None = None) -> None:
    """Add the choice of a robot model and its frames; positional without a default."""
    what = ('robot model: YAML, URDF or xacro file, or a file:// or package:// URI; after a xacro '
            'file also its arguments, ARG:=VALUE')
    if default is None:
        options.add_argument('robot', nargs='+', action=Model, metavar='MODEL', help=what)
    else:
        options.add_argument('--robot', default=default, nargs='+', action=Model,
                             metavar='MODEL', help=f'{what} (default: {default})')
    options.add_argument('--base', metavar='FRAME', help='base frame (default: the root)')
    options.add_argument('--tip', metavar='FRAME', help='tip frame (default: the only leaf)')


class Model(argparse.Action):
    """Keeps a model and the arguments behind it as one text, as descriptions have them."""

    def __call__(self, parser: argparse.ArgumentParser, namespace: argparse.Namespace,
                 values: Any, option_string: str | None = None) -> None:
        """Take the words of an option."""
        file, *rest = values
        for word in rest:
            if ':=' not in word:
                parser.error(f'{self.metavar}: got {word!r} behind {file!r}; allowed: ARG:=VALUE')
        words = [word.partition(':=') for word in rest]
        setattr(namespace, self.dest,
                joined_arguments(file, {name: value for name, _, value in words}))


def load(arguments: argparse.Namespace, symbolic: bool = False) -> Any:
    """
    Return the robot of the options; print what was passed over in its description.

    Lengths that a model file names stay symbols if wanted.
    """
    symbol = None
    if symbolic:
        from ..symbolic.expressions import parameter
        symbol = parameter
    robot = models.load(arguments.robot, base_frame=arguments.base or None,
                        tip_frame=arguments.tip or None, symbol=symbol)
    for warning in robot.warnings:
        print(f'{arguments.robot}: {warning}', file=sys.stderr)
    return robot


def motion(robot: Any, name: str) -> ReferenceMotion:
    """
    Return the named reference motion for the measured joints of a robot.

    A parallel manipulator moves a little about its home posture, so that it stays within
    its workspace.
    """
    about_home = {} if not hasattr(robot, 'home') else {
        'centre': robot.home.actuated, 'size': 0.3}
    return reference_motion(name, robot.joint_kinds, **about_home)
