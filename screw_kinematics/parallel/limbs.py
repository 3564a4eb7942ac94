# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The limbs of a parallel manipulator, traced together into straight-line programs."""
from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from .screw_system import LimbScrews
from ..chains.coupling import measured_as
from ..chains.serial_chain import SerialChain
from ..chains.tip_motion import tip_motion
from ..errors import InvalidValueError, UnknownNameError
from ..programs.machine import Machine, machine
from ..programs.tracing import Graph, straight_line
from ..screws.rigid import row_of_pose
from ..screws.se3 import Array
from ..screws.states import reduced_from_classical

LARGEST = 1e100
"""Length whose square is still a number [m]."""


class Limbs:
    """
    Open chains that share base and platform, and the joints they are made of.

    All joint vectors hold the actuated joints first, then the passive ones, limb by limb. The
    characteristic length [m] makes angles and lengths comparable; by default it is the mean
    distance of the limbs' last joints from the platform frame's origin.
    """

    def __init__(self, chains: Sequence[SerialChain], actuated: Sequence[str],
                 length: float | None = None) -> None:
        self.chains = tuple(chains)
        self.actuated = tuple(actuated)
        self._check()
        self.passive = tuple(
            name for chain in self.chains for name in chain.joint_names
            if name not in self.actuated)
        self.joint_names = self.actuated + self.passive
        self.names = tuple(chain.name for chain in self.chains)
        index = {name: k for k, name in enumerate(self.joint_names)}
        self.columns = [[index[name] for name in chain.joint_names] for chain in self.chains]
        own = [[name for name in chain.joint_names if name not in self.actuated]
               for chain in self.chains]
        self._slots = max(1, *map(len, own))
        # Where each passive joint stands in the array (limb, slot).
        self.slot_of = (np.repeat(np.arange(len(own)), [len(names) for names in own]),
                        np.concatenate([np.arange(len(names)) for names in own]))
        self.length = _length(self.chains) if length is None else length
        joints = [joint for chain in self.chains for joint in chain.joints]
        measured = [measured_as(joints, name) for name in self.joint_names]
        self.joint_kinds = tuple(kind for kind, _ in measured)
        self.velocity_limits = np.array([limit for _, limit in measured], float)
        # One unit of each joint by the characteristic length, to compare their steps.
        self.turning = np.array([kind != 'prismatic' for kind in self.joint_kinds])
        self.scale = np.where(self.turning, 1.0, 1 / self.length)
        followed = {joint.source for joint in joints if joint.mimic is not None}
        self.wraps = np.array([kind == 'continuous' and name not in followed
                               for name, kind in zip(self.actuated, self.joint_kinds)])
        self._programs: dict[int, Machine] = {}
        self._layout = self._kinematics_layout()

    def _check(self) -> None:
        if len(self.chains) < 2:
            raise InvalidValueError(
                f'a parallel manipulator has at least 2 limbs, got {len(self.chains)}')
        owner: dict[str, str] = {}
        for chain in self.chains:
            if [other.name for other in self.chains].count(chain.name) > 1:
                raise InvalidValueError(f'limb {chain.name!r} occurs more than once; '
                                        'limbs need different names')
            for name in chain.joint_names:
                if name not in self.actuated and owner.setdefault(name, chain.name) != chain.name:
                    raise InvalidValueError(
                        f'passive joint {name!r} is in the limbs {owner[name]!r} and '
                        f'{chain.name!r}; only actuated joints may be shared')
        if len(set(self.actuated)) != len(self.actuated):
            raise InvalidValueError(
                f'actuated joints must have different names, got {list(self.actuated)}')
        known = [name for chain in self.chains for name in chain.joint_names]
        for name in self.actuated:
            if name not in known:
                raise InvalidValueError(f'actuated joint {name!r} is in none of the limbs; '
                                        f'their joints: {", ".join(known)}')

    def positions(self, home: Mapping[str, float]) -> Array:
        """Return the positions of all joints [rad, m]; those that home does not name are at 0."""
        for name in home:
            if name not in self.joint_names:
                raise UnknownNameError('joint in the home posture:', name, self.joint_names)
        return np.array([float(home.get(name, 0.0)) for name in self.joint_names])

    def kinematics(self, values: Sequence[float]) -> tuple[Array, Array, LimbScrews]:
        """
        Return where each limb carries the platform, and its present screws.

        Rotations from platform to base coordinates, (limbs, 3, 3); positions of the platform frame
        in the base frame, (limbs, 3) [m]; and screws about each limb's own platform point, in base
        axes.
        """
        flat = np.array(self._program(0).evaluate(values), dtype=float)
        if not np.abs(flat).max() < LARGEST:
            raise InvalidValueError(
                f'the limbs reach further than {LARGEST:g} m {self.at(values)}')
        rotations, positions, passive, actuated = (flat[where] for where in self._layout)
        return rotations, positions, LimbScrews(passive, actuated)

    def bias(self, values: Sequence[float], order: int) -> Array:
        """
        Return the states of the limbs' tips without their joints' highest derivative.

        From the positions of all joints and their derivatives below an order of at least 2;
        reduced, of shape (limbs, 6), pole at the platform point, axes of the base.
        """
        return np.array(self._program(order).evaluate(values), dtype=float)[:-1].reshape(-1, 6)

    def difference(self, joints: Array, others: Array) -> Array:
        """Return joints - others, without whole turns."""
        away = joints - others
        return away - np.where(self.turning, 2 * np.pi * np.round(away / (2 * np.pi)), 0.0)

    def at(self, joints: Iterable[float]) -> str:
        """Return the positions of the actuated joints, for messages: ``at q1 0.5, q2 1``."""
        values = ', '.join(f'{name} {value:.6g}' for name, value in zip(self.actuated, joints))
        return f'at {values}'

    def points(self, joints: Array) -> list[Array]:
        """Return points to draw limbs through, (joints + 1, 3) each [m], the platform's last."""
        drawn = []
        for chain, columns in zip(self.chains, self.columns):
            posture = chain.posture(joints[columns])
            drawn.append(np.array([*posture.points, posture.pose[:3, 3]]))
        return drawn

    def _program(self, order: int) -> Machine:
        """Return the program for screws (order 0) or for the bias of an order."""
        if order not in self._programs:
            graph = Graph()
            n = len(self.joint_names)
            values = graph.inputs(n * max(1, order)).reshape(-1, n)
            outputs = [number for chain, columns in zip(self.chains, self.columns)
                       for number in _traced(chain, values[:, columns], order)]
            self._programs[order] = machine(straight_line(values.size, [*outputs, 0.0]))
        return self._programs[order]

    def _kinematics_layout(self) -> tuple[Array, ...]:
        """Return where the parts of :meth:`kinematics` stand in the program's output."""
        limbs, n = len(self.chains), len(self.joint_names)
        sizes = [12 + 6 * chain.dof for chain in self.chains]
        start = np.cumsum([0, *sizes])
        zero = int(start[-1])    # the constant after all limbs fills the places of absent joints
        columns = np.full((limbs, 6, n), zero)
        for k, chain in enumerate(self.chains):
            block = start[k] + 12 + np.arange(6 * chain.dof).reshape(6, -1)
            columns[k][:, self.columns[k]] = block
        passive = np.full((limbs, 6, self._slots), zero)
        for joint, (limb, slot) in enumerate(zip(*self.slot_of), start=len(self.actuated)):
            passive[limb, :, slot] = columns[limb, :, joint]
        return (start[:-1, None, None] + 3 + np.arange(9).reshape(3, 3),
                start[:-1, None] + np.arange(3), passive, columns[:, :, :len(self.actuated)])


def _length(chains: Sequence[SerialChain]) -> float:
    """Return the mean distance of the limbs' last turning joints from the platform."""
    distances = [
        np.linalg.norm(next(joint.point for joint in reversed(chain.joints)
                            if joint.kind != 'prismatic') - chain.T_base_tool[:3, 3])
        for chain in chains if any(joint.kind != 'prismatic' for joint in chain.joints)]
    mean = float(np.mean(distances)) if distances else 0.0
    return mean if mean > 0 else 1.0


def traced_bias(chain: SerialChain, values: Sequence[Array], order: int) -> Array:
    """
    Return one limb's bias, shape (6,), as expressions.

    Of traced joint positions and their derivatives below an order of at least 2.
    """
    return reduced_from_classical(tip_motion(chain, *values, np.zeros(chain.dof))[1])[order - 1]


def _traced(chain: SerialChain, values: Array, order: int) -> Iterable[Any]:
    """Return the numbers of one limb as expressions of its joint values."""
    if order > 0:
        return traced_bias(chain, list(values), order)
    pose = chain.pose(values[0])
    return [*row_of_pose(pose), *chain.jacobian(values[0]).ravel()]
