# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What the screw systems of a parallel manipulator's limbs are made of, and described by."""
from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..screws.se3 import Array

RANK_TOLERANCE = 1e-6
"""Relative size below which a singular value counts as zero where ranks are decided."""


class LimbScrews(NamedTuple):
    """
    Unit screws of the joints about the platform point, in base axes; zero where absent.

    ``passive`` has shape (limbs, 6, most passive joints of a limb), ``actuated``
    (limbs, 6, actuated joints).
    """

    passive: Array
    actuated: Array


@dataclass(frozen=True)
class Conditioning:
    """
    Distances to singular postures; 0 is singular.

    Parameters
    ----------
    direct : float
        Smallest singular value of the platform's reciprocal wrenches, each of unit size,
        with the characteristic length: at 0 the platform moves with the actuators locked.
    inverse : float
        Smallest singular value of the actuators' work on these wrenches, each actuator's
        screw scaled to unit size: at 0 an actuator moves with the platform at rest.
    limbs : float
        Smallest over the limbs, of the ratio of smallest to largest singular value of the
        limb's passive screws: at 0 passive joints move with the platform at rest.

    """

    direct: float
    inverse: float
    limbs: float


class Ranks(NamedTuple):
    """
    Ranks of the limbs' passive screws in general posture.

    A limb of rank r has its r largest singular values, and 6 - r reciprocal wrenches, in
    singular postures too: nothing jumps when a singularity is passed.

    Parameters
    ----------
    kept : array of bool, shape (limbs, singular values)
        Which singular values count.
    limb_of_row, row : array of int, shape (wrenches,)
        Limb of each reciprocal wrench, and its place among the left singular vectors.

    """

    kept: Array
    limb_of_row: Array
    row: Array

    @classmethod
    def of(cls, sizes: Array) -> Ranks:
        """Return the ranks that singular values, shape (limbs, n), largest first, show."""
        ranks = np.sum(sizes > RANK_TOLERANCE * sizes[:, :1], axis=1)[:, None]
        return cls(np.arange(sizes.shape[1]) < ranks, *np.nonzero(np.arange(6) >= ranks))
