# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""`velocity_evidence.judge` as plain loops: what Numba compiles."""

from __future__ import annotations

import math

import numpy as np

from .joint_motion import Array
from .velocity_evidence import (
    BIAS, BIAS_MEMORY, CHANGE, COHERENT_LIMIT, DIFFERENCED, DISAGREEMENT, EARNED, FEW, INTEGRAL,
    JERK, LAGGING, LEAST_RATIO, LEAST_SHARE, MOVED, NEIGHBOURS, NOISE_MEMORY, OUTLIER,
    POSITION_NOISE, POWER, RATIO, RELEASE, REPETITION, REPETITION_LIMIT, SMALLEST, TELLING_LAG,
    TRAVEL, TYPICAL_POSITION, TYPICAL_VELOCITY, VELOCITY_NOISE, WINDOWS, WORST)
from .wiener_process import TIME_UNIT


def judge(t: Array, q: Array, v: Array, old: Array, blocks: int) -> tuple[Array, bool]:
    """Do what `velocity_evidence.judge` does."""
    samples, joints = q.shape
    fresh, rows = samples - NEIGHBOURS, samples - 5
    new = old.copy()

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

    span = t[samples - 3] - t[samples - 3 - fresh]
    period = (t[samples - 1] - t[0]) / (samples - 1)
    forget = 1.0 - math.exp(-span / NOISE_MEMORY)
    leak = math.exp(-span / BIAS_MEMORY)
    release = math.exp(-span / RELEASE)
    white = period / (2.0 * BIAS_MEMORY)
    gain_of_bias = max(0.5 * (1.0 - leak), 1.0 / (blocks + 1))
    margin = (1.0 + 8.0 * math.sqrt(gain_of_bias)) / BIAS_MEMORY**2
    slopes = np.empty((4, samples))
    mean, step = np.empty(rows), np.empty(rows)
    changed = False
    for j in range(joints):
        for k in range(samples):
            if abs(v[k, j]) > 0.0:
                new[MOVED, j] = 1.0
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

        new[WINDOWS, j] += seen
        if seen > 0.0:
            gain = max(forget, seen / new[WINDOWS, j])
            correlation = 0.0
            if covariance < -LEAST_SHARE * noise_v and noise_q > SMALLEST * seen:
                correlation = covariance / math.sqrt(noise_v * noise_d + 1e-200)
            noise_q /= seen
            noise_v /= seen
            new[POSITION_NOISE, j] += gain * (noise_q - old[POSITION_NOISE, j])
            new[VELOCITY_NOISE, j] += gain * (noise_v - old[VELOCITY_NOISE, j])
            new[REPETITION, j] += gain * (correlation - old[REPETITION, j])
            if old[WINDOWS, j] > 0.0:
                gain *= min(1.0, OUTLIER * old[TYPICAL_POSITION, j] / max(noise_q, 1e-60),
                            OUTLIER * old[TYPICAL_VELOCITY, j] / max(noise_v, 1e-60))
            new[TYPICAL_POSITION, j] += gain * (noise_q - old[TYPICAL_POSITION, j])
            new[TYPICAL_VELOCITY, j] += gain * (noise_v - old[TYPICAL_VELOCITY, j])

        if math.isfinite(wrong):
            velocity = v[samples - 3, j]
            new[INTEGRAL, j] = leak * old[INTEGRAL, j] + wrong
            travelled = old[TRAVEL, j] if blocks else BIAS_MEMORY * v[NEIGHBOURS - 3, j]
            new[TRAVEL, j] = leak * travelled + travel
            jerk = leak * leak * old[JERK, j]
            if largest > OUTLIER * (2.0 * new[TYPICAL_POSITION, j]
                                    + period**2 * new[TYPICAL_VELOCITY, j]):
                jerk += 9.0 * largest
            new[JERK, j] = jerk
            lag = TELLING_LAG * (velocity - new[TRAVEL, j] / BIAS_MEMORY)
            new[BIAS, j] += gain_of_bias * (
                (new[INTEGRAL, j]**2 - jerk) / BIAS_MEMORY**2 - old[BIAS, j])
            power = (lag * lag - 10.0 * jerk) / BIAS_MEMORY**2
            if math.isfinite(power):
                new[POWER, j] += gain_of_bias * (power - old[POWER, j])
        else:
            new[INTEGRAL, j] = 0.0
            new[TRAVEL, j] = BIAS_MEMORY * v[samples - 3, j]
            new[JERK, j] = leak * leak * old[JERK, j]
        noise = new[VELOCITY_NOISE, j]
        allowed = 1.5 * white * noise + margin * new[POSITION_NOISE, j] * (
            1.0 + 30.0 / max(new[WINDOWS, j], 1.0))
        scale = 1.0 / (white * (noise + 1e-18))
        known = new[WINDOWS, j] >= FEW
        disagreement = release * old[DISAGREEMENT, j]
        if known:
            disagreement = max(disagreement, (new[BIAS, j] - allowed) * scale)
        new[DISAGREEMENT, j] = disagreement = min(WORST, disagreement)
        earned = known and disagreement < COHERENT_LIMIT and (
            old[EARNED, j] > 0.0 or (new[POWER, j] - allowed) * scale > COHERENT_LIMIT)

        new[EARNED, j] = 1.0 if earned else 0.0
        new[LAGGING, j] = 1.0 if disagreement > COHERENT_LIMIT else 0.0
        new[DIFFERENCED, j] = 1.0 if new[REPETITION, j] < -REPETITION_LIMIT else 0.0
        ratio = max(LEAST_RATIO, (1.0 + disagreement) * (new[TYPICAL_VELOCITY, j] + SMALLEST)
                    / (new[TYPICAL_POSITION, j] + SMALLEST))
        if (not earned or new[DIFFERENCED, j] > 0.0 or ratio > 1e10
                or new[POSITION_NOISE, j] <= 0.0):
            ratio = math.inf
        new[RATIO, j] = ratio * TIME_UNIT**2
        a, b = 1.0 / new[RATIO, j], 1.0 / old[RATIO, j]
        changed = changed or not (a <= CHANGE * b and b <= CHANGE * a)
    if not changed:
        for j in range(joints):
            new[RATIO, j] = old[RATIO, j]
    return new, changed
