# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A parallel manipulator from sample to sample: each posture is found from the last one."""
from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .closed_posture import ClosedPosture
from .continuation import Effort, follow
from .limbs import Limbs
from .rates import platform_states
from .screw_system import ScrewSystem
from .traced_newton import Moving, NearbySteps, NextPosture
from ..errors import ScrewKinematicsError
from ..screws.rigid import pose_from_row, row_of_pose
from ..screws.se3 import Array

THOROUGH, BRIEF = Effort(40, 8, 1e-3), Effort(1, 4, 1.0)
FAILURES_BEFORE_PAUSE, PAUSE = 16, 8
"""After so many samples without a posture in a row, only every so many-th is searched for."""


class Solved(NamedTuple):
    """What is known at a sample, flat."""

    seen: Sequence[float]             # pose, states by order and, if asked for, Jacobian, in a row
    passive: Sequence[float]          # positions of the passive joints [rad, m]
    passive_rates: Sequence[float]    # their derivatives by order


class PostureTracker:
    """
    The posture of a manipulator, going on from sample to sample, at first from home.

    Samples near the last one take traced Newton steps; what these do not certainly find is
    searched for on the way from the last good posture, then from home.
    """

    def __init__(self, limbs: Limbs, home: ClosedPosture, closed: float, order: int,
                 with_jacobian: bool) -> None:
        self._limbs, self._home, self._closed = limbs, home, closed
        self._order, self._with_jacobian = order, with_jacobian
        self._n_passive = len(limbs.joint_names) - len(limbs.actuated)
        ranks = home.system.ranks
        joints = np.bincount(limbs.slot_of[0], minlength=len(limbs.chains))
        # Limbs with dependent passive screws (a leg free to spin) are not traced.
        self._nearby = None if np.any(ranks.kept.sum(axis=1) < joints) else NearbySteps(
            limbs, ranks, order, with_jacobian, closed)
        self._found: NextPosture | None = None
        self._moving = Moving((), (), ())
        self._refusal: ScrewKinematicsError | None = None
        self.reset()

    @property
    def operations(self) -> int | None:
        """Return how many a sample near the last one takes; None where steps are not traced."""
        return None if self._nearby is None else self._nearby.operations

    def reset(self) -> None:
        """Forget the stream: the next sample is found from the home posture."""
        self.posture = self._home
        self._failures = 0

    @property
    def posture(self) -> ClosedPosture:
        """Return the last good posture."""
        if self._found is not None:
            self._posture, self._found = self._as_posture(self._found), None
        return self._posture

    @posture.setter
    def posture(self, posture: ClosedPosture) -> None:
        self._posture, self._found = posture, None
        if self._nearby is not None:
            self._moving = self._nearby.moving(posture)

    def update(self, values: Sequence[float]) -> Solved:
        """
        Go on to a sample: positions, velocities, ... of the actuated joints up to the order.

        Raises
        ------
        ClosureError, AssemblyModeError, SingularityError
            There is no way to this sample.

        """
        if self._nearby is not None:
            found = self._nearby.find(self._moving, values)
            if found is not None:
                self._found, self._moving, self._failures = found, found.moving, 0
                n, carried = self._n_passive, found.moving.carried
                return Solved(found.seen, carried[:n], carried[n:(1 + self._order) * n])
        motion = np.array(values, dtype=float).reshape(self._order + 1, -1)
        posture = self._search(motion[0])
        states, passive = platform_states(self._limbs, posture, list(motion[1:]))
        rates = [x for values in passive for x in values.tolist()]
        self._posture, self._found = posture, None
        if self._nearby is not None:
            self._moving = self._nearby.moving(posture, motion[1:].ravel().tolist(), rates)
        seen = [row_of_pose(posture.pose), *states]
        if self._with_jacobian:
            seen.append(posture.system.jacobian.ravel())
        return Solved(np.concatenate(seen).tolist(), posture.passive.tolist(), rates)

    def _as_posture(self, found: NextPosture) -> ClosedPosture:
        """Return a posture found nearby, with its screws; the working mode is as before."""
        n = len(self._limbs.actuated)
        joints = np.array([*found.moving.actuated, *found.moving.carried[:self._n_passive]])
        _, _, screws = self._limbs.kinematics(joints.tolist())
        return ClosedPosture(
            joints[:n], joints[n:], pose_from_row(found.seen[:12]),
            ScrewSystem(screws, self._limbs.length, self._home.system.ranks),
            np.sqrt(found.squared_misfit), found.iterations, self._posture.working_mode)

    def _search(self, q: Array) -> ClosedPosture:
        """Return the posture of a sample: from the last one, else from home."""
        # A search in vain takes long: while samples fail it is made ever more rarely.
        n = self._failures
        self._failures += 1
        if n > FAILURES_BEFORE_PAUSE and n % PAUSE and self._refusal is not None:
            raise self._refusal.with_traceback(None)
        effort, starts = BRIEF, [self.posture]
        if n & (n - 1) == 0 or n % 512 == 0:
            effort, starts = THOROUGH, [self.posture, self._home]
            if n:           # by turns, which costs half
                starts = starts[n.bit_length() % 2:][:1]
        for start in starts:
            try:
                posture = follow(self._limbs, start, q, self._closed, effort)
            except ScrewKinematicsError as error:
                self._refusal = error
            else:
                self._failures = 0
                return posture
        assert self._refusal is not None
        raise self._refusal
