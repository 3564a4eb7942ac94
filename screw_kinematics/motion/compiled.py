# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The steady steps of bank and smoother as machine code (optional extra ``fast``)."""

from __future__ import annotations

from functools import lru_cache
from importlib.util import find_spec
import math
from typing import Any, NamedTuple

import numpy as np

ROWS = 13
"""Rows of a bank's record: 0-3 predicted states, 4-7 states, 8 innovation of the position, 9 of
the velocity, 10 and 11 the mean squares of the two, 12 the weights."""

FLOOR = 1e-26
"""Added to mean squares before their logarithm, rad^2: far below any measured noise."""


class Kernels(NamedTuple):
    """Compiled functions; see `load`."""

    steady_step: Any
    weighted_mean: Any
    add_correction: Any
    roughness: Any
    judge_velocity: Any


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

    from . import velocity_evidence_loops

    @njit(cache=cache, error_model='numpy')
    def weigh(new, table, velocity_table, span):  # type: ignore[no-untyped-def]
        """Write new weights to the record: the likelihoods, over their sum for each joint."""
        filters, joints = new.shape[1], new.shape[2]
        measured = velocity_table.shape[0] > 0
        for j in range(joints):
            best = math.inf
            for m in range(filters):
                score = math.log(new[10, m, j] + FLOOR) + table[5, m, j]
                if measured and velocity_table[5, m, j] > 0.0:
                    score += math.log(new[11, m, j] + FLOOR)
                new[12, m, j] = score
                best = min(best, score)
            total = 0.0
            for m in range(filters):
                w = math.exp(-0.5 * span * (new[12, m, j] - best))
                new[12, m, j] = w
                total += w
            for m in range(filters):
                new[12, m, j] /= total

    @njit(cache=cache, error_model='numpy', fastmath={'contract'})
    def steady_step(  # type: ignore[no-untyped-def]
            old, new, state, table, velocity_table, position, velocity, r, forget, span, unit):
        """
        Do what `SteadySteps` does in a step; tables hold gains, precision, constants.

        The weights are renewed if `span` > 0. `unit` is the time unit of scaled states; `state`
        receives the weighted mean, not scaled.
        """
        filters, joints = new.shape[1], new.shape[2]
        size = filters * joints
        keep = 1.0 - forget
        x, y = old.reshape((ROWS, size)), new.reshape((ROWS, size))
        gains = table.reshape((6, size))
        for i in range(size):
            y[3, i] = x[7, i]
            y[2, i] = x[6, i] + 3.0 * r * x[7, i]
            y[1, i] = x[5, i] + r * (2.0 * x[6, i] + 3.0 * r * x[7, i])
            y[0, i] = x[4, i] + r * (x[5, i] + r * (x[6, i] + r * x[7, i]))
        for m in range(filters):
            for j in range(joints):
                new[8, m, j] = position[j] - new[0, m, j]
        for i in range(size):
            e = y[8, i]
            y[4, i] = y[0, i] + gains[0, i] * e
            y[5, i] = y[1, i] + gains[1, i] * e
            y[6, i] = y[2, i] + gains[2, i] * e
            y[7, i] = y[3, i] + gains[3, i] * e
            y[10, i] = keep * x[10, i] + forget * gains[4, i] * e * e
        y[11:] = x[11:]
        if velocity_table.shape[0]:
            gains = velocity_table.reshape((6, size))
            for m in range(filters):
                for j in range(joints):
                    new[9, m, j] = velocity[j] * unit - new[5, m, j]
            for i in range(size):
                e = y[9, i]
                y[4, i] += gains[0, i] * e
                y[5, i] += gains[1, i] * e
                y[6, i] += gains[2, i] * e
                y[7, i] += gains[3, i] * e
                y[11, i] = keep * x[11, i] + forget * gains[4, i] * e * e
        if span > 0.0:
            weigh(new, table, velocity_table, span)
        for j in range(joints):
            a0, a1, a2, a3 = 0.0, 0.0, 0.0, 0.0
            for m in range(filters):
                w = new[12, m, j]
                a0 += w * new[4, m, j]
                a1 += w * new[5, m, j]
                a2 += w * new[6, m, j]
                a3 += w * new[7, m, j]
            state[0, j], state[1, j] = a0, a1 / unit
            state[2, j], state[3, j] = a2 * 2.0 / unit**2, a3 * 6.0 / unit**3

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

    @njit(cache=cache, error_model='numpy')
    def roughness(stamps, positions):  # type: ignore[no-untyped-def]
        """Do what `sampling_clock.roughness` does."""
        samples, joints = positions.shape
        moving = 0
        for j in range(joints):
            for i in range(1, samples):
                if positions[i, j] != positions[0, j]:
                    moving += 1
                    break
        c = np.empty(5)
        noise = np.zeros(2)
        for s in range(2):
            for w in range(samples - 4):
                norm = 0.0
                for i in range(5):
                    product = 1.0
                    for k in range(5):
                        if k != i:
                            product *= stamps[s, w + i] - stamps[s, w + k]
                    c[i] = 1.0 / product
                    norm += c[i] * c[i]
                for j in range(joints):
                    d = 0.0
                    for i in range(1, 5):
                        d += c[i] * (positions[w + i, j] - positions[w, j])
                    noise[s] += d * d / norm
        if moving:
            noise /= moving * (samples - 4)
        return noise, moving

    judge_velocity = njit(cache=cache, error_model='numpy')(velocity_evidence_loops.judge)
    return Kernels(steady_step, weighted_mean, add_correction, roughness, judge_velocity)
