# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: initializedcheck=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Medians, and lines through pairs of tick and stamp of which some are outliers."""
from __future__ import annotations

try:
    import cython
except ImportError:
    from . import uncompiled as cython
from .tables import zeros
if cython.compiled:
    from cython.cimports.libc.math import fabs, sqrt
else:
    from math import fabs, sqrt

STRETCHES = cython.declare(cython.Py_ssize_t, 16)
LEAST = cython.declare(cython.Py_ssize_t, 4)
"""Stretches of a line whose means tell how well it is known, and pairs of each at least."""


def kth(values: cython.double[::1], count: cython.Py_ssize_t,
        k: cython.Py_ssize_t) -> cython.double:
    """Return the k-th smallest of some numbers, which are reordered (Hoare)."""
    low: cython.Py_ssize_t = 0
    high: cython.Py_ssize_t = count - 1
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    while low < high:
        pivot: cython.double = values[k]
        i, j = low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while pivot < values[j]:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i += 1
                j -= 1
        if j < k:
            low = i
        if k < i:
            high = j
    return values[k]


def median(values: cython.double[::1], count: cython.Py_ssize_t) -> cython.double:
    """Return the median of some numbers, which are reordered."""
    upper: cython.double = kth(values, count, count // 2)
    if count % 2 == 1:
        return upper
    return 0.5 * (upper + kth(values, count, count // 2 - 1))


def fit_line(k: cython.double[::1], t: cython.double[::1], count: cython.Py_ssize_t,
             weight: cython.double[::1], rest: cython.double[::1],
             out: cython.double[::1]) -> cython.void:
    """Fit t = out[0] + out[1] k, outliers counting less (Huber); out[2] is the mean deviation."""
    i: cython.Py_ssize_t
    turn: cython.Py_ssize_t
    slope: cython.double = 0.0
    mk: cython.double = 0.0
    mt: cython.double = 0.0
    mean: cython.double = 0.0
    for i in range(count):
        weight[i] = 1.0
    for turn in range(4):
        total: cython.double = 0.0
        mk = mt = 0.0
        for i in range(count):
            total += weight[i]
            mk += weight[i] * k[i]
            mt += weight[i] * t[i]
        mk /= total
        mt /= total
        both: cython.double = 0.0
        square: cython.double = 0.0
        for i in range(count):
            both += weight[i] * (k[i] - mk) * (t[i] - mt)
            square += weight[i] * (k[i] - mk) * (k[i] - mk)
        slope = both / square
        mean = 0.0
        for i in range(count):
            rest[i] = fabs(t[i] - mt - slope * (k[i] - mk))
            weight[i] = rest[i]
            mean += rest[i]
        allowed: cython.double = 1.5 * median(rest, count) + 1e-9
        for i in range(count):
            weight[i] = 1.0 if weight[i] <= allowed else allowed / weight[i]
    out[0], out[1], out[2] = mt - slope * mk, slope, mean / count


def mean_error(k: cython.double[::1], t: cython.double[::1], count: cython.Py_ssize_t,
               weight: cython.double[::1], line: cython.double[::1]) -> cython.double:
    """
    Return the standard error of a line's mean; 0 where pairs are too few.

    From the means of stretches, since neighbours may be alike, or make good what the others are
    off. Those that count less move the mean, but do not hold it (Huber 1981, 3.2).
    """
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    each: cython.Py_ssize_t = count // STRETCHES
    square: cython.double = 0.0
    holding: cython.double = 0.0
    if each < LEAST:
        return 0.0
    for j in range(STRETCHES):
        off: cython.double = 0.0
        for i in range(count - (j + 1) * each, count - j * each):
            off += weight[i] * (t[i] - line[0] - line[1] * k[i])
            holding += 1.0 if weight[i] == 1.0 else 0.0
        square += off * off
    # The line leaves two degrees of freedom less than there are stretches.
    return sqrt(square * STRETCHES / (STRETCHES - 2)) / holding


class Line:
    """The latest pairs of tick and stamp, or means of some in a row, and the line through them."""

    def __init__(self, size: int) -> None:
        self.size, self.count = size, 0
        self.stride, self.gathered = 1, 0
        self.sum_k = self.sum_t = 0.0
        self.k, self.t, self.out = zeros(size), zeros(size), zeros(3)
        self.weight, self.rest, self.error = zeros(size), zeros(size), 0.0

    def add(self, tick: cython.double, stamp: cython.double) -> None:
        """Add a pair; the oldest quarter is forgotten where there is no room."""
        self.sum_k += tick
        self.sum_t += stamp
        self.gathered += 1
        if self.gathered < self.stride:
            return
        if self.count == self.size:
            self.keep(self.stride * (self.size - self.size // 4))
        self.k[self.count] = self.sum_k / self.gathered
        self.t[self.count] = self.sum_t / self.gathered
        self.count += 1
        self.gathered, self.sum_k, self.sum_t = 0, 0.0, 0.0

    def keep(self, last: cython.Py_ssize_t) -> None:
        """Forget all but the latest pairs, so many of those that were added."""
        i: cython.Py_ssize_t
        last = last // self.stride if last > self.stride else 1
        if last >= self.count:
            return
        for i in range(last):
            self.k[i], self.t[i] = self.k[self.count - last + i], self.t[self.count - last + i]
        self.count = last

    def merge(self) -> None:
        """Keep the means of two and two, so that there is room for twice as many."""
        i: cython.Py_ssize_t
        self.stride *= 2
        self.count //= 2
        for i in range(self.count):
            self.k[i] = 0.5 * (self.k[2 * i] + self.k[2 * i + 1])
            self.t[i] = 0.5 * (self.t[2 * i] + self.t[2 * i + 1])

    def rescale(self, origin: cython.double, factor: cython.double) -> None:
        """Count ticks from another origin, and by another length."""
        i: cython.Py_ssize_t
        for i in range(self.count):
            self.k[i] = (self.k[i] - origin) / factor
        self.sum_k = (self.sum_k - self.gathered * origin) / factor

    def full(self) -> bool:
        """Whether the next pair takes the place of old ones."""
        return self.count == self.size

    def ticks(self) -> float:
        """Return the ticks from the first pair to the last."""
        return self.k[self.count - 1] - self.k[0] if self.count else 0.0

    def pairs(self) -> int:
        """Return how many were added of those that are remembered."""
        return self.count * self.stride

    def fit(self, tick: cython.double) -> tuple[float, float, float]:
        """Return the line's stamp at a tick, its slope, and the mean deviation."""
        i: cython.Py_ssize_t
        start: cython.double = self.t[self.count - 1]
        for i in range(self.count):
            self.k[i] -= tick
            self.t[i] -= start
        fit_line(self.k, self.t, self.count, self.weight, self.rest, self.out)
        self.error = mean_error(self.k, self.t, self.count, self.weight, self.out)
        for i in range(self.count):
            self.k[i] += tick
            self.t[i] += start
        return self.out[0] + start, self.out[1], self.out[2]
