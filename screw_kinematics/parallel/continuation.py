# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Following a parallel manipulator from one posture to another.

The loops close in several assembly modes, and Newton-Raphson from far away may land in any.
So the actuators' way is walked in steps small enough that the passive joints do as the
screws predict, and a step over a direct singularity, where assembly modes meet, is refused.
"""
from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .closed_posture import ClosedPosture, posture_of
from .limbs import Limbs
from .loop_closure import close_loops, MAX_ITERATIONS, Solution
from .screw_system import SINGULAR
from ..errors import AssemblyModeError, ScrewKinematicsError, SingularityError
from ..screws.se3 import Array

LONGEST = 0.3
"""Longest predicted motion of a passive joint in one step [rad, m by the length]."""
NEARLY_CLOSED = 1e-6
"""Misfit below which slow convergence means a singularity, not an open loop."""
SAME = 1e-6
"""Difference of joints [rad, m] up to which postures are the same."""


class Effort(NamedTuple):
    """How long a way is searched for."""

    steps: int = 1000                   # taken or refused, after which the search is given up
    iterations: int = MAX_ITERATIONS    # Newton steps in each of them
    shortest: float = 1e-5              # part of the way below which a step is given up


def follow(limbs: Limbs, start: ClosedPosture, target: Array, closed: float,
           effort: Effort = Effort()) -> ClosedPosture:
    """
    Return the posture for given actuators [rad, m], in the assembly mode of another posture.

    Raises
    ------
    ClosureError
        A loop does not close, on the way or at its end.
    AssemblyModeError
        The way leads over a direct singularity into another assembly mode.
    SingularityError
        The posture itself is singular.

    """
    here, left, share, total = start, 1.0, 1.0, 0
    way = _way(limbs, start.actuated, target)
    reason: ScrewKinematicsError | None = None
    for _ in range(effort.steps):
        remaining = left * way
        _, passive = here.system.solve_platform(here.system.actuated_motion(remaining))
        predicted = np.concatenate([remaining, passive[limbs.slot_of]])
        longest = float((np.abs(predicted) * limbs.scale).max())
        share = min(share, LONGEST / max(longest, LONGEST))
        try:
            there = _step(limbs, here, share * predicted, closed, effort.iterations)
        except ScrewKinematicsError as error:
            reason, share = error, share / 2
            if share * left < effort.shortest:
                break
            continue
        total += there.iterations
        here, left = there, left * (1 - share)
        if share == 1.0:
            return replace(here, iterations=total)
        share = min(1.0, 2 * share / (1 - share))
    if effort.steps > 1 or reason is None:
        reason = _verdict(limbs, here, left * way, closed, effort.iterations) or reason
    raise reason or AssemblyModeError(
        f'the way is too long for {effort.steps} steps {limbs.at(target)}')


def check_same_mode(limbs: Limbs, posture: ClosedPosture, expected: ClosedPosture) -> None:
    """
    Raise AssemblyModeError, with a joint that differs, unless two postures are the same.

    They are for the same actuators; the expected one is in the assembly mode of home.
    """
    away = np.abs(limbs.difference(posture.joints, expected.joints))
    worst = int(np.argmax(away))
    if away[worst] > SAME:
        raise AssemblyModeError(
            f'another assembly mode than at home: joint {limbs.joint_names[worst]!r} is at '
            f'{posture.joints[worst]:.6g}, but comes to {expected.joints[worst]:.6g} from '
            f'home {limbs.at(posture.joints)}')


def _verdict(limbs: Limbs, here: ClosedPosture, remaining: Array, closed: float,
             iterations: int) -> ScrewKinematicsError | None:
    """
    Return what is wrong with the end of the way.

    Where the way ends, small steps fail for any reason. Whether the loops close at all with
    the actuators where they should be, says more.
    """
    try:
        _step(limbs, here, np.concatenate([remaining, 0 * here.passive]), closed, iterations)
    except ScrewKinematicsError as error:
        return error
    return None


def _step(limbs: Limbs, here: ClosedPosture, part: Array, closed: float,
          iterations: int) -> ClosedPosture:
    """Return the posture one step on; raise why there is none."""
    there = close_loops(limbs, here.joints + part, here.system.ranks, iterations)
    if np.max(there.misfit) <= max(closed, NEARLY_CLOSED):
        _check_step(limbs, here, there, part)
    signs = there.system.working_signs(here.system)
    return posture_of(limbs, there, here.working_mode * signs, closed)


def _way(limbs: Limbs, start: Array, target: Array) -> Array:
    """Return the actuators' way; a measured angle that wraps goes the short way round."""
    way = target - start
    turns = np.where(limbs.wraps, np.round(way / (2 * np.pi)), 0.0)
    return way - 2 * np.pi * turns


def _check_step(limbs: Limbs, here: ClosedPosture, there: Solution, part: Array) -> None:
    """Raise why a step cannot be taken although its end is closed or nearly so."""
    direct = there.system.direct_conditioning
    if direct < SINGULAR or not there.converged:
        raise SingularityError(
            f'direct singularity: the platform can move with the actuators locked; smallest '
            f'singular value of the reciprocal wrenches {direct:.2g} {limbs.at(there.joints)}')
    if there.system.assembly_sign(here.system) <= 0:
        raise AssemblyModeError(
            'the loops close, but in another assembly mode: the way there leads over a direct '
            f'singularity {limbs.at(there.joints)}')
    strayed = np.abs(there.joints - here.joints - part) * limbs.scale
    if strayed.max() > (np.abs(part) * limbs.scale).max() / 2 + 1e-6:
        name = limbs.joint_names[int(np.argmax(strayed))]
        raise AssemblyModeError(
            f'the loops close, but joint {name!r} jumps by {np.max(strayed):.3g} (rad, or '
            f'lengths by {limbs.length:.4g} m), as into another assembly mode '
            f'{limbs.at(there.joints)}')
