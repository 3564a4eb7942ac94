# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""`velocity_block.measure` as plain loops: what Numba compiles."""

from __future__ import annotations

import math

import numpy as np

from .joint_motion import Array
from .velocity_block import (
    BIAS_MEMORY, BLOCK_ROWS, COVARIANCE, FIRST, LARGEST, LAST, NEIGHBOURS, NONZERO, SEEN,
    SQUARES_DIFFERENCE, SQUARES_POSITION, SQUARES_VELOCITY, TRAVELLED, WRONG)


def measure(t: Array, q: Array, v: Array) -> Array:
    """Do what `velocity_block.measure` does."""
    samples, joints = q.shape
    fresh, rows = samples - NEIGHBOURS, samples - 5
    block = np.zeros((BLOCK_ROWS, joints))

    # Coefficients of the sixth divided differences; those of the mean over an interval.
    count = (fresh + 1) // 2
    c = np.empty((count, 7))
    for w in range(count):
        begin = 2 * w + (fresh - 1) % 2
        norm = 0.0
        for i in range(7):
            product = 1.0
            for k in range(7):
                if k != i:
                    product *= t[3 + begin + i] - t[3 + begin + k]
            c[w, i] = 1.0 / product
            norm += c[w, i] * c[w, i]
        for i in range(7):
            c[w, i] /= math.sqrt(norm)
    weights = np.empty((rows, 3))
    fading = np.zeros(rows)
    for k in range(rows):
        before, h, after = t[k + 2] - t[k + 1], t[k + 3] - t[k + 2], t[k + 4] - t[k + 3]
        weights[k, 0] = h * h / 6.0
        weights[k, 1] = h * h * (h + 2.0 * before) / 12.0
        weights[k, 2] = h * h * (2.0 * before * (h + after) - h * (before - after)
                                 + 0.4 * h * h) / 24.0
        if k >= rows - fresh:
            fading[k] = math.exp((t[k + 3] - t[samples - 3]) / BIAS_MEMORY)

    slopes = np.empty((4, samples))
    mean, step = np.empty(rows), np.empty(rows)
    for j in range(joints):
        for k in range(samples):
            if abs(v[k, j]) > 0.0:
                block[NONZERO, j] = 1.0
        for k in range(samples - 1):
            slopes[0, k] = (v[k + 1, j] - v[k, j]) / (t[k + 1] - t[k])
        for order in range(1, 4):
            for k in range(samples - 1 - order):
                slopes[order, k] = (slopes[order - 1, k + 1] - slopes[order - 1, k]) / (
                    t[k + 1 + order] - t[k])
        wrong, travel, largest = 0.0, 0.0, 0.0
        for k in range(rows):
            h = t[k + 3] - t[k + 2]
            mean[k] = (0.5 * (v[k + 2, j] + v[k + 3, j]) - weights[k, 0] * slopes[1, k + 1]
                       - weights[k, 1] * slopes[2, k + 1]
                       + weights[k, 2] * (slopes[3, k] + slopes[3, k + 1]))
            step[k] = q[k + 3, j] - q[k + 2, j]
            if k >= rows - fresh:
                e = mean[k] * h - step[k]
                wrong += fading[k] * e
                travel += fading[k] * mean[k] * h
                largest = max(largest, e * e)

        seen = 0.0
        noise_q, noise_v, noise_d, covariance = 0.0, 0.0, 0.0, 0.0
        for w in range(count):
            begin = 2 * w + (fresh - 1) % 2
            moving = False
            dq, dv, dd = 0.0, 0.0, 0.0
            for i in range(7):
                k = begin + i
                moving = moving or (i > 0 and step[k] != 0.0)
                dq += c[w, i] * (q[k + 3, j] - q[samples - 1, j])
                dv += c[w, i] * v[k + 3, j]
                dd += c[w, i] * (mean[k] - step[k] / (t[k + 3] - t[k + 2]))
            if moving and math.isfinite(dd):
                seen += 1.0
                noise_q += dq * dq
                noise_v += dv * dv
                noise_d += dd * dd
                covariance += dv * dd

        block[SEEN, j] = seen
        block[SQUARES_POSITION, j], block[SQUARES_VELOCITY, j] = noise_q, noise_v
        block[SQUARES_DIFFERENCE, j], block[COVARIANCE, j] = noise_d, covariance
        block[WRONG, j], block[LARGEST, j], block[TRAVELLED, j] = wrong, largest, travel
        block[FIRST, j], block[LAST, j] = v[NEIGHBOURS - 3, j], v[samples - 3, j]
    return block
