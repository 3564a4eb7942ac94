# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
A robot on a moving base: its motion relative to the world, by the law of composition.

The base's motion is twelve numbers of its pose in the world (position [m], rotation by rows), and
its twist in its own axes about its own origin with three derivatives of these components, six
numbers each.
"""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from math import factorial
from typing import Any

import numpy as np

from .machine import Machine, machine
from .quantities import checked_outputs, find_quantity, order_of, WITHOUT_SCREWS
from .tracing import Graph, straight_line
from ..screws.body_components import states_from_body_derivatives
from ..screws.body_state import BodyState
from ..screws.rigid import pose_from_row, row_of_pose
from ..screws.se3 import Array, lie_product, matvec, rotate, shift_pole
from ..screws.states import compose
from ..screws.vectors import skew

BASE_INPUTS = 12 + 4 * 6
"""Numbers that tell the motion of a base."""

AT_REST = (*[0.0] * 3, *np.eye(3).ravel().tolist(), *[0.0] * 24)
"""The motion of a base that stands at the origin of the world."""

PASSED = ('passive_position', 'passive_velocity')
"""What no motion of the base changes."""

_REDUCED = ('twist', 'reduced_accel', 'reduced_jerk', 'reduced_snap')
_SERIES = 9


class MovingBaseProgram:
    """
    The program of a robot whose base moves.

    What it computes is relative to the world: 'base' axes and pole are the world's axes and
    origin. The Jacobian has six more columns behind those of the joints, of the base's twist.

    References
    ----------
    The paper, section 2.4.2.

    """

    def __init__(self, model: Any, outputs: Iterable[str], axes: str = 'base',
                 pole: str = 'tip') -> None:
        outputs = checked_outputs(outputs, axes, pole, WITHOUT_SCREWS)
        passed = tuple(name for name in outputs if name in PASSED)
        self.order = order_of(outputs)
        self._states = _REDUCED[:self.order]
        jacobian = ('jacobian',) if 'jacobian' in outputs else ()
        self._inner = model.compile(('pose', *self._states, *jacobian, *passed))
        self.dof = self._inner.dof
        self._joint_inputs = self._inner.inputs
        values: list[Any] = []
        self.slices: dict[str, slice] = {}
        graph = Graph().inputs(self._inner_size + BASE_INPUTS)
        for name in outputs:
            own = self._trace(graph, name, axes, pole)
            self.slices[name] = slice(len(values), len(values) + len(own))
            values += own
        self._outputs = len(values)
        self._machine: Machine = machine(straight_line(len(graph), values))

    def evaluate(self, values: Sequence[float]) -> Sequence[float]:
        """
        Return the outputs of one sample, one after the other as ``slices`` say.

        From positions, velocities, ... of the joints up to ``order``, then the base's motion.
        """
        n = self._joint_inputs
        return self._machine.evaluate((*self._inner.evaluate(values[:n]), *values[n:]))

    def batch(self, *motion: Array, base: Array) -> dict[str, Array]:
        """Return the outputs of many samples, as :meth:`Program.batch`; base: (N, BASE_INPUTS)."""
        inner = np.empty((len(base), self._inner_size))
        self._inner.batch(*motion, out=inner)
        out = np.empty((len(base), self._outputs))
        self._machine.batch([inner, np.ascontiguousarray(base, dtype=float)], out, 2)
        return {name: out[:, part] for name, part in self.slices.items()}

    def continue_from(self, before: Any) -> None:
        """Go on where the program before was, if samples depend on each other."""
        self._inner.continue_from(getattr(before, '_inner', before))

    def report(self) -> dict[str, Any]:
        """Return how the last posture is, if the program knows; empty of an open chain."""
        return dict(getattr(self._inner, 'report', dict)())

    @property
    def _inner_size(self) -> int:
        return max(part.stop for part in self._inner.slices.values())

    def _trace(self, graph: Array, name: str, axes: str, pole: str) -> list[Any]:
        """Return an output, from the robot's motion relative to the base, and the base's."""
        size = self._inner_size
        part = {key: graph[place] for key, place in self._inner.slices.items()}
        if name in PASSED:
            return [*part[name]]
        base, components = pose_from_row(graph[size:size + 12]), list(
            graph[size + 12:].reshape(4, 6))
        arm = pose_from_row(part['pose'])
        tip = arm[:3, 3]
        pose = base @ arm
        if name == 'pose':
            return [*row_of_pose(pose)]
        # All in axes of the base and about the tip, until they are known.
        to_axes = base[:3, :3] if axes == 'base' else arm[:3, :3].T
        to_pole = np.zeros(3) if pole == 'tip' else -matvec(base[:3, :3].T, pose[:3, 3])
        if name == 'jacobian':
            of_joints = part[name].reshape(6, -1).T
            of_base = shift_pole(np.eye(6).astype(object), tip)
            columns = np.concatenate([of_joints, of_base])
            return [*rotate(to_axes, shift_pole(columns, to_pole)).T.ravel()]
        carrier = [shift_pole(x, tip)
                   for x in states_from_body_derivatives(components[:self.order])]
        seen = [rotate(to_axes, shift_pole(x, to_pole))
                for x in compose(carrier, [part[state] for state in self._states])]
        point = pose[:3, 3] if pole == 'tip' else np.zeros(3)
        return [*find_quantity(name).of(BodyState(pose, tuple(seen), point, pole, axes))]


def carry(values: Sequence[float]) -> Sequence[float]:
    """
    Return the motion of a base at another instant, by its own derivatives.

    Pose and twist, with its derivatives, are of an instant of their own each; behind them are the
    times from these to the other one [s].

    Examples
    --------
    >>> half_turn = carry([*AT_REST[:14], 3.0, *AT_REST[15:], 1.0, 0.0])
    >>> [round(x, 6) for x in half_turn[3:5]]
    [-0.989992, -0.14112]

    """
    return _carrier().evaluate(values)


def carry_batch(values: Array) -> Array:
    """Return the motion of a base at many instants, as :func:`carry`, a row each."""
    out = np.empty((len(values), BASE_INPUTS))
    _carrier().batch([np.ascontiguousarray(values, dtype=float)], out, 2)
    return out


@cache
def _carrier() -> Machine:
    graph = Graph().inputs(BASE_INPUTS + 2)
    since_pose, since_twist = graph[-2:]
    known = graph[12:BASE_INPUTS].reshape(4, 6)
    components = [sum(known[n + k] * (since_twist**k / factorial(k)) for k in range(1, 4 - n))
                  + known[n] for n in range(4)]
    # The way back to the instant of the pose, in the axes of then; Magnus' second term.
    h = since_pose
    way = components[0] * h - components[1] * (h**2 / 2) + components[2] * (h**3 / 6) \
        - components[3] * (h**4 / 24) + lie_product(components[0], components[1]) * (h**3 / 12)
    pose = pose_from_row(graph[:12]) @ _displacement(way)
    return machine(straight_line(len(graph), [
        *row_of_pose(pose), *(x for y in components for x in y)]))


def _displacement(way: Array) -> Array:
    """Return the exponential of a six-vector, by its series: without a branch at rest."""
    W, W2 = skew(way[:3]), skew(way[:3]) @ skew(way[:3])    # noqa: N806
    square = way[0]**2 + way[1]**2 + way[2]**2
    sine, cosine, third = (
        sum((-1)**k / factorial(2 * k + first) * square**k for k in range(1, _SERIES))
        + 1 / factorial(first) for first in (1, 2, 3))
    T = np.zeros((4, 4), dtype=object)    # noqa: N806
    T[:3, :3] = np.eye(3).astype(object) + W * sine + W2 * cosine
    T[:3, 3] = way[3:] + matvec(W * cosine + W2 * third, way[3:])
    T[3, 3] = 1
    return T
