# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What a block of samples shows of the noise of position and velocity, and of their difference."""

from __future__ import annotations

from functools import lru_cache
import math

import numpy as np
from numpy.typing import NDArray

from .divided_difference import divided_difference
from .joint_motion import Array

NEIGHBOURS = 11
"""Samples before a block that are needed to judge it."""

BIAS_MEMORY = 0.1
"""Memory of the integral of velocity against position, s."""

# Rows of what a block of samples adds; one column for each joint.
(SEEN,          # windows of seven samples in which the joint moved
 SQUARES_POSITION, SQUARES_VELOCITY, SQUARES_DIFFERENCE,    # sums over these of squared noise; the
 COVARIANCE,    # difference is velocity minus position step; sum of its products with the velocity
 WRONG,         # leaky sum of the differences, times time
 LARGEST,       # the largest of these, squared
 TRAVELLED,     # leaky integral of the velocity
 NONZERO,       # 1 if the velocity was ever non-zero, else 0
 FIRST, LAST,   # velocity before the block, and at its end
 BLOCK_ROWS) = range(12)


@lru_cache(maxsize=2 * 64)
def _windows(fresh: int) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    """Return every other window of seven: rows of a matrix, columns, and which steps it sees."""
    row = np.arange((fresh + 1) // 2)[:, None]
    column = 2 * row + (fresh - 1) % 2 + np.arange(7)
    steps = np.zeros((len(row), fresh + 6))
    steps[row, column[:, 1:]] = 1.0
    return row, column, steps


def measure(t: Array, q: Array, v: Array) -> Array:
    """Return what the samples after the first `NEIGHBOURS` add, shape (BLOCK_ROWS, n)."""
    fresh = len(t) - NEIGHBOURS
    h = (t[1:] - t[:-1])[:, None]
    two = h[1:] + h[:-1]
    three = two[1:] + h[:-2]
    first = (v[1:] - v[:-1]) / h
    second = (first[1:] - first[:-1]) / two
    third = (second[1:] - second[:-1]) / three
    fourth = (third[1:] - third[:-1]) / (three[1:] + h[:-3])
    # Mean over an interval of the polynomial through the velocities at six samples around it.
    before, middle, after = h[1:-3], h[2:-2], h[3:-1]
    weight = (2.0 * before * (middle + after) - middle * (before - after)
              + 0.4 * middle * middle) / 24.0
    mean = 0.5 * (v[2:-3] + v[3:-2]) - middle * middle * (
        second[1:-2] / 6.0 + (middle + 2.0 * before) / 12.0 * third[1:-1]
        - weight * (fourth[1:] + fourth[:-1]))
    step = q[3:-2] - q[2:-3]
    wrong = mean * middle - step

    row, column, steps = _windows(fresh)
    bands = np.zeros(steps.shape)
    bands[row, column] = divided_difference(t[3 + column])
    x = np.concatenate([q[3:-2] - q[-1], v[3:-2], wrong / middle], axis=1)
    d = bands.dot(x)
    if not math.isfinite(d.sum()):
        missing = np.isnan(x)
        d = bands.dot(np.where(missing, 0.0, x))
        d[(bands != 0.0).dot(missing)] = np.nan
    d = d.reshape(len(d), 3, -1)
    good = (steps.dot(np.abs(step)) > 0.0) & np.isfinite(d[:, 2])
    d = np.where(good[:, None], d, 0.0)

    ends = t[-2 - fresh:-2]
    fading = np.exp((ends - ends[-1]) / BIAS_MEMORY)
    wrong = wrong[-fresh:]
    block = np.empty((BLOCK_ROWS, q.shape[1]))
    block[SEEN] = good.sum(axis=0)
    block[SQUARES_POSITION:COVARIANCE] = (d * d).sum(axis=0)
    block[COVARIANCE] = (d[:, 1] * d[:, 2]).sum(axis=0)
    block[WRONG] = fading.dot(wrong)
    block[LARGEST] = np.fmax.reduce(wrong * wrong, axis=0, initial=0.0)
    block[TRAVELLED] = fading.dot((mean * middle)[-fresh:])
    block[NONZERO] = (np.abs(v) > 0.0).any(axis=0)
    block[FIRST], block[LAST] = v[NEIGHBOURS - 3], v[-3]
    return block
