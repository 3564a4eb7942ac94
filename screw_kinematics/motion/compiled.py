# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The steady steps of bank and smoother as machine code (optional extra ``fast``)."""

from __future__ import annotations

from functools import lru_cache
from importlib.util import find_spec
import math
from typing import Any, NamedTuple

ROWS = 13
"""Rows of a bank's record: 0-3 predicted states, 4-7 states, 8 innovation of the position, 9 of
the velocity, 10 and 11 the mean squares of the two, 12 the weights."""


class Kernels(NamedTuple):
    """Compiled functions; see `load`."""

    steady_step: Any
    weighted_mean: Any
    add_correction: Any


_ready: list[Kernels] = []


def ready() -> Kernels | None:
    """Return the compiled functions if some estimator has been warmed up, else None."""
    return _ready[0] if _ready else None


def announce(kernels: Kernels) -> None:
    """Let estimators made from now on use the functions, which have run once."""
    _ready[:] = [kernels]


@lru_cache(maxsize=1)
def load() -> Kernels | None:
    """
    Return functions that are compiled when they first run; None where Numba is not installed.

    Compiling takes a second or two and belongs to configuration, not to the first message; the
    result is cached on disk where that can be written.
    """
    if find_spec('numba') is None:
        return None
    try:
        return _define(cache=True)
    except RuntimeError:      # no place for the cache
        return _define(cache=False)


def _define(cache: bool) -> Kernels:
    from numba import njit

    @njit(cache=cache, error_model='numpy')
    def steady_step(  # type: ignore[no-untyped-def]
            old, new, mean, table, velocity_table, position, velocity, r, forget, span, floor):
        """Do what `FilterBank._steady_step` does; tables hold gains, precision, constants."""
        filters, joints = new.shape[1], new.shape[2]
        groups = table.shape[2]
        measured = velocity_table.shape[0] > 0
        keep = 1.0 - forget
        for j in range(joints):
            g = j if groups > 1 else 0
            best = math.inf
            for m in range(filters):
                x3 = old[7, m, j]
                x2 = old[6, m, j] + 3.0 * r * x3
                x1 = old[5, m, j] + r * (2.0 * old[6, m, j] + 3.0 * r * x3)
                x0 = old[4, m, j] + r * (old[5, m, j] + r * (old[6, m, j] + r * x3))
                new[0, m, j], new[1, m, j], new[2, m, j], new[3, m, j] = x0, x1, x2, x3
                e = position[j] - x0
                new[8, m, j] = e
                x0 += table[0, m, g] * e
                x1 += table[1, m, g] * e
                x2 += table[2, m, g] * e
                x3 += table[3, m, g] * e
                square = keep * old[10, m, j] + forget * table[4, m, g] * e * e
                new[10, m, j] = square
                score = math.log(square + floor) + table[5, m, g]
                if measured:
                    e = velocity[j] - x1
                    new[9, m, j] = e
                    x0 += velocity_table[0, m, g] * e
                    x1 += velocity_table[1, m, g] * e
                    x2 += velocity_table[2, m, g] * e
                    x3 += velocity_table[3, m, g] * e
                    square = keep * old[11, m, j] + forget * velocity_table[4, m, g] * e * e
                    new[11, m, j] = square
                    if velocity_table[5, m, g] > 0.0:
                        score += math.log(square + floor)
                else:
                    new[9, m, j] = 0.0
                    new[11, m, j] = old[11, m, j]
                new[4, m, j], new[5, m, j], new[6, m, j], new[7, m, j] = x0, x1, x2, x3
                new[12, m, j] = score
                best = min(best, score)
            total = 0.0
            for m in range(filters):
                w = math.exp(-0.5 * span * (new[12, m, j] - best))
                new[12, m, j] = w
                total += w
            total = 1.0 / total
            for k in range(4):
                mean[k, j] = 0.0
            for m in range(filters):
                w = new[12, m, j] * total
                new[12, m, j] = w
                for k in range(4):
                    mean[k, j] += w * new[4 + k, m, j]

    @njit(cache=cache, error_model='numpy', fastmath={'reassoc', 'contract'})
    def weighted_mean(mean, weights, state):  # type: ignore[no-untyped-def]
        """Write the weighted mean of the filters' states to `mean`."""
        mean[:] = 0.0
        for k in range(4):
            for m in range(weights.shape[0]):
                for j in range(weights.shape[1]):
                    mean[k, j] += weights[m, j] * state[k, m, j]

    @njit(cache=cache, error_model='numpy', fastmath={'reassoc', 'contract'})
    def add_correction(mean, taps, errors, start, count, weights):  # type: ignore[no-untyped-def]
        """Add to `mean` what `Taps.correction` finds in one of the two innovations."""
        filters, joints = weights.shape
        groups = taps.shape[2]
        for j in range(joints):
            g = j if groups > 1 else 0
            a0, a1, a2, a3 = 0.0, 0.0, 0.0, 0.0
            for m in range(filters):
                w = weights[m, j]
                if w < 1e-14:      # cannot be seen in the sum
                    continue
                for i in range(count):
                    e = w * errors[start + i, m, j]
                    a0 += taps[m, i, g, 0] * e
                    a1 += taps[m, i, g, 1] * e
                    a2 += taps[m, i, g, 2] * e
                    a3 += taps[m, i, g, 3] * e
            mean[0, j] += a0
            mean[1, j] += a1
            mean[2, j] += a2
            mean[3, j] += a3

    return Kernels(steady_step, weighted_mean, add_correction)
