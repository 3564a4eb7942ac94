# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Rows and tables of numbers, and the constants of integrated-Wiener filters."""
from __future__ import annotations

from array import array
from collections.abc import Iterable

TIME_UNIT = 0.02
"""Component i of a state is its i-th derivative times TIME_UNIT**i / i!, s."""

SCALE = (1.0, TIME_UNIT, TIME_UNIT**2 / 2.0, TIME_UNIT**3 / 6.0)
"""That, for each component."""

TRIANGLE = [(i, j) for i in range(4) for j in range(i, 4)]
"""Rows and columns of the numbers of a symmetric matrix: its upper triangle, by rows."""

WINDOW = 0.1
"""Memory of the innovations, s."""

EVIDENCE = 0.65
"""What a score is worth as evidence, since noise is coloured."""

SPARSE = 0.01
"""Period at which a handicap counts once, s; the more samples in a window, the more alike are the
errors of neighbours."""

DENSEST = 8.0
"""By how much a period may be shorter and count more."""

LEAST = 1e-26
"""Variances of signals are never below."""

FINEST = 1e-6
"""Steps of an encoder are not known better [rad]."""

NOTHING = -9.2
"""Logarithm of a weight beside the best filter's that is none: a share of 1e-4."""


def table(rows: int, columns: int) -> memoryview:
    """Return a table of zeros, which has a number at least."""
    rows, columns = max(rows, 1), max(columns, 1)
    return memoryview(bytearray(8 * rows * columns)).cast('d', (rows, columns))


def row(values: Iterable[float]) -> memoryview:
    """Return numbers in a row."""
    return memoryview(array('d', values))


def zeros(count: int) -> memoryview:
    """Return zeros in a row."""
    return memoryview(array('d', bytes(8 * count)))
