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
from ..programs.tracing import Graph, straight_line, StraightLine
from ..screws.se3 import Array, skew

LARGEST_TURN = 0.05
"""Angle from a limb's tip to the platform up to which the pose is exact [rad]."""


class TracedStep(NamedTuple):
    """
    The program, and where its numbers are.

    It reads all joints, the derivatives of the actuated ones by order, and the memory of
    the last posture.

    Parameters
    ----------
    line : StraightLine
    slices : dict from str to slice
        Of the outputs: ``step`` of the passive joints; its squared ``size`` with the
        characteristic length; ``tests``, all squared: angle from limb 1's tip to the
        platform, change of the wrenches since the last posture, inverse distance to direct
        singularities, inverse distance of the limbs to theirs; ``margins``, negative for an
        actuator that may have passed an inverse singularity; squared ``misfit`` of each
        limb; ``memory``; ``pose``; reduced ``states`` by order; ``rates`` of the passive
        joints by order; ``jacobian``.

    """

    line: StraightLine
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
    """Return the wrenches and actuators between which there can be work, in pairs."""
    return [(row, column) for row, limb in enumerate(limb_of_row)
            for column in limbs.columns[limb] if column < len(limbs.actuated)]


def trace_step(limbs: Limbs, limb_of_row: Sequence[int], order: int | None = None,
               with_jacobian: bool = False) -> TracedStep:
    """
    Return the program of a manipulator.

    Parameters
    ----------
    limbs : Limbs
        All with passive screws that are independent in general posture.
    limb_of_row : sequence of int
        Limb of each wrench.
    order : int, optional
        Highest time derivative. Default: nothing but the step and its size.
    with_jacobian : bool
        Whether the Jacobian is wanted.

    """
    n, dof, m = len(limbs.joint_names), len(limbs.actuated), len(limb_of_row)
    places = work_places(limbs, limb_of_row)
    sizes = [n, (order or 0) * dof, 6 * m, len(places)]
    inputs = Graph().inputs(sum(sizes))
    joints, given, before, work_before = np.split(inputs, np.cumsum(sizes)[:-1])
    before = before.reshape(m, 6)
    system = _System(limbs, limb_of_row, joints, before)
    displacement, step = system.solve_platform([-error for error in system.errors])
    outputs: dict[str, list[Any]] = {
        'step': step, 'size': [_square(np.array(step, dtype=object) * limbs.scale[dof:])]}
    if order is not None:
        work = [system.wrenches[row] @ dict(system.limbs[limb_of_row[row]].actuated)[column]
                for row, column in places]
        mean = sum(system.errors) / len(system.errors)
        outputs |= {
            'tests': [_square(displacement[:3]), _square((system.wrenches - before).ravel()),
                      system.platform.inverse_square(),
                      sum(limb.passive.inverse_size_square() for limb in system.limbs)],
            'margins': [sum(then * (now - 0.5 * then) for (_, column), now, then
                            in zip(places, work, work_before) if column == j)
                        for j in range(dof)],
            'misfit': [_square(error - mean) for error in system.errors],
            'memory': [*system.wrenches.ravel(), *work],
            'pose': _moved(system.limbs[0].pose, displacement * system.unscale),
            **system.rates(joints, list(given.reshape(order, dof))),
            'jacobian': system.jacobian() if with_jacobian else []}
    ends = np.cumsum([0, *map(len, outputs.values())]).tolist()
    return TracedStep(straight_line(len(inputs), [x for part in outputs.values() for x in part]),
                      {name: slice(a, b) for name, a, b in zip(outputs, ends, ends[1:])})


class _System:
    """The equations of all limbs at a posture; lengths by the characteristic one."""

    def __init__(self, limbs: Limbs, limb_of_row: Sequence[int], joints: Array,
                 before: Array) -> None:
        self._chains, self._dof = limbs.chains, len(limbs.actuated)
        self.unscale = np.array([1.0] * 3 + [limbs.length] * 3)
        self.limbs = [_Limb(limbs, k, joints, before[np.equal(limb_of_row, k)], 1 / self.unscale)
                      for k in range(len(limbs.chains))]
        self.wrenches = np.array([w for limb in self.limbs for w in limb.wrenches], dtype=object)
        self.platform = OrthogonalColumns(self.wrenches.T)
        near = self.limbs[0].pose
        self.errors = [np.zeros(6, dtype=object), *(
            _displacement(limb.pose, near) / self.unscale for limb in self.limbs[1:])]

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
