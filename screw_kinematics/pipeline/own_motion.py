# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The motion of a tip as something fixed to it feels it: about its own origin, in its own axes."""
from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from .payload import cross, Vector
from .settings import RobotSettings
from ..programs.machine import machine
from ..programs.tracing import Graph, straight_line
from ..screws.rigid import pose_from_row
from ..screws.se3 import Array

Slices = Mapping[str, slice]

NEEDS = ('pose', 'twist', 'accel')
"""Outputs of a program that it is made from: 12, 6 and 6 numbers."""


class Felt(NamedTuple):
    """Motion of a frame, in its own axes; the numbers are traced."""

    to_base: Array    # (3, 3), from its axes to those of the base
    place: Array      # of its origin, from that of the base [m]
    omega: Array      # angular velocity [rad/s]
    alpha: Array      # angular acceleration [rad/s^2]
    a: Array          # classical acceleration of its origin [m/s^2]

    def at(self, pose: Array) -> Felt:
        """Return the motion of another frame that is fixed to this one, at a pose in it."""
        turn, arm = pose[:3, :3], pose[:3, 3]
        a = self.a + _swept(self.omega, self.alpha, arm)
        return Felt(self.to_base @ turn, *(
            x @ turn for x in (self.place + arm, self.omega, self.alpha, a)))

    def specific_force(self, gravity: Vector) -> Array:
        """Return the acceleration less that of free fall, which is in base axes [m/s^2]."""
        return self.a - np.array(gravity) @ self.to_base    # type: ignore[no-any-return]


class OwnMotion:
    """
    What is made of the motion of a tip, read out of the values of a program.

    It is `made` of that motion and of so many more numbers, once, as a program of its own.
    """

    def __init__(self, slices: Slices, settings: RobotSettings,
                 made: Callable[[Felt, Array], Sequence[Any]], more: int) -> None:
        self._parts = [slices[need] for need in NEEDS]
        numbers = Graph().inputs(24 + more)
        pose, (omega, _), (alpha, a) = (
            pose_from_row(numbers[:12]), numbers[12:18].reshape(2, 3),
            numbers[18:24].reshape(2, 3))
        to_base = pose[:3, :3]
        if settings.expressed_in == 'base':
            omega, alpha, a = (x @ to_base for x in (omega, alpha, a))
        place = pose[:3, 3] @ to_base
        if settings.reference_point == 'base':
            a = a + _swept(omega, alpha, place)
        self._machine = machine(straight_line(
            len(numbers), made(Felt(to_base, place, omega, alpha, a), numbers[24:])))

    def of(self, values: Sequence[float], more: Sequence[float]) -> tuple[float, ...]:
        """Return what is made of a robot's values, and of more numbers."""
        pose, twist, accel = self._parts
        return self._machine.evaluate((*values[pose], *values[twist], *values[accel], *more))


def _swept(omega: Array, alpha: Array, arm: Array) -> Array:
    """Return by how much the acceleration at the end of an arm is another one."""
    return np.array(cross(alpha, arm)) + np.array(cross(omega, cross(omega, arm)))
