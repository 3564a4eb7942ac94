# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The motion of a tip as something fixed to it feels it: about its own origin, in its own axes."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from .payload import cross, Vector
from .settings import RobotSettings
from ..screws.se3 import Array

Slices = Mapping[str, slice]

NEEDS = ('pose', 'twist', 'accel')
"""Outputs of a program that it is made from."""


class Felt(NamedTuple):
    """Motion of a frame, in its own axes."""

    to_base: Array    # (3, 3), from its axes to those of the base
    omega: Vector     # angular velocity [rad/s]
    alpha: Vector     # angular acceleration [rad/s^2]
    a: Vector         # classical acceleration of its origin [m/s^2]

    def at(self, pose: Array) -> Felt:
        """Return the motion of another frame that is fixed to this one, at a pose in it."""
        turn, arm = pose[:3, :3], pose[:3, 3].tolist()
        swept = cross(self.omega, cross(self.omega, arm))
        a = [x + y + z for x, y, z in zip(self.a, cross(self.alpha, arm), swept)]
        omega, alpha, a = (np.array((self.omega, self.alpha, a)) @ turn).tolist()
        return Felt(self.to_base @ turn, omega, alpha, a)

    def specific_force(self, gravity: Array) -> tuple[Vector, Vector, Vector]:
        """Return acceleration less free fall, which is in base axes; omega; and alpha."""
        return (np.array(self.a) - self.to_base.T @ gravity).tolist(), self.omega, self.alpha


class OwnMotion:
    """Reads the motion of a tip out of the values of a program."""

    def __init__(self, slices: Slices, settings: RobotSettings) -> None:
        self._pose, self._twist, self._accel = (slices[need] for need in NEEDS)
        self._in_base = settings.expressed_in == 'base'
        self._at_base = settings.reference_point == 'base'

    def of(self, values: Sequence[Any]) -> Felt:
        """Return the motion of the tip."""
        row = values[self._pose]
        to_base = np.array(row[3:]).reshape(3, 3)
        omega, alpha, a = (values[self._twist][:3], values[self._accel][:3],
                           values[self._accel][3:])
        if self._in_base:
            omega, alpha, a = (np.array((omega, alpha, a)) @ to_base).tolist()
        if self._at_base:       # from the point at the base's origin to the tip
            arm = (to_base.T @ row[:3]).tolist()
            a = [x + y + z for x, y, z in zip(
                a, cross(alpha, arm), cross(omega, cross(omega, arm)))]
        return Felt(to_base, omega, alpha, a)
