# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What a block of samples tells about the velocity field: the arithmetic of `VelocityTrust`."""

from __future__ import annotations

from functools import lru_cache
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .divided_difference import divided_difference
from .joint_motion import Array
from .wiener_process import TIME_UNIT

NEIGHBOURS = 11
"""Samples before a block that are needed to judge it."""

NOISE_MEMORY = 0.5
"""Memory of the noise estimates, s."""

BIAS_MEMORY = 0.1
"""Memory of the integral of velocity against position, s."""

RELEASE = 5.0
"""Time in which a velocity that disagreed wins back trust, s."""

COHERENT_LIMIT = 10.0
"""A coherent disagreement beyond this multiple of the white noise: not used."""

WORST = 1e6
"""Largest disagreement that is remembered, as a multiple of the white noise."""

REPETITION_LIMIT, LEAST_SHARE = 0.5, 0.15
"""Correlation of the velocity with the noise of differenced positions beyond which velocity
brings no news; and the least share of the velocity's noise for that."""

TELLING_LAG = 3e-3
"""A velocity is used when it would have shown if it were as late as this, s."""

FEW = 24
"""Windows of five from which noise is not yet known."""

OUTLIER = 10.0
"""A block noisier than usual by this factor in variance counts less: it is a jerk, not noise."""

SMALLEST = 1e-20
"""Variance of the rounding of stamps to ns at common speeds (rad^2, and rad^2/s^2)."""

LEAST_RATIO = 1.0
"""A velocity (rad/s) is never taken for more certain than the position (rad), in variance."""

CHANGE = 2.5
"""The ratio of variances is left as it is while the new ones are within this factor."""

# Rows of the state; one column for each joint.
(POSITION_NOISE, VELOCITY_NOISE, TYPICAL_POSITION, TYPICAL_VELOCITY, REPETITION, WINDOWS, MOVED,
 INTEGRAL, TRAVEL, JERK, BIAS, POWER, DISAGREEMENT, EARNED, LAGGING, DIFFERENCED, RATIO,
 ) = range(17)
ROWS = 17
OF_A_RUN = [INTEGRAL, TRAVEL, JERK, BIAS, POWER, LAGGING, DIFFERENCED]


def judge(t: Array, q: Array, v: Array, old: Array, blocks: int) -> tuple[Array, bool]:
    """
    Judge a block of samples.

    Parameters
    ----------
    t: shape (N,)
        Stamps; the first `NEIGHBOURS` samples were judged before.
    q, v: shape (N, n)
        Positions and velocities, NaN where not measured.
    old: shape (ROWS, n)
        What is known, by rows: mean squares of the noise of position and of velocity; the same
        without outliers; mean correlation of the velocity's noise with that of velocity minus
        differenced position; number of windows behind these. Whether a velocity was ever
        non-zero. Leaky integrals of velocity minus position step and of velocity; what jumps of
        the acceleration add to the square of the first; mean square of the first, and of what it
        would be if the velocity were late; its excess as a multiple of the velocity's noise.
        Whether the velocity has proved right, disagrees, is differenced from positions. Ratio
        of variances in use, scaled.
    blocks:
        Number of blocks judged before in this run.

    Returns
    -------
    What is known now, and whether the ratios in use have changed.

    """
    new = old.copy()
    block = _measure(t, q, v)
    new[MOVED] = np.maximum(old[MOVED], (np.abs(v) > 0.0).any(axis=0))
    _take_noise(new, old, block)
    period = (t[-1] - t[0]) / (len(t) - 1)
    travelled = old[TRAVEL] if blocks else BIAS_MEMORY * v[NEIGHBOURS - 3]
    _take_bias(new, old, block, blocks, period, travelled, v[-3])
    return new, _conclude(new, old[RATIO])


def _take_noise(new: Array, old: Array, block: _Block) -> None:
    """Move the means of the noise, that forget; at first plain means."""
    count, squares = block.windows, block.squares
    new[WINDOWS] += count
    gain = (count > 0.0) * np.maximum(
        1.0 - math.exp(-block.span / NOISE_MEMORY), count / np.maximum(new[WINDOWS], 1.0))
    mean = squares[:2] / np.maximum(count, 1.0)
    new[:2] += gain * (mean - old[:2])
    repeats = (block.covariance < -LEAST_SHARE * squares[1]) & (mean[0] > SMALLEST)
    correlation = block.covariance / np.sqrt(squares[1] * squares[2] + 1e-200)
    new[REPETITION] += gain * (repeats * correlation - old[REPETITION])
    usual = np.where(old[WINDOWS] > 0.0, OUTLIER * old[2:4], np.inf)
    gain *= np.minimum(1.0, (usual / np.maximum(mean, 1e-60)).min(axis=0))
    new[2:4] += gain * (mean - old[2:4])


def _take_bias(
    new: Array, old: Array, block: _Block, blocks: int, period: float, travelled: Array,
    velocity: Array,
) -> None:
    """Compare velocity minus position step over `BIAS_MEMORY` with what noise would do."""
    leak = math.exp(-block.span / BIAS_MEMORY)
    finite = np.isfinite(block.wrong)
    new[INTEGRAL] = np.where(finite, leak * old[INTEGRAL] + block.wrong, 0.0)
    new[TRAVEL] = np.where(finite, leak * travelled + block.travel, BIAS_MEMORY * velocity)
    # Where the acceleration jumps, a few intervals are wrong whatever the velocity.
    noise = 2.0 * new[TYPICAL_POSITION] + period**2 * new[TYPICAL_VELOCITY]
    new[JERK] = leak * leak * old[JERK] + np.where(
        finite & (block.largest > OUTLIER * noise), 9.0 * block.largest, 0.0)
    gain = max(0.5 * (1.0 - leak), 1.0 / (blocks + 1))
    lag = TELLING_LAG * (velocity - new[TRAVEL] / BIAS_MEMORY)
    for row, square in (
            (BIAS, new[INTEGRAL]**2 - new[JERK]), (POWER, lag * lag - 10.0 * new[JERK])):
        new[row] += gain * np.where(
            finite & np.isfinite(square), square / BIAS_MEMORY**2 - old[row], 0.0)
    # What the noise makes of the bias, with a margin for the number of samples behind the means.
    white = period / (2.0 * BIAS_MEMORY)
    allowed = 1.5 * white * new[VELOCITY_NOISE] + new[POSITION_NOISE] / BIAS_MEMORY**2 * (
        1.0 + 8.0 * math.sqrt(gain)) * (1.0 + 30.0 / np.maximum(new[WINDOWS], 1.0))
    scale = 1.0 / (white * (new[VELOCITY_NOISE] + 1e-18))
    known = new[WINDOWS] >= FEW
    # Distrust at once, trust again slowly, and only when a late velocity would have shown.
    faded = math.exp(-block.span / RELEASE) * old[DISAGREEMENT]
    new[DISAGREEMENT] = np.minimum(WORST, np.maximum(
        known * (new[BIAS] - allowed) * scale, faded))
    new[EARNED] = known & (new[DISAGREEMENT] < COHERENT_LIMIT) & (
        (old[EARNED] > 0.0) | ((new[POWER] - allowed) * scale > COHERENT_LIMIT))


class _Block(NamedTuple):
    """What a block of samples adds, for each of n joints."""

    windows: Array
    """Windows of seven samples in which the joint moved."""

    squares: Array
    """Sums over these of the squared noise of position, velocity and difference, shape (3, n);
    the difference is velocity minus position step."""

    covariance: Array
    """Sum over them of the products of the last two."""

    wrong: Array
    """Leaky sum of the differences, times time."""

    largest: Array
    """The largest of these, squared."""

    travel: Array
    """Leaky integral of the velocity."""

    span: float
    """Length of the block, s."""


@lru_cache(maxsize=2 * 64)
def _windows(fresh: int) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    """Return every other window of seven: rows of a matrix, columns, and which steps it sees."""
    row = np.arange((fresh + 1) // 2)[:, None]
    column = 2 * row + (fresh - 1) % 2 + np.arange(7)
    steps = np.zeros((len(row), fresh + 6))
    steps[row, column[:, 1:]] = 1.0
    return row, column, steps


def _measure(t: Array, q: Array, v: Array) -> _Block:
    """Return what the samples after the first `NEIGHBOURS` add."""
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
    return _Block(
        good.sum(axis=0).astype(float), (d * d).sum(axis=0), (d[:, 1] * d[:, 2]).sum(axis=0),
        fading.dot(wrong), (wrong * wrong).max(axis=0), fading.dot((mean * middle)[-fresh:]),
        float(ends[-1] - t[-3 - fresh]))


def _conclude(new: Array, used: Array) -> bool:
    """Fill in the verdicts; return whether the ratios in use have changed."""
    new[LAGGING] = new[DISAGREEMENT] > COHERENT_LIMIT
    new[DIFFERENCED] = new[REPETITION] < -REPETITION_LIMIT
    ratio = (new[TYPICAL_VELOCITY] + SMALLEST) / (new[TYPICAL_POSITION] + SMALLEST) * (
        1.0 + new[DISAGREEMENT])
    ratio = np.maximum(ratio, LEAST_RATIO)
    useless = (new[EARNED] == 0.0) | (new[DIFFERENCED] > 0.0) | (ratio > 1e10)
    useless |= new[POSITION_NOISE] <= 0.0
    ratio = np.where(useless, np.inf, ratio * TIME_UNIT**2)
    # As inverses, so that the infinite ones compare.
    a, b = 1.0 / ratio, 1.0 / used
    if ((a <= CHANGE * b) & (b <= CHANGE * a)).all():
        return False
    new[RATIO] = ratio
    return True
