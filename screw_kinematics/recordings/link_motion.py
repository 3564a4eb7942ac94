# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The motion of one link in a recording, by past and future."""
from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .recording import Recording
from .states import recorded_robot
from ..errors import ToolError
from ..pipeline.settings import RobotSettings
from ..screws.se3 import Array


class LinkMotion(NamedTuple):
    """Motion of a link in the base frame; in the world, if the robot's is relative to that."""

    stamps: Array      # (N,) [ns]
    rotation: Array    # (N, 3, 3), from link coordinates to those of that frame
    position: Array    # (N, 3), of its origin; so are the others, classical
    velocity: Array
    acceleration: Array
    angular_velocity: Array
    angular_acceleration: Array

    def in_link(self, vectors: Array) -> Array:
        """Return vectors of that frame in coordinates of the link, shape (N, 3)."""
        return np.einsum('nji,nj->ni', self.rotation, vectors)


def link_motion(recording: Recording, settings: RobotSettings, namespace: str) -> LinkMotion:
    """Return the motion of a robot's tip in a recording."""
    # None of its outputs is wanted, nor what else they need.
    robot = recorded_robot(recording, replace(settings, outputs=('pose',)), namespace, order=2)
    tip = robot.at_tip('pose', 'twist', 'accel')
    stamps: list[Array] = []
    rows: list[Array] = []
    for block in robot.states(recording):
        found = tip(block)
        stamps.append(block.stamps)
        rows.append(np.concatenate([found['pose'], found['twist'], found['accel']], axis=1))
    if not stamps:
        raise ToolError(f'{recording.path}: no states of {settings.name}; see check bag')
    at, values = np.concatenate(stamps), np.concatenate(rows)
    ahead = np.concatenate([[True], np.diff(np.maximum.accumulate(at)) > 0])
    at, values = at[ahead], values[ahead]
    return LinkMotion(at, values[:, 3:12].reshape(-1, 3, 3), values[:, :3], values[:, 15:18],
                      values[:, 21:24], values[:, 12:15], values[:, 18:21])
