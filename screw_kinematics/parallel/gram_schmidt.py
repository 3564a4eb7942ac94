# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Least squares by orthogonal columns, without branches: for numbers and traced expressions.

Modified Gram-Schmidt. Right sides are reduced column by column, as if they were one more
column, which makes it as accurate as reflections.

References
----------
Å. Björck, "Solving linear least squares problems by Gram-Schmidt orthogonalization",
BIT 7 (1967), 1-21.

"""
from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ..screws.se3 import Array


class OrthogonalColumns:
    """
    A matrix of full column rank, of floats or expressions, as unit columns times a triangle.

    Examples
    --------
    >>> matrix = OrthogonalColumns([np.array([3.0, 0, 4]), np.array([1.0, 1, 1])])
    >>> [round(float(x), 12) for x in matrix.solve(np.array([7.0, 1, 9]))]
    [2.0, 1.0]

    """

    def __init__(self, columns: Iterable[Array]) -> None:
        self.unit: list[Array] = []
        self._triangle: list[list[Any]] = []        # above the diagonal, by columns
        self._inverse_sizes: list[Any] = []
        for column in columns:
            parts, rest = self._reduced(column)
            inverse = 1.0 / _root(rest @ rest)
            self.unit.append(rest * inverse)
            self._triangle.append(parts)
            self._inverse_sizes.append(inverse)

    def _reduced(self, vector: Array) -> tuple[list[Any], Array]:
        """Return a vector's parts along the unit columns, and what is left of it."""
        parts = []
        for column in self.unit:
            parts.append(column @ vector)
            vector = vector - parts[-1] * column
        return parts, vector

    def solve(self, right: Array) -> list[Any]:
        """Return the solution of least squares for a right side, shape (m,)."""
        return self._substituted(self._reduced(right)[0])

    def solve_roughly(self, right: Array) -> list[Any]:
        """Return the same from half the work, for columns far from dependent."""
        return self._substituted([column @ right for column in self.unit])

    def _substituted(self, parts: list[Any]) -> list[Any]:
        """Return the solution for parts along the unit columns."""
        rest, solution = list(parts), [0.0] * len(parts)
        for j in reversed(range(len(parts))):
            solution[j] = rest[j] * self._inverse_sizes[j]
            for i, factor in enumerate(self._triangle[j]):
                rest[i] = rest[i] - factor * solution[j]
        return solution

    def complement(self, seeds: Iterable[Array]) -> list[Array]:
        """
        Return unit vectors orthogonal to the columns and to each other, near the seeds.

        Seeds are independent of the columns; what is orthogonal to them already stays.
        """
        count = len(self.unit)
        basis = OrthogonalColumns([])
        basis.unit = list(self.unit)
        for seed in seeds:
            _, rest = basis._reduced(seed)
            basis.unit.append(rest * (1.0 / _root(rest @ rest)))
        return basis.unit[count:]

    def inverse_square(self) -> Any:
        """
        Return the sum of the squared singular values' inverses: large for dependent columns.

        Its root is between 1 and the root of the number of columns, by the smallest singular
        value.
        """
        total: Any = 0.0
        for j in range(len(self.unit)):
            row = self._substituted([1.0 if i == j else 0.0 for i in range(len(self.unit))])
            total = total + sum(x * x for x in row)
        return total

    def inverse_size_square(self) -> Any:
        """Return the sum of the inverse squares of what each column adds to those before."""
        return sum((x * x for x in self._inverse_sizes), 0.0)


def _root(x: Any) -> Any:
    """Return the square root of a float or of an expression."""
    return x.sqrt() if hasattr(x, 'sqrt') else float(np.sqrt(x))
