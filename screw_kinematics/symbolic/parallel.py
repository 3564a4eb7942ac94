# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Equations of velocity, acceleration and jerk of a parallel manipulator as formulas.

Each limb is written with exact geometry at a general posture. A joint beyond which only
the platform's pose matters is placed from the platform, as ``p + R b``; others from the
base. So the wrench of a leg reads as the unit line between its ends, and

    {W; V} = {W; $} q'      {W; A} = {W; $} q'' + {W; L}      {W; J} = {W; $} q''' + {W; K}

are the equations of the literature, with L the sum of ``[$_i, $_j] q_i' q_j'``, i < j, and K
what positions, rates and accelerations of all joints of a limb contribute to its jerk.
Needs the extra ``symbolic``.
"""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy

from .exact import exact_chain, exact_decimal, NEAR, sympy_array
from .expressions import joint_symbols
from .wrench_forms import closed_postures, constant_work, wrench_forms, WrenchForm
from ..chains.joint import Joint
from ..chains.posture import Posture
from ..chains.serial_chain import SerialChain
from ..parallel.closed_posture import ClosedPosture
from ..parallel.manipulator import ParallelManipulator
from ..screws.screw import prismatic_screw, unit_screw
from ..screws.se3 import Array, cross, klein_form
from ..screws.states import chain_states

ORDER = 3
"""Highest order of the equations: the jerk."""
MOVES = 1e-9
"""Largest component of a state that counts as always zero."""


@dataclass(frozen=True, eq=False)
class Wrench:
    """A wrench of a limb in symbols."""

    meaning: str            # in words, by the names of joints
    constraint: bool        # whether it is reciprocal to all joints, not only to the passive ones
    unit: Array             # (3,), symbols of its direction, or the direction itself
    along: Array | None     # (3,), what ``unit`` is along, where that is of symbols
    screw: Array            # (6,), ``(force; moment)`` about the platform point
    work: dict[int, Any]    # Klein form with the screw of each actuated joint, by its place in q


@dataclass(frozen=True, eq=False)
class LimbFormulas:
    """A limb in symbols."""

    name: str
    joints: list[str]         # from base to platform
    screws: list[Array]       # of these joints about the platform point, (6,) each
    rates: list[list[Any]]    # velocities of these joints, then their accelerations
    wrenches: list[Wrench]    # those held by actuators first

    def bias(self, order: int) -> Array:
        """
        Return the platform's reduced state at zero derivatives of an order of the joints.

        L for order 2, K for order 3; about the platform point, in base axes.
        """
        zero = sympy_array([0] * len(self.joints))
        return chain_states(self.screws, [*self.rates[:order - 1], zero])[-1]


class ParallelFormulas:
    """
    The equations of a manipulator whose wrenches are lines through joints or couples along axes.

    ``q`` and ``theta`` are symbols of the actuated and of the passive joints: positions, rates,
    ...; of the actuated ones to the order of the jerk, of the passive ones one less. The position
    of the platform is of numbers where it does not change; its rotation of 9 symbols, in a plane
    of the angle ``phi``, constant where nothing turns. ``moving`` are the components of twist,
    reduced acceleration and reduced jerk that are not always zero.
    """

    def __init__(self, robot: ParallelManipulator, tolerance: float = NEAR) -> None:
        self.robot, self._tolerance = robot, tolerance
        self.q = joint_symbols(robot.dof, ORDER)
        self.theta = [sympy_array([
            sympy.Symbol(f'theta{"d" * k}{i + 1}', real=True)
            for i in range(len(robot.passive_joint_names))]) for k in range(ORDER)]
        postures = closed_postures(robot)
        rates = np.random.default_rng(0).normal(size=(len(postures), ORDER, robot.dof))
        states = np.array([robot.rates(posture, *rate)[0]
                           for posture, rate in zip(postures, rates)])
        self.moving = [[k for k in range(6) if np.abs(states[:, n, k]).max() > MOVES]
                       for n in range(ORDER)]
        self.position, self.rotation = self._pose(robot.home.pose)
        self._count = 0
        self.limbs = [self._limb(limb, postures) for limb in robot.limbs]

    def _pose(self, home: Array) -> tuple[Array, Array]:
        names = [sympy.Symbol(f'p_{axis}', real=True) for axis in 'xyz']
        position = sympy_array([names[k] if 3 + k in self.moving[0] else self._length(home[k, 3])
                                for k in range(3)])
        turning = [k for k in self.moving[0] if k < 3]
        upright = np.allclose(home[:3, :3], np.eye(3), atol=1e-12)
        if upright and not turning:
            return position, sympy_array(np.eye(3, dtype=int))
        if upright and turning == [2]:
            phi = sympy.Symbol('phi', real=True)
            return position, sympy_array([[sympy.cos(phi), -sympy.sin(phi), 0],
                                          [sympy.sin(phi), sympy.cos(phi), 0], [0, 0, 1]])
        return position, sympy_array([[sympy.Symbol(f'r{i}{j}', real=True) for j in (1, 2, 3)]
                                      for i in (1, 2, 3)])

    def _length(self, x: Any) -> Any:
        return exact_decimal(x, self._tolerance)

    def _symbols(self, limb: SerialChain, order: int) -> Array:
        known = dict(zip(self.robot.joint_names + self.robot.passive_joint_names,
                         [*self.q[order], *self.theta[order]]))
        return sympy_array([known[name] for name in limb.joint_names])

    def _placed(self, limb: SerialChain) -> tuple[list[Array], list[Array]]:
        """Return axes and points less the platform's position, from base or platform."""
        exact = exact_chain(limb, self._tolerance)
        values = exact.joint_values(self._symbols(limb, 0))
        base = exact.posture(self._symbols(limb, 0))
        home = np.asarray(limb.T_base_tool, dtype=float)
        back = exact_chain(SerialChain([
            Joint(j.name, 'revolute' if j.kind == 'continuous' else j.kind,
                  home[:3, :3].T @ j.axis, home[:3, :3].T @ (j.point - home[:3, 3]),
                  j.pitch) for j in limb.joints[::-1]]), self._tolerance)
        platform = Posture(back.joints, back.T_base_tool, -values[::-1])
        axes, points = [], []
        for k in range(len(limb.joints)):
            there = self.rotation @ platform.axes[-1 - k], self.rotation @ platform.points[-1 - k]
            here = base.axes[k], base.points[k] - self.position
            axes.append(self._plainer(here[0], there[0]))
            points.append(self._plainer(here[1], there[1]))
        return axes, points

    def _plainer(self, here: Array, there: Array) -> Array:
        """Return the one of two expressions that a reader is better served with."""
        passive = set(self.theta[0])

        def cost(vector: Array) -> tuple[int, int]:
            symbols = set().union(*(x.free_symbols for x in vector))
            return len(symbols & passive), sum(sympy.count_ops(x) for x in vector)

        return here if cost(here) <= cost(there) else there

    def _limb(self, limb: SerialChain, postures: Sequence[ClosedPosture]) -> LimbFormulas:
        forms = wrench_forms(self.robot, limb, postures)    # or none is known: told at once
        axes, points = ([sympy_array(x) for x in part] for part in self._placed(limb))
        screws = [sympy_array(prismatic_screw(axis) if joint.kind == 'prismatic'
                              else unit_screw(axis, point, self._length(joint.pitch)))
                  for joint, axis, point in zip(limb.joints, axes, points)]
        rates = [list(exact_chain(limb, self._tolerance).joint_values(self._symbols(limb, n), n))
                 for n in range(1, ORDER)]
        wrenches = [self._wrench(limb, form, axes, points, screws, postures)
                    for form in forms]
        return LimbFormulas(limb.name, [joint.name for joint in limb.joints], screws, rates,
                            wrenches)

    def _wrench(self, limb: SerialChain, form: WrenchForm, axes: Sequence[Array],
                points: Sequence[Array], screws: Sequence[Array],
                postures: Sequence[ClosedPosture]) -> Wrench:
        unit, along = sympy_array(form.directed(axes, points)), None
        if form.kind in ('line', 'across'):
            self._count += 1
            along, unit = unit, sympy_array([
                sympy.Symbol(f'f{self._count}_{axis}', real=True) if x != 0 else 0
                for axis, x in zip('xyz', unit)])
        if form.is_couple:
            ends = [sympy_array([0, 0, 0, *unit])]
        else:
            last = form.second if form.kind == 'line' else form.first
            ends = [sympy_array([*unit, *cross(points[k], unit)]) for k in (last, form.first)]
        work: dict[int, Any] = {}
        for column, name in enumerate(limb.joint_names):
            if name in self.robot.joint_names and not form.constraint:
                constant = constant_work(form, self.robot, limb, column, postures)
                # By the end of the line that makes it plainer.
                work[self.robot.joint_names.index(name)] = self._length(constant) \
                    if constant is not None else min(
                        (self._work(limb, name, end, screws) for end in ends),
                        key=lambda x: (len(x.free_symbols & set(self.position)),
                                       sympy.count_ops(x)))
        names = [joint.name for joint in limb.joints]
        first, second = names[form.first % len(names)], names[form.second]
        meaning = {'line': f'force on the line from {first} to {second}',
                   'parallel': f'force through {first} along the axis of {second}',
                   'couple': f'couple along the axis of {first}',
                   'across': f'couple across the axes of {first} and {second}',
                   'axis': f'couple along {"xyz"[form.first % 3]}'}[form.kind]
        return Wrench(meaning, form.constraint, unit, along, ends[0], work)

    @staticmethod
    def _work(limb: SerialChain, name: str, wrench: Array, screws: Sequence[Array]) -> Any:
        """Return the Klein form with all joints of the limb that move with a measured one."""
        total = sympy.Integer(0)
        for joint, screw in zip(limb.joints, screws):
            if joint.source == name:
                factor = 1 if joint.mimic is None else exact_decimal(joint.mimic.multiplier)
                total += factor * klein_form(wrench, screw)
        forces = sorted((s for s in total.free_symbols if s.name[0] == 'f'), key=str)
        return sympy.collect(sympy.expand(total), forces)
