# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What blocks of samples tell about the velocity field: the arithmetic of `VelocityTrust`."""

from __future__ import annotations

from collections.abc import MutableSequence, Sequence
import math

import numpy as np

from .joint_motion import Array
from .velocity_block import (
    BIAS_MEMORY, COVARIANCE, FIRST, LARGEST, LAST, measure, NEIGHBOURS, NONZERO, SEEN,
    SQUARES_DIFFERENCE, SQUARES_POSITION, SQUARES_VELOCITY, TRAVELLED, WRONG)
from .wiener_process import TIME_UNIT

NOISE_MEMORY = 0.5
"""Memory of the noise estimates, s."""

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
    memories = forgetting(t, blocks)
    known = old.T.tolist()
    ratios = [weigh(of_joint, block, memories)
              for of_joint, block in zip(known, measure(t, q, v).T.tolist())]
    changed = any(differ(ratio, of_joint[RATIO]) for ratio, of_joint in zip(ratios, known))
    new = np.array(known).T
    if changed:
        new[RATIO] = ratios
    return new, changed


# The following three are written for lists, and for arrays in machine code.


def forgetting(t: Array, blocks: int) -> tuple[float, float, float, float, float, bool]:
    """
    Return what the length of a block of samples makes of the means.

    Returns
    -------
    Shares that means of the noise take of new ones, that integrals keep, that disagreement
    keeps; share that means of the integrals take; sampling period, s; and whether it is the
    first block of a run.

    """
    fresh = len(t) - NEIGHBOURS
    span = float(t[len(t) - 3] - t[len(t) - 3 - fresh])
    leak = math.exp(-span / BIAS_MEMORY)
    period = float(t[len(t) - 1] - t[0]) / (len(t) - 1)
    return (1.0 - math.exp(-span / NOISE_MEMORY), leak, math.exp(-span / RELEASE),
            max(0.5 * (1.0 - leak), 1.0 / (blocks + 1)), period, blocks == 0)


def weigh(known: MutableSequence[float], block: Sequence[float],
          memories: tuple[float, float, float, float, float, bool]) -> float:
    """
    Move what is known of a joint, a column of the state, by what a block of samples adds.

    Returns
    -------
    The ratio of variances that would now be right, scaled; the one in use stays.

    """
    forget, leak, release, gain_of_bias, period, first = memories
    if block[NONZERO] > 0.0:
        known[MOVED] = 1.0
    seen, covariance = block[SEEN], block[COVARIANCE]
    had_noise = known[WINDOWS] > 0.0
    known[WINDOWS] += seen
    if seen > 0.0:
        # Means that forget; at first plain means.
        gain = max(forget, seen / known[WINDOWS])
        noise_q, noise_v = block[SQUARES_POSITION] / seen, block[SQUARES_VELOCITY] / seen
        correlation = 0.0
        if covariance < -LEAST_SHARE * block[SQUARES_VELOCITY] and noise_q > SMALLEST:
            correlation = covariance / math.sqrt(
                block[SQUARES_VELOCITY] * block[SQUARES_DIFFERENCE] + 1e-200)
        known[POSITION_NOISE] += gain * (noise_q - known[POSITION_NOISE])
        known[VELOCITY_NOISE] += gain * (noise_v - known[VELOCITY_NOISE])
        known[REPETITION] += gain * (correlation - known[REPETITION])
        if had_noise:
            gain *= min(1.0, OUTLIER * known[TYPICAL_POSITION] / max(noise_q, 1e-60),
                        OUTLIER * known[TYPICAL_VELOCITY] / max(noise_v, 1e-60))
        known[TYPICAL_POSITION] += gain * (noise_q - known[TYPICAL_POSITION])
        known[TYPICAL_VELOCITY] += gain * (noise_v - known[TYPICAL_VELOCITY])

    # Velocity minus position step over `BIAS_MEMORY`, against what noise would do.
    jerk = leak * leak * known[JERK]
    if math.isfinite(block[WRONG]):
        known[INTEGRAL] = integral = leak * known[INTEGRAL] + block[WRONG]
        travel = BIAS_MEMORY * block[FIRST] if first else known[TRAVEL]
        known[TRAVEL] = travel = leak * travel + block[TRAVELLED]
        # Where the acceleration jumps, a few intervals are wrong whatever the velocity.
        if block[LARGEST] > OUTLIER * (2.0 * known[TYPICAL_POSITION]
                                       + period * period * known[TYPICAL_VELOCITY]):
            jerk += 9.0 * block[LARGEST]
        lag = TELLING_LAG * (block[LAST] - travel / BIAS_MEMORY)
        power = (lag * lag - 10.0 * jerk) / BIAS_MEMORY**2
        known[BIAS] += gain_of_bias * (
            (integral * integral - jerk) / BIAS_MEMORY**2 - known[BIAS])
        if math.isfinite(power):
            known[POWER] += gain_of_bias * (power - known[POWER])
    else:
        known[INTEGRAL] = 0.0
        known[TRAVEL] = BIAS_MEMORY * block[LAST]
    known[JERK] = jerk

    # What the noise makes of the bias, with a margin for the number of samples behind the means.
    white = period / (2.0 * BIAS_MEMORY)
    allowed = 1.5 * white * known[VELOCITY_NOISE] + known[POSITION_NOISE] / BIAS_MEMORY**2 * (
        1.0 + 8.0 * math.sqrt(gain_of_bias)) * (1.0 + 30.0 / max(known[WINDOWS], 1.0))
    scale = 1.0 / (white * (known[VELOCITY_NOISE] + 1e-18))
    enough = known[WINDOWS] >= FEW
    # Distrust at once, trust again slowly, and only when a late velocity would have shown.
    disagreement = release * known[DISAGREEMENT]
    if enough:
        disagreement = max(disagreement, (known[BIAS] - allowed) * scale)
    known[DISAGREEMENT] = disagreement = min(WORST, disagreement)
    earned = enough and disagreement < COHERENT_LIMIT and (
        known[EARNED] > 0.0 or (known[POWER] - allowed) * scale > COHERENT_LIMIT)
    repeats = known[REPETITION] < -REPETITION_LIMIT
    known[EARNED] = 1.0 if earned else 0.0
    known[LAGGING] = 1.0 if disagreement > COHERENT_LIMIT else 0.0
    known[DIFFERENCED] = 1.0 if repeats else 0.0
    ratio = max(LEAST_RATIO, (known[TYPICAL_VELOCITY] + SMALLEST) * (1.0 + disagreement)
                / (known[TYPICAL_POSITION] + SMALLEST))
    if not earned or repeats or ratio > 1e10 or known[POSITION_NOISE] <= 0.0:
        return math.inf
    return ratio * TIME_UNIT**2


def differ(ratio: float, used: float) -> bool:
    """Whether a ratio of variances is no longer near the one in use; both may be infinite."""
    a, b = 1.0 / ratio, 1.0 / used
    return not (a <= CHANGE * b and b <= CHANGE * a)
