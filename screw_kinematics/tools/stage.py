# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The node, and a robot in a motion that is known exactly: processes that tools show."""
from __future__ import annotations

import argparse
import os
from pathlib import Path
import re
import secrets
import time
from typing import Any

from . import robot_options
from .joint_state_source.main import add_motion_options, check_rate
from .listener import check_names, require_ros
from .processes import Children
from ..errors import ParameterError
from ..screws.body_state import BodyState

OUTPUTS = ('pose', 'twist', 'accel')


def add_options(options: argparse.ArgumentParser) -> None:
    """Add robot, motion, and what the node is told."""
    robot_options.add_options(options, default=robot_options.PUMA)
    add_motion_options(options)
    options.add_argument('--delay', type=float, default=0.0, metavar='SECONDS',
                         help='delay of the states behind the latest sample, which makes '
                              'accelerations several times as accurate (default: 0)')
    # Two demos on one machine would otherwise hear each other's joint states.
    options.add_argument('--namespace', default=f'demo_{secrets.token_hex(3)}',
                         help='ROS namespace of the demo (default: one of its own)')


class Stage:
    """A robot that moves as a reference motion says, and the node that watches it."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        require_ros()
        if not 0 <= arguments.delay <= 1:
            raise ParameterError('delay', arguments.delay, '0 to 1 s')
        check_rate(arguments.rate)
        check_names(arguments.namespace, ())
        self._arguments = arguments
        self.robot = robot_options.load(arguments)
        name = re.sub('[^A-Za-z0-9_]', '_', self.robot.name).strip('_')
        self.name = name if name[:1].isalpha() else f'robot_{name}'.rstrip('_')
        self.namespace = arguments.namespace
        self.motion = robot_options.motion(self.robot, arguments.motion)
        self.start = time.time_ns()     # when the motion's time is 0

    def run(self, children: Children) -> None:
        """Start the node and the publisher of the joint states."""
        # It talks to itself: nothing of it should reach the robots of the network.
        os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        children.start('the node', 'screw_kinematics.node.main', self._node())
        children.start('the joint state publisher',
                       'screw_kinematics.tools.joint_state_source.main', self._source())

    def elapsed(self, stamp: int) -> float:
        """Return the motion's time at an epoch time in ns [s]."""
        return (stamp - self.start) * 1e-9

    def exact(self, stamp: int) -> BodyState:
        """Return the true state, to the acceleration, at an epoch time in ns."""
        state: BodyState = self.robot.state(*self.motion.derivatives(self.elapsed(stamp), 2))
        return state

    def _node(self) -> list[str]:
        """Return the command line of the node."""
        given, name = self._arguments, self.name
        parameters: dict[str, Any] = {
            'robots': f'[{name}]',
            f'{name}.description': _absolute(given.robot),
            f'{name}.outputs': f'[{", ".join(OUTPUTS)}]',
            f'{name}.estimator.delay': float(given.delay),
        }
        if given.base:
            parameters[f'{name}.base_frame'] = given.base
        if given.tip:
            parameters[f'{name}.tip_frame'] = given.tip
        out = ['--ros-args', '-r', f'__ns:=/{self.namespace}']
        for key, value in parameters.items():
            out += ['-p', f'{key}:={value}']
        return out

    def _source(self) -> list[str]:
        """Return the command line of the joint state publisher."""
        given = self._arguments
        out = [f'--robot={given.robot}', f'--motion={given.motion}', f'--rate={given.rate}',
               f'--stamps={given.stamps}', f'--start={self.start}',
               f'--namespace=/{self.namespace}']
        if given.base:
            out.append(f'--base={given.base}')
        if given.tip:
            out.append(f'--tip={given.tip}')
        return out


def _absolute(model: str) -> str:
    return model if '://' in model else str(Path(model).absolute())
