# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Which lines and couples the reciprocal wrenches of a limb are.

The wrenches that a limb puts on the platform are, for most limbs, lines through joints or
couples along their axes: the leg of a UPS limb, the second link of an RRR limb, a couple
across the axes of a parallelogram. Such forms are tried on several closed postures, and
those are taken that are reciprocal at all of them.
"""
from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ..chains.posture import Posture
from ..chains.serial_chain import SerialChain
from ..errors import InvalidValueError, ScrewKinematicsError
from ..parallel.closed_posture import ClosedPosture
from ..parallel.manipulator import ParallelManipulator
from ..screws.screw import unit_screw
from ..screws.se3 import Array, cross, klein_form

RECIPROCAL = 1e-8
"""Klein form with a unit screw, by the characteristic length, that counts as zero."""
POSTURES = 5
"""Closed postures at which wrenches are reciprocal if they always are."""
INDEPENDENT = 1e-4
"""Smallest singular value of wrenches that count as independent."""


class WrenchForm(NamedTuple):
    """
    A wrench by the joints of its limb.

    A 'line' (through the points of two joints), 'parallel' (through the point of the first, along
    the axis of the second), 'couple' (along an axis), 'across' (a couple across two axes), or
    'axis' (a couple along the base's axis ``first``). A constraint is held without any actuator.
    """

    kind: str
    first: int
    second: int = -1
    constraint: bool = False

    def directed(self, axes: Sequence[Array], points: Sequence[Array]) -> Array:
        """
        Return the direction, shape (3,), not of unit length for lines and across.

        From the direction of the axis of each joint of the limb, and a point on it [m].
        """
        if self.kind == 'line':
            return points[self.second] - points[self.first]
        if self.kind == 'across':
            return cross(axes[self.first], axes[self.second])
        if self.kind == 'axis':
            return np.eye(3, dtype=int)[self.first]
        return axes[self.second if self.kind == 'parallel' else self.first]

    @property
    def is_couple(self) -> bool:
        """Whether there is no force."""
        return self.kind in ('couple', 'across', 'axis')


def closed_postures(robot: ParallelManipulator) -> list[ClosedPosture]:
    """Return some postures about home, the same ones each time."""
    rng, found, size = np.random.default_rng(0), [], 0.1
    for _ in range(50 * POSTURES):
        try:
            found.append(robot.posture(robot.home.actuated + rng.uniform(-size, size, robot.dof)
                                       * robot.characteristic_length))
        except ScrewKinematicsError:
            size *= 0.9
        if len(found) == POSTURES:
            return found
    raise InvalidValueError(f'{robot.name}: there are hardly closed postures about home')


def wrench_forms(robot: ParallelManipulator, limb: SerialChain,
                 postures: Sequence[ClosedPosture]) -> list[WrenchForm]:
    """
    Return the forms of a limb's wrenches: those of the actuators, then constraints.

    They are reciprocal in all of the postures.

    Raises
    ------
    InvalidValueError
        Not all of its wrenches are of a known form.

    """
    index = robot.limbs.index(limb)
    passive, every, placed = [], [], []
    for posture in postures:
        q = _values(robot, limb, posture)
        columns = limb.jacobian(q).T.copy()
        columns[:, 3:] /= robot.characteristic_length
        is_passive = [name in robot.passive_joint_names for name in limb.joint_names]
        every.append(columns)
        passive.append(columns[is_passive])
        placed.append((limb.posture(q), posture.pose[:3, 3]))
    actuation, constraint = (len(w[index]) for w in robot.wrenches(postures[0]))
    chosen: list[WrenchForm] = []
    for columns_at, count, holds in ((every, constraint, True), (passive, actuation, False)):
        for form in _candidates(robot, limb):
            if len([c for c in chosen if c.constraint == holds]) == count:
                break
            form = form._replace(constraint=holds)
            rows = [[_scaled(f, at, pole, robot.characteristic_length)
                     for f in (*chosen, form)] for at, pole in placed]
            if all(np.all(np.isfinite(row)) and _independent(row)
                   and np.abs(klein_form(np.array(row[-1]), columns)).max() < RECIPROCAL
                   for row, columns in zip(rows, columns_at)):
                chosen.append(form)
    if len(chosen) < actuation + constraint:
        raise InvalidValueError(
            f'{robot.name}: the wrenches reciprocal to limb {limb.name!r} are not all lines '
            'through its joints or couples along its axes')
    return sorted(chosen, key=lambda form: form.constraint)


def _independent(rows: Sequence[Array]) -> bool:
    return bool(np.linalg.svd(np.array(rows), compute_uv=False)[-1] > INDEPENDENT)


def _candidates(robot: ParallelManipulator, limb: SerialChain) -> Iterator[WrenchForm]:
    """Give all forms, the plainest first."""
    turning = [i for i, joint in enumerate(limb.joints)
               if joint.kind != 'prismatic' and joint.source not in robot.joint_names]
    every = range(len(limb.joints))
    yield from (WrenchForm('line', i, j) for i, j in combinations(turning, 2))
    yield from (WrenchForm('axis', i) for i in range(3))
    yield from (WrenchForm('couple', i) for i in every)
    yield from (WrenchForm('across', i, j) for i, j in combinations(every, 2))
    yield from (WrenchForm('parallel', i, j) for i in turning[::-1] for j in every)


def constant_work(form: WrenchForm, robot: ParallelManipulator, limb: SerialChain, column: int,
                  postures: Sequence[ClosedPosture]) -> float | None:
    """Return a wrench's Klein form with the screw of a joint of the limb; None if it changes."""
    works = []
    for posture in postures:
        q = _values(robot, limb, posture)
        works.append(float(klein_form(
            _scaled(form, limb.posture(q), posture.pose[:3, 3], 1.0),
            limb.jacobian(q)[:, column])))
    return works[0] if np.ptp(works) < RECIPROCAL else None


def _values(robot: ParallelManipulator, limb: SerialChain, posture: ClosedPosture) -> Array:
    """Return the positions of a limb's measured joints."""
    values = dict(zip(robot.joint_names + robot.passive_joint_names, posture.joints))
    return np.array([values[name] for name in limb.joint_names])


def _scaled(form: WrenchForm, at: Posture, pole: Array, length: float) -> Array:
    """Return a form as a unit screw ``(force; moment)``, lengths by a characteristic one."""
    direction = np.asarray(form.directed(at.axes, at.points), dtype=float)
    size = np.linalg.norm(direction)
    if size < 1e-6:
        return np.full(6, np.nan)
    if form.is_couple:
        return np.concatenate([np.zeros(3), direction / size])
    line = unit_screw(direction / size, (at.points[form.first] - pole) / length)
    return np.asarray(line, dtype=float)
