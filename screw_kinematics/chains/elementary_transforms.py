# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
A chain as turns about coordinate axes, with translations between them.

A turn about a coordinate axis changes two components of a vector and costs six
operations, a general rotation fifteen. The axes between two joints may be chosen freely:
here they stay parallel to the base's (at q = 0) while joint axes are parallel to them, and
are turned by constant angles where they are not. A constant turn about the axis of the
joint before it is no work at all, only an offset of its angle. Consecutive joints with
parallel axes turn everything beyond them once, by the sum of their angles.
"""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import atan2, pi
from typing import Any, TYPE_CHECKING

import numpy as np

from ..programs.tracing import SNAP
from ..screws.se3 import Array, rotation_about

if TYPE_CHECKING:
    from .serial_chain import SerialChain

Derivatives = list[Any]
"""A value and its time derivatives, constant or traced."""


@dataclass(eq=False)
class Translation:
    """
    A shift of the origin, in the axes of its place.

    A constant part [m], and directions each with an amount and its time derivatives.
    """

    constant: Array = field(default_factory=lambda: np.zeros(3))
    moving: list[tuple[Array, Derivatives]] = field(default_factory=list)

    def turn_axes(self, axis: int, angle: float) -> None:
        """Change to axes turned by a constant angle [rad] about x, y or z (0, 1 or 2)."""
        into = rotation_about(np.eye(3)[axis], -angle)
        self.constant = into @ self.constant
        self.moving = [(into @ direction, amount) for direction, amount in self.moving]

    def is_along(self, axis: int) -> bool:
        """Whether nothing is shifted across an axis, so that turns about it commute."""
        vectors = [self.constant, *[direction for direction, _ in self.moving]]
        return all(abs(v[k]) <= SNAP for v in vectors for k in range(3) if k != axis)


@dataclass(eq=False)
class ParallelTurns:
    """
    Turns about parallel axes, each followed by a translation in the axes after it.

    Angles, with their time derivatives, are measured from the axes before the first.
    """

    axis: int
    angles: list[Derivatives]
    translations: list[Translation]


@dataclass(eq=False)
class TransformSequence:
    """
    A chain from base to tip, with time derivatives to an order.

    First a translation in base axes, before all turns; behind the last of these the rotation from
    tip coordinates to the axes there.
    """

    order: int
    base: Translation = field(default_factory=Translation)
    turns: list[ParallelTurns] = field(default_factory=list)
    orientation: Array = field(default_factory=lambda: np.eye(3))

    @property
    def last(self) -> Translation:
        """Return the translation at the tip end."""
        return self.turns[-1].translations[-1] if self.turns else self.base

    def turn(self, axis: int, angle: Derivatives) -> None:
        """Add a turn at the tip end, by an angle with its time derivatives, constant or traced."""
        if not self.turns or self.turns[-1].axis != axis:
            self.turns.append(ParallelTurns(axis, [angle], [Translation()]))
            return
        turn = self.turns[-1]
        total = [a + b for a, b in zip(turn.angles[-1], angle)]
        if self.last.is_along(axis):
            turn.angles[-1] = total
        else:
            turn.angles.append(total)
            turn.translations.append(Translation())

    def constant_turn(self, axis: int, angle: float) -> None:
        """Add a constant turn [rad] at the tip end."""
        if self.turns and self.turns[-1].axis == axis:
            value = self.turns[-1].angles[-1]
            self.turns[-1].angles[-1] = [value[0] + angle, *value[1:]]
            self.last.turn_axes(axis, angle)
        else:
            self.turn(axis, [angle] + [0.0] * self.order)


def transform_sequence(chain: SerialChain, motion: Sequence[Derivatives]) -> TransformSequence:
    """Return a chain of numbers as a sequence of elementary transforms, to the motion's order."""
    result = TransformSequence(order=len(motion[0]) - 1 if motion else 0)
    axes, origin = np.eye(3), np.zeros(3)    # the present axes and origin, at q = 0

    def turn_axes(axis: int, angle: float) -> None:
        nonlocal axes
        result.constant_turn(axis, angle)
        axes = axes @ rotation_about(np.eye(3)[axis], angle)

    def move_origin(point: Array) -> None:
        nonlocal origin
        result.last.constant = result.last.constant + axes.T @ (point - origin)
        origin = point

    for joint, values in zip(chain.joints, motion):
        direction = axes.T @ joint.axis
        if joint.kind == 'prismatic':
            result.last.moving.append((direction, values))
            continue
        for axis, angle in _alignment(direction, result.turns):
            turn_axes(axis, angle)
        direction = axes.T @ joint.axis
        move_origin(joint.point)
        k = int(np.argmax(np.abs(direction)))
        sign = float(np.sign(direction[k]))
        result.turn(k, [sign * value for value in values])
        if joint.kind == 'helical':
            result.last.moving.append((sign * joint.pitch * np.eye(3)[k], values))
    tool = chain.T_base_tool
    if result.turns:
        turn_axes(*_spin(axes.T @ tool[:3, :3], result.turns[-1].axis))
    move_origin(tool[:3, 3])
    result.orientation = axes.T @ tool[:3, :3]
    return result


def _alignment(direction: Array, turns: list[ParallelTurns]) -> list[tuple[int, float]]:
    """Return constant turns after which a direction is along a coordinate axis."""
    large = [k for k in range(3) if abs(direction[k]) > SNAP]
    if len(large) == 1:
        return []
    if len(large) == 2:
        axis = 3 - sum(large)
        angle = _angle(direction, axis)
        # Either coordinate axis of the plane will do: the nearer one.
        return [(axis, angle - pi / 2 * round(angle / (pi / 2)))]
    axis = turns[-1].axis if turns else 2
    first = _angle(direction, axis)
    rest = rotation_about(np.eye(3)[axis], -first) @ direction
    rest[(axis + 2) % 3] = 0.0
    return [(axis, first), *_alignment(rest, [])]


def _spin(orientation: Array, axis: int) -> tuple[int, float]:
    """Return a turn after which a column of the orientation has one zero more."""
    along = np.abs(orientation[axis])
    column = orientation[:, int(np.argmin(along))]
    across = [abs(column[k]) for k in range(3) if k != axis]
    return (axis, 0.0 if min(across) <= SNAP else _angle(column, axis))


def _angle(vector: Array, axis: int) -> float:
    """Return the angle of a vector's projection in the plane across an axis."""
    return atan2(vector[(axis + 2) % 3], vector[(axis + 1) % 3])
