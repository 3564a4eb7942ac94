# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A posture of a parallel manipulator in which its loops are closed."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .limbs import Limbs
from .loop_closure import Solution
from .screw_system import Conditioning, ScrewSystem
from ..errors import ClosureError
from ..screws.se3 import Array


@dataclass(frozen=True, eq=False)
class ClosedPosture:
    """
    Positions of all joints with the platform they carry.

    Parameters
    ----------
    actuated : array, shape (actuated joints,)
        Positions of the actuated joints [rad, m].
    passive : array, shape (passive joints,)
        Positions of the passive joints [rad, m].
    pose : array, shape (4, 4)
        Of the platform frame in the base frame [m].
    system : ScrewSystem
        The limbs' screws, pole at the platform frame's origin, axes of the base.
    misfit : array, shape (limbs,)
        How far each limb's tip is from the platform: rotation [rad] and displacement,
        divided by the characteristic length, as one number. Rounding error where loops
        can close; more only with redundant measurements that contradict each other.
    iterations : int
        Newton steps it took, in all parts of the way.
    working_mode : array of int, shape (actuated joints,)
        1 as in the home posture, -1 where the limb passed an inverse singularity since
        (a stretched limb came out on the other side).

    """

    actuated: Array
    passive: Array
    pose: Array
    system: ScrewSystem
    misfit: Array
    iterations: int
    working_mode: Array

    @property
    def joints(self) -> Array:
        """All joints, the actuated ones first, shape (joints,)."""
        return np.concatenate([self.actuated, self.passive])

    @property
    def conditioning(self) -> Conditioning:
        """Distances to singular postures."""
        return self.system.conditioning


def posture_of(limbs: Limbs, solution: Solution, working_mode: Array,
               tolerance: float) -> ClosedPosture:
    """Return the posture of a solution; raise ClosureError if a loop misses by too much."""
    worst = int(np.argmax(solution.misfit))
    misfit, direct = float(solution.misfit[worst]), solution.system.direct_conditioning
    n = len(limbs.actuated)
    actuated, passive = solution.joints[:n], solution.joints[n:]
    if not solution.converged or misfit > tolerance:
        raise ClosureError(
            limbs.names[worst], misfit, f'misfit {misfit:.3g} (rad, or lengths by '
            f'{limbs.length:.4g} m) after {solution.iterations} Newton steps '
            f'{limbs.at(actuated)}; direct singular value {direct:.2g}')
    return ClosedPosture(actuated, passive, solution.pose, solution.system, solution.misfit,
                         solution.iterations, working_mode)
