# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
One Newton step and all rates of a parallel manipulator, as a straight-line program.

The mathematics is that of :mod:`.loop_closure`, :mod:`.screw_system` and :mod:`.rates`, for
postures near the last one: reciprocal wrenches are carried along from there instead of
being looked for, so nothing needs a branch, and the limbs, the elimination of their passive
joints and the platform's equations are traced together.
"""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from .gram_schmidt import OrthogonalColumns
from .limbs import Limbs, traced_bias
from ..programs.tracing import Graph, straight_line, StraightLineProgram
from ..screws.se3 import Array, skew

LARGEST_TURN = 0.05
"""Angle from a limb's tip to the platform up to which the pose is exact [rad]."""


class TracedStep(NamedTuple):
    """
    The program of :func:`trace_step`, and where its outputs are.

    It reads the actuated joints, their derivatives by order, the passive joints, and the memory of
    the last posture. It yields the squared ``size`` of the step with the characteristic length;
    ``tests``, all squared: angle from limb 1's tip to the platform, change of the wrenches since
    the last posture, inverse distance to direct singularities, inverse distance of the limbs to
    theirs; ``margins``, negative for an actuator that may have passed an inverse singularity;
    squared ``misfit`` of each limb; ``pose``; reduced ``states`` by order; ``jacobian``;
    ``passive`` joints after the step; their ``rates`` by order; ``memory``.
    """

    line: StraightLineProgram
    slices: dict[str, slice]


class _Limb:
    """What is known of one limb: tip, screws, and wrenches near those before."""

    def __init__(self, limbs: Limbs, index: int, joints: Array, seeds: Array,
                 scale: Array) -> None:
        chain, self.columns = limbs.chains[index], limbs.columns[index]
        self.pose = chain.pose(joints[self.columns])
        screws = [s * scale for s in chain.jacobian(joints[self.columns]).T]
        n = len(limbs.actuated)
        self.actuated = [(c, s) for c, s in zip(self.columns, screws) if c < n]
        self.passive = OrthogonalColumns([s for c, s in zip(self.columns, screws) if c >= n])
        self.wrenches = self.passive.complement(seeds)

    def actuated_motion(self, actuated: Array) -> Array:
        """Return the tip's motion with the passive joints at rest, scaled."""
        return sum((actuated[c] * s for c, s in self.actuated), np.zeros(6, dtype=object))


def work_places(limbs: Limbs, limb_of_row: Sequence[int]) -> list[tuple[int, int]]:
    """Return the rows and columns, wrenches and actuators, between which there can be work."""
    return [(row, column) for row, limb in enumerate(limb_of_row)
            for column in limbs.columns[limb] if column < len(limbs.actuated)]


def trace_first_step(limbs: Limbs, limb_of_row: Sequence[int], orders: int) -> StraightLineProgram:
    """
    Return the program that foresees a posture and makes one step from there.

    It reads the actuated joints; the time since the last posture and half its square; passive
    joints, their derivatives to some order, at least the first, and memory of the last posture. It
    yields the squared size of the step, and the passive joints after it.
    """
    dof = len(limbs.actuated)
    n = len(limbs.joint_names) - dof
    sizes = [dof, 2, n, orders * n, _memory(limbs, limb_of_row)]
    inputs = Graph().inputs(sum(sizes))
    actuated, (time, half), passive, rates, memory = np.split(inputs, np.cumsum(sizes)[:-1])
    passive = passive + time * rates[:n]
    if orders > 1:
        passive = passive + half * rates[n:2 * n]
    system = _System(limbs, limb_of_row, np.concatenate([actuated, passive]), memory)
    _, step = system.newton_step()
    return straight_line(len(inputs), [system.size(step), *(passive + step)])


def trace_step(limbs: Limbs, limb_of_row: Sequence[int], order: int,
               with_jacobian: bool) -> TracedStep:
    """
    Return the program of a step, and of all that is known after it.

    All limbs have passive screws that are independent in general posture.
    """
    dof = len(limbs.actuated)
    places = work_places(limbs, limb_of_row)
    sizes = [dof, order * dof, len(limbs.joint_names) - dof, _memory(limbs, limb_of_row)]
    inputs = Graph().inputs(sum(sizes))
    actuated, given, passive, memory = np.split(inputs, np.cumsum(sizes)[:-1])
    joints = np.concatenate([actuated, passive])
    system = _System(limbs, limb_of_row, joints, memory)
    displacement, step = system.newton_step()
    work = [system.wrenches[row] @ dict(system.limbs[limb_of_row[row]].actuated)[column]
            for row, column in places]
    work_before = memory[memory.size - len(places):]
    mean = sum(system.errors) / len(system.errors)
    motion = system.rates(joints, list(given.reshape(order, dof)))
    outputs: dict[str, list[Any]] = {
        'size': [system.size(step)],
        'tests': [_square(displacement[:3]),
                  _square((system.wrenches - system.wrenches_before).ravel()),
                  system.platform.inverse_square(),
                  sum(limb.passive.inverse_size_square() for limb in system.limbs)],
        'margins': [sum(then * (now - 0.5 * then) for (_, column), now, then
                        in zip(places, work, work_before) if column == j)
                    for j in range(dof)],
        'misfit': [_square(error - mean) for error in system.errors],
        'pose': _moved(system.limbs[0].pose, displacement * system.unscale),
        'states': motion['states'],
        'jacobian': system.jacobian() if with_jacobian else [],
        'passive': [*(passive + step)],
        'rates': motion['rates'],
        'memory': [*system.wrenches.ravel(), *work]}
    ends = np.cumsum([0, *map(len, outputs.values())]).tolist()
    return TracedStep(straight_line(len(inputs), [x for part in outputs.values() for x in part]),
                      {name: slice(a, b) for name, a, b in zip(outputs, ends, ends[1:])})


def _memory(limbs: Limbs, limb_of_row: Sequence[int]) -> int:
    """Return how many numbers the memory has: wrenches, and the work of actuators on them."""
    return 6 * len(limb_of_row) + len(work_places(limbs, limb_of_row))


class _System:
    """The equations of all limbs at a posture; lengths by the characteristic one."""

    def __init__(self, limbs: Limbs, limb_of_row: Sequence[int], joints: Array,
                 memory: Array) -> None:
        self._chains, self._dof = limbs.chains, len(limbs.actuated)
        self._scale = limbs.scale[self._dof:]
        self.wrenches_before = before = memory[:6 * len(limb_of_row)].reshape(-1, 6)
        self.unscale = np.array([1.0] * 3 + [limbs.length] * 3)
        self.limbs = [_Limb(limbs, k, joints, before[np.equal(limb_of_row, k)], 1 / self.unscale)
                      for k in range(len(limbs.chains))]
        self.wrenches = np.array([w for limb in self.limbs for w in limb.wrenches], dtype=object)
        self.platform = OrthogonalColumns(self.wrenches.T)
        near = self.limbs[0].pose
        self.errors = [np.zeros(6, dtype=object), *(
            _displacement(limb.pose, near) / self.unscale for limb in self.limbs[1:])]

    def newton_step(self) -> tuple[Array, Array]:
        """Return the platform's displacement from limb 1's tip, scaled, and the passive step."""
        displacement, step = self.solve_platform([-error for error in self.errors])
        return displacement, np.array(step, dtype=object)

    def size(self, step: Array) -> Any:
        """Return the squared size of a step, lengths by the characteristic one."""
        return _square(step * self._scale)

    def solve_platform(self, tips: Sequence[Array]) -> tuple[Array, list[Any]]:
        """Return the platform's state, scaled, and the passive joints' rates."""
        onto = [w @ tip for limb, tip in zip(self.limbs, tips) for w in limb.wrenches]
        state = np.array(self.platform.solve(np.array(onto, dtype=object)), dtype=object)
        return state, [rate for limb, tip in zip(self.limbs, tips)
                       for rate in limb.passive.solve_roughly(state - tip)]

    def rates(self, joints: Array, derivatives: Sequence[Array]) -> dict[str, list[Any]]:
        """Return the platform's states and the passive joints' rates, by order."""
        out: dict[str, list[Any]] = {'states': [], 'rates': []}
        values = [joints]
        for k, derivative in enumerate(derivatives, start=1):
            tips = [limb.actuated_motion(derivative) for limb in self.limbs]
            if k > 1:
                tips = [tip + traced_bias(chain, [v[limb.columns] for v in values], k)
                        / self.unscale
                        for tip, limb, chain in zip(tips, self.limbs, self._chains)]
            state, rates = self.solve_platform(tips)
            out['states'] += [*(state * self.unscale)]
            out['rates'] += rates
            values.append(np.array([*derivative, *rates], dtype=object))
        return out

    def jacobian(self) -> list[Any]:
        """Return the platform's twist by actuated rates, row by row."""
        columns = [
            self.solve_platform([limb.actuated_motion(unit) for limb in self.limbs])[0]
            * self.unscale for unit in np.eye(self._dof)]
        return [*np.transpose(columns).ravel()]


def _square(vector: Any) -> Any:
    """Return the squared norm."""
    return sum(x * x for x in vector)


def _displacement(pose: Array, goal: Array) -> Array:
    """Return the motion from one pose to another nearby; see :mod:`.loop_closure`."""
    turn = goal[:3, :3] @ pose[:3, :3].T
    axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return np.concatenate([axis * (2.0 / (1.0 + np.trace(turn))), goal[:3, 3] - pose[:3, 3]])


def _moved(pose: Array, displacement: Array) -> list[Any]:
    """Return position and rotation, by rows, after a small turn about the own origin."""
    square = _square(displacement[:3])
    # Of sin(x) / x and (1 - cos x) / x^2 up to LARGEST_TURN.
    sine = 1 - square / 6 * (1 - square / 20 * (1 - square / 42 * (1 - square / 72)))
    versine = 0.5 * (1 - square / 12 * (1 - square / 30 * (1 - square / 56)))
    about = skew(displacement[:3])
    rotation = pose[:3, :3] + (sine * about + versine * (about @ about)) @ pose[:3, :3]
    return [*(pose[:3, 3] + displacement[3:]), *rotation.ravel()]
