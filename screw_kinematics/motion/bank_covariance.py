# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The covariances that a bank of filters tells, with what the clock adds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .clock_error import ClockError
from ..core.tables import TRIANGLE

DIAGONAL = [k for k, (i, j) in enumerate(TRIANGLE) if i == j]


class BankCovariance:
    """
    Covariance of position and three derivatives of each joint, made when it is asked for.

    As the clock errs, each joint errs along its own motion: by the next derivative for the
    instant, by its order for the rate. Triangles are the upper ones, n numbers for each of ten
    rows; values are positions, velocities, ... in a row; the error is of all joints alike.
    """

    def __init__(self, triangles: Sequence[float], values: Sequence[float],
                 error: ClockError) -> None:
        self._triangles, self._values, self._error = triangles, values, error

    def __call__(self) -> NDArray[np.float64]:
        """Return the covariances, shape (n, 4, 4)."""
        rows = np.array(self._triangles).reshape(10, -1)
        covariance = np.empty((rows.shape[1], 4, 4))
        for row, (i, j) in zip(rows, TRIANGLE):
            covariance[:, i, j] = covariance[:, j, i] = row
        if self._error:
            along = self._error.of_state(np.array(self._values).reshape(4, -1))
            covariance += np.einsum('kin,kjn->nij', along, along)
        return covariance

    def variances(self) -> list[float]:
        """Return what stands on their diagonals, n numbers for each of four rows."""
        triangles, values, error = self._triangles, self._values, self._error
        n = len(triangles) // 10
        found: list[float] = []
        for order, row in enumerate(DIAGONAL):
            for k in range(n * order, n * order + n):
                onward = values[k + n] if order < 3 else 0.0
                found.append(triangles[k + n * (row - order)]
                             + error.variance(order, values[k], onward))
        return found
