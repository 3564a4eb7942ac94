# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The covariances that a bank of filters tells, with what the clock adds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .clock_error import ClockError
from ..core.tables import TRIANGLE

DIAGONAL = [k for k, (i, j) in enumerate(TRIANGLE) if i == j]


class BankCovariance(NamedTuple):
    """
    Covariance of position and three derivatives of each joint, made when it is asked for.

    As the clock errs, each joint errs along its own motion: by the next derivative for the
    instant, by its order for the rate.
    """

    triangles: Sequence[float]    # the upper ones, n numbers for each of ten rows
    values: Sequence[float]       # positions, velocities, ... in a row
    error: ClockError             # of all joints alike

    def __call__(self) -> NDArray[np.float64]:
        """Return the covariances, shape (n, 4, 4)."""
        rows = np.array(self.triangles).reshape(10, -1)
        covariance = np.empty((rows.shape[1], 4, 4))
        for row, (i, j) in zip(rows, TRIANGLE):
            covariance[:, i, j] = covariance[:, j, i] = row
        if any(self.error):
            along = self.error.of_state(np.array(self.values).reshape(4, -1))
            covariance += np.einsum('kin,kjn->nij', along, along)
        return covariance

    def variances(self) -> list[float]:
        """Return what stands on their diagonals, n numbers for each of four rows."""
        n = len(self.triangles) // 10
        found: list[float] = []
        for order, row in enumerate(DIAGONAL):
            own = self.triangles[n * row:n * row + n]
            for along in self.error.deviations(order, self.values[n * order:n * order + n],
                                               self.values[n * order + n:n * order + 2 * n]):
                own = [variance + d * d for variance, d in zip(own, along)]
            found += own
        return found
