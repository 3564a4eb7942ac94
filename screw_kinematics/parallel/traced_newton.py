# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""From the posture of one sample to that of the next, by traced Newton steps."""
from __future__ import annotations

from collections.abc import Sequence
import math
from typing import NamedTuple

from .closed_posture import ClosedPosture
from .limbs import Limbs
from .loop_closure import CONVERGED
from .screw_system import Ranks
from .traced_step import LARGEST_TURN, trace_step, TracedStep, work_places
from ..programs.machine import machine

LONGEST = 0.1
"""Longest way of an actuated joint from sample to sample [rad, m by the length]."""
NEAR = 0.03
"""Longest first Newton step: beyond it another assembly mode may be as near."""
NEARLY = 1e-5
"""A Newton step after which the next one is likely the last."""
ITERATIONS = 5
STIFFEST, LIMP = 1e6, 1e4
"""Squared inverse distances to singularities, of platform and limbs, up to which orthogonal
columns are accurate."""
APART = 0.25
"""Part of the squared distance to singularities that the wrenches may change by."""


class Moving(NamedTuple):
    """A posture, and how it moves: what the next one is predicted from."""

    joints: Sequence[float]
    memory: Sequence[float]
    actuated_rates: Sequence[float]     # by order
    passive_rates: Sequence[float]      # by order


class Found(NamedTuple):
    """The next posture, with all that is asked for, flat."""

    moving: Moving
    pose: Sequence[float]
    states: Sequence[float]
    jacobian: Sequence[float]
    squared_misfit: Sequence[float]
    iterations: int


class NearbySteps:
    """
    Postures and rates close to the last ones.

    Parameters
    ----------
    limbs : Limbs
        With passive screws that are independent in general posture.
    ranks : Ranks
        Of them.
    order : int
        Highest time derivative.
    with_jacobian : bool
    closed : float
        Largest misfit of a closed loop.

    """

    def __init__(self, limbs: Limbs, ranks: Ranks, order: int, with_jacobian: bool,
                 closed: float) -> None:
        rows = ranks.limb_of_row.tolist()
        self._places = tuple(zip(*work_places(limbs, rows)))
        self._dof, self._order = len(limbs.actuated), order
        self._largest_misfit = closed * closed
        self._wraps = [int(k) for k in limbs.wraps.nonzero()[0]]
        self._scale = limbs.scale[:self._dof].tolist()
        self._whole = _Runner(trace_step(limbs, rows, order, with_jacobian))
        # All the rest takes as long as the step, which does not need it.
        self._first = _Runner(trace_step(limbs, rows))

    def memory(self, posture: ClosedPosture) -> list[float]:
        """Return what the next posture is found with, of one that was found otherwise."""
        return [*posture.system.rows.ravel().tolist(),
                *posture.system.work[self._places].tolist()]

    def find(self, before: Moving, values: Sequence[float]) -> Found | None:
        """
        Return the next posture and its rates; None if it is not certainly the next one.

        Parameters
        ----------
        before : Moving
            The last posture.
        values : sequence of float
            Of the actuated joints: positions, velocities, ... up to the order.

        """
        dof = self._dof
        way = [a - b for a, b in zip(values[:dof], before.joints)]
        for k in self._wraps:
            if abs(way[k]) < 1e9:
                way[k] -= 2 * math.pi * round(way[k] / (2 * math.pi))
        if not all(abs(x * scale) <= LONGEST for x, scale in zip(way, self._scale)):
            return None
        try:
            return self._iterate(before, way, values[dof:dof * (self._order + 1)])
        except (ArithmeticError, ValueError):       # far out, or singular
            return None

    def _iterate(self, before: Moving, way: Sequence[float],
                 given: Sequence[float]) -> Found | None:
        actuated = [b + x for b, x in zip(before.joints, way)]
        passive = _predicted(before, way)
        last, limit = math.inf, NEAR * NEAR
        for iteration in range(1, ITERATIONS + 1):
            run = self._whole if last <= NEARLY * NEARLY else self._first
            rates = given if run is self._whole else ()
            out = run.evaluate([*actuated, *passive, *rates, *before.memory])
            at = run.slices
            size = out[at['size']][0]
            if not size <= limit:
                return None
            passive = [p + x for p, x in zip(passive, out[at['step']])]
            if size <= CONVERGED * CONVERGED and run is self._whole:
                break
            last, limit = size, max(size / 4, CONVERGED * CONVERGED)
        else:
            return None
        turn, change, stiffness, limp = out[at['tests']]
        if not (turn <= LARGEST_TURN**2 and change * stiffness <= APART and limp <= LIMP
                and stiffness <= STIFFEST and min(out[at['margins']]) >= 0
                and max(out[at['misfit']]) <= self._largest_misfit):
            return None
        speeds, found = given, list(out[at['rates']])
        if not self._order:     # the way itself, in the time of one sample
            speeds, found = way, [a - b for a, b in zip(passive, before.joints[len(way):])]
        return Found(Moving([*actuated, *passive], out[at['memory']], speeds, found),
                     out[at['pose']], out[at['states']], out[at['jacobian']],
                     out[at['misfit']], iteration)


class _Runner:
    """A traced step on a machine."""

    def __init__(self, step: TracedStep) -> None:
        self.evaluate = machine(step.line).evaluate
        self.slices = step.slices


def _predicted(before: Moving, way: Sequence[float]) -> list[float]:
    """Return the passive joints after the time in which the actuated ones go their way."""
    dof = len(way)
    passive, n = before.joints[dof:], len(before.joints) - dof
    speed, slope = before.actuated_rates[:dof], before.actuated_rates[dof:2 * dof]
    square = sum(v * v for v in speed)
    if not square > 0:
        return list(passive)
    time = sum(x * v for x, v in zip(way, speed)) / square
    rates, late = before.passive_rates, time * time / 2 * sum(
        a * v for a, v in zip(slope, speed)) / square
    # At low speed the time is not known well: a correction must be a small one.
    if not slope or abs(late) > abs(time) / 4:
        return [p + time * v for p, v in zip(passive, rates)]
    time -= late
    half = time * time / 2
    return [p + time * v + half * a for p, v, a in zip(passive, rates, rates[n:])]
