# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What a recorded velocity adds to a smoothed position, as far as it proves right."""

from __future__ import annotations

import numpy as np

from .joint_motion import Array

AROUND = 0.2
"""How far to either side both accelerations are compared, s."""

LONGEST_LAG, LARGEST_SCALE = 0.05, 0.1
"""Lag, s, and share by which a velocity may be too large, that are allowed for."""

AGO, WORST = 0.03, (2.0 * np.pi * 20.0)**4 / 4.0
"""Time over which the way that a velocity makes is compared with the position's, s, and what
that tells of accelerations, up to 20 Hz."""

CLEAR = 3.0
"""Deviations from which on a lag or a scale is none by chance."""

EARLY_LAG, LATE_LAG = 1e-3, 5e-3
"""Lag from which on a velocity is doubted, and by how much more fully, s."""

SAME_ENCODER = 4.0
"""By how much the variance of a velocity counts more, as its errors are not independent of the
position's: drivers find it from the same encoder."""

BEST = 0.01
"""Least variance that a velocity's acceleration is said to have, by that of the position's: one
without noise, in other units or of commands, would else seem certain whatever contradicts it."""


def telling(times: Array, x: Array, position: Array, velocity: Array) -> Array | None:
    """Return a joint's velocity, without gaps, if it tells more than the smoothed position."""
    measured = np.abs(velocity) < 1e6
    if measured.mean() < 0.8 or not np.ptp(velocity[measured]):     # zero, or the commanded one
        return None
    velocity = np.where(measured, velocity, x[1])
    back = velocity[1:] * np.diff(times) - np.diff(position)
    noise = np.mean(np.diff(position, 4)**2) / 70.0 if len(position) > 4 else 0.0
    return None if np.mean(back**2) < 0.01 * noise else velocity    # merely differenced


def fused(times: Array, x: Array, p: Array, position: Array, velocity: Array, y: Array, s: Array,
          ) -> tuple[Array, Array]:
    """
    Return a joint's state and variance, shapes (4, N), with its velocity taken into account.

    Lag and scale are found by regression on the smoothed motion; the velocity, smoothed by the
    same filters to y of variance s, gives another acceleration; both are averaged by their
    variances, that of the velocity raised by what disagrees, and by how alike the errors of
    neighbours are.
    """
    off = velocity - x[1]
    regressors = np.stack([-x[2], x[1]])
    gram = regressors @ regressors.T + np.diag([1e-9, 1e-7]) * len(times)
    found = np.linalg.solve(gram, regressors @ off)
    unsure = np.sqrt(np.mean((off - found @ regressors)**2) * np.diag(np.linalg.inv(gram)))
    lag, scale = np.where(np.abs(found) > CLEAR * unsure, found, 0.0).tolist()
    lag = min(max(lag, 0.0), LONGEST_LAG)
    scale = min(max(scale, -LARGEST_SCALE), LARGEST_SCALE)
    left = off + lag * x[2] - scale * x[1]
    at = np.clip(np.searchsorted(times, times + lag), 0, len(times) - 1)
    h = times + lag - times[at]
    rate = (y[0, at] + h * (y[1, at] + h / 2 * (y[2, at] + h / 3 * y[3, at]))) / (1 + scale)
    acceleration = (y[1, at] + h * (y[2, at] + h / 2 * y[3, at])) / (1 + scale)
    apart = (acceleration - x[2])**2
    spread = np.maximum(
        SAME_ENCODER * s[1, at] / (1 + scale)**2 * _alike(left, float(np.median(p[1]))),
        BEST * p[2])
    misfit = np.maximum(
        _mean_around(times, apart / (p[2] + spread)),
        _mean_around(times, (rate - x[1])**2 / (p[1] + s[0, at])))
    late = min(1.0, max(0.0, (lag - EARLY_LAG) / LATE_LAG))
    excess = spread * (np.maximum(1.0, misfit)**2 - 1.0)
    hidden = _hidden(times, position, x[1] + left, x[2])
    spread = spread + np.minimum(excess, hidden) + late * apart
    weight = p[2] / (p[2] + spread)
    x, p = x.copy(), p.copy()
    x[2] += weight * (acceleration - x[2])
    x[1] += weight * (rate - x[1])
    p[2] *= 1.0 - weight
    p[1] *= 1.0 - weight
    return x, p


def _alike(left: Array, known: float) -> float:
    """
    Return by how much the variance of a mean is larger than of as many independent errors.

    They are a process of first order, beside what is `known` to be the position's part of them.
    """
    # Sums, not means: their quotient is below 1 however slow the errors are.
    alike = max(0.0, float(left[1:] @ left[:-1]) - known * len(left)) / float(left @ left)
    return (1.0 + alike) / (1.0 - alike)


def _hidden(times: Array, position: Array, velocity: Array, acceleration: Array) -> float:
    """Return how far off a velocity's acceleration may be, squared, by how far off its way is."""
    dt = np.diff(times)
    steps = dt * (velocity[1:] + velocity[:-1]) / 2.0 - dt**2 * np.diff(acceleration) / 12.0
    apart = np.append(0.0, np.cumsum(steps)) - position
    apart = apart - apart[np.searchsorted(times, times - AGO)]
    return WORST * float(np.mean(apart**2))


def _mean_around(times: Array, values: Array) -> Array:
    """Return the means of values within `AROUND` of each time."""
    total = np.append(0.0, np.cumsum(values))
    first = np.searchsorted(times, times - AROUND)
    last = np.searchsorted(times, times + AROUND, side='right')
    return (total[last] - total[first]) / (last - first)  # type: ignore[no-any-return]
