# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: initializedcheck=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""From variances of joints to the covariance of what a Jacobian makes of them."""
from __future__ import annotations

from collections.abc import Sequence

try:
    import cython
except ImportError:
    from . import uncompiled as cython
from .tables import zeros
if not cython.compiled:
    from .readings import fill


class ThroughJacobian:
    """For Jacobians of one shape: so many rows, and n columns, of joints."""

    def __init__(self, rows: int, n: int) -> None:
        self.rows, self.n = rows, n
        self.jacobian, self.variance = zeros(rows * n), zeros(n)
        self.common, self.made = zeros(n), zeros(rows)
        self.out = zeros(rows * rows)

    def covariance(self, jacobian: Sequence[float], variances: Sequence[float],
                   together: Sequence[Sequence[float]], made: Sequence[float] = (),
                   ) -> list[float]:
        """
        Return ``J (diag(variances - t^2)) J^T + m m^T``, for each t of `together`, row by row.

        m is J t; of the first t it is `made` if that is given. Raise ValueError if there are fewer
        or more numbers than in that shape.
        """
        i: cython.Py_ssize_t
        for i in range(self.rows * self.rows):
            self.out[i] = 0.0
        fill(self.jacobian, jacobian)
        fill(self.variance, variances)
        for each in together:
            fill(self.common, each)
            if len(made):
                fill(self.made, made)
                made = ()
            else:
                self.carry()
            self.add_common()
        self.add()
        return [self.out[i] for i in range(self.rows * self.rows)]

    def carry(self) -> None:
        """Carry what joints err by at once through the Jacobian."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        n: cython.Py_ssize_t = self.n
        for i in range(self.rows):
            total: cython.double = 0.0
            for k in range(n):
                total += self.jacobian[i * n + k] * self.common[k]
            self.made[i] = total

    def add_common(self) -> None:
        """Add what joints that err at once make, which is none of their own variance."""
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        k: cython.Py_ssize_t
        for k in range(self.n):
            self.variance[k] -= self.common[k] * self.common[k]
        for i in range(self.rows):
            for j in range(self.rows):
                self.out[i * self.rows + j] += self.made[i] * self.made[j]

    def add(self) -> None:
        """Add what joints make that err each on its own."""
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        k: cython.Py_ssize_t
        n: cython.Py_ssize_t = self.n
        for i in range(self.rows):
            for j in range(i + 1):
                total: cython.double = 0.0
                for k in range(n):
                    total += (self.jacobian[i * n + k] * self.jacobian[j * n + k]
                              * self.variance[k])
                self.out[i * self.rows + j] += total
                if j < i:
                    self.out[j * self.rows + i] += total
