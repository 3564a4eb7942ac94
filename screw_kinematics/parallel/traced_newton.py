# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""From the posture of one sample to that of the next, by traced Newton steps."""
from __future__ import annotations

from collections.abc import Sequence
import math
from operator import add, le, mul, sub
from typing import NamedTuple

from .closed_posture import ClosedPosture
from .limbs import Limbs
from .loop_closure import CONVERGED
from .screw_system import Ranks
from .traced_step import LARGEST_TURN, trace_first_step, trace_step, work_places
from ..programs.machine import machine

LONGEST = 0.1
"""Longest way of an actuated joint from sample to sample [rad, m by the length]."""
NEAR = 0.03
"""Longest first Newton step: beyond it another assembly mode may be as near."""
NEARLY = 1e-5
"""A Newton step after which the next one is likely the last."""
ITERATIONS = 5
MAX_STIFFNESS, MAX_LIMB_STIFFNESS = 1e6, 1e4
"""Squared inverse distances to singularities, of platform and limbs, up to which orthogonal
columns are accurate."""
APART = 0.25
"""Part of the squared distance to singularities that the wrenches may change by."""


class Moving(NamedTuple):
    """A posture, and how it moves: what the next one is foreseen from."""

    actuated: Sequence[float]    # their positions [rad, m]
    rates: Sequence[float]       # their derivatives by order
    carried: Sequence[float]     # passive joints, at least one derivative of them, and memory


class NextPosture(NamedTuple):
    """What was found near the last posture."""

    moving: Moving                     # what the one after it is foreseen from
    seen: Sequence[float]              # pose, states by order and, if wanted, Jacobian
    squared_misfit: Sequence[float]    # of each limb's loop
    iterations: int                    # Newton steps that were made


class NearbySteps:
    """
    Postures and rates close to the last ones.

    The limbs' passive screws are independent in general posture, in which they have the ranks.
    """

    def __init__(self, limbs: Limbs, ranks: Ranks, order: int, with_jacobian: bool,
                 closed: float) -> None:
        rows = ranks.limb_of_row.tolist()
        self._places = tuple(zip(*work_places(limbs, rows)))
        self._dof, self._order = len(limbs.actuated), order
        self._n_passive = len(limbs.joint_names) - self._dof
        # The passive joints' speeds of order 0 are their way in the time of one sample.
        self._still = [0.0] * (max(order, 1) * self._n_passive)
        self._largest_misfit = closed * closed
        self._wraps = [int(k) for k in limbs.wraps.nonzero()[0]]
        self._longest = (LONGEST / limbs.scale[:self._dof]).tolist()
        # All but the step takes as long as the step, which does not need it.
        first = trace_first_step(limbs, rows, max(order, 1))
        whole = trace_step(limbs, rows, order, with_jacobian)
        self.operations = len(first.operations) + len(whole.line.operations)
        self._first = machine(first)
        self._whole, at = machine(whole.line), whole.slices
        self._tests, self._margins, self._misfit = at['tests'], at['margins'], at['misfit']
        self._seen = slice(at['pose'].start, at['jacobian'].stop)
        self._passive, self._memory = at['passive'], at['memory']
        self._carried = slice(at['passive'].start, at['memory'].stop)

    def moving(self, posture: ClosedPosture, rates: Sequence[float] = (),
               passive_rates: Sequence[float] = ()) -> Moving:
        """
        Return what the next posture is found with, of one that was found otherwise.

        Derivatives of the actuated and the passive joints are by order; there are none if it
        rests.
        """
        return Moving(posture.actuated.tolist(), rates, [
            *posture.passive.tolist(), *(passive_rates or self._still),
            *posture.system.rows.ravel().tolist(),
            *posture.system.work[self._places].tolist()])

    def find(self, before: Moving, values: Sequence[float]) -> NextPosture | None:
        """
        Return the next posture and its rates; None if it is not certainly the next one.

        From positions, velocities, ... of the actuated joints up to the order.
        """
        way = [*map(sub, values, before.actuated)]
        for k in self._wraps:
            if abs(way[k]) < 1e9:
                way[k] -= 2 * math.pi * round(way[k] / (2 * math.pi))
        if not all(map(le, map(abs, way), self._longest)):
            return None
        actuated, given = [*map(add, before.actuated, way)], values[self._dof:]
        memory = before.carried[len(before.carried) - self._memory.stop + self._memory.start:]
        size, *passive = self._first.evaluate(
            [*actuated, *_duration(before, way), *before.carried])
        limit = NEAR * NEAR
        for iteration in range(2, ITERATIONS + 1):
            if not size <= limit:
                return None
            limit = max(size / 4, CONVERGED * CONVERGED)
            if size > NEARLY * NEARLY:
                size, *passive = self._first.evaluate(
                    [*actuated, 0.0, 0.0, *passive, *self._still, *memory])
                continue
            out = self._whole.evaluate([*actuated, *given, *passive, *memory])
            size, passive = out[0], list(out[self._passive])
            if size <= CONVERGED * CONVERGED:
                break
        else:
            return None
        turn, change, stiffness, limp = out[self._tests]
        misfit = out[self._misfit]
        if not (turn <= LARGEST_TURN**2 and change * stiffness <= APART
                and limp <= MAX_LIMB_STIFFNESS and stiffness <= MAX_STIFFNESS
                and min(out[self._margins]) >= 0 and max(misfit) <= self._largest_misfit):
            return None
        carried: Sequence[float] = out[self._carried]
        if not self._order:     # the way itself, in the time of one sample
            given = way
            carried = [*passive, *map(sub, passive, before.carried), *out[self._memory]]
        return NextPosture(Moving(actuated, given, carried), out[self._seen], misfit, iteration)


def _duration(before: Moving, way: Sequence[float]) -> tuple[float, float]:
    """Return the time in which the actuated joints go their way, and half its square."""
    speed, slope = before.rates[:len(way)], before.rates[len(way):2 * len(way)]
    square = sum(map(mul, speed, speed))
    if not square > 0:
        return 0.0, 0.0
    time = sum(map(mul, way, speed)) / square
    late = time * time / 2 * sum(map(mul, slope, speed)) / square
    # At low speed the time is not known well: a correction must be a small one.
    if not slope or abs(late) > abs(time) / 4:
        return time, 0.0
    time -= late
    return time, time * time / 2
