# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The estimators compared, and how each is run on a recording."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import perf_counter
from typing import Any, NamedTuple

from benchmark.estimation.conditions import Condition, Recording
import numpy as np

from screw_kinematics.motion import (
    FiniteDifferences, FixedKalmanFilter, MotionEstimator, SavitzkyGolay, smooth)

CUTOFFS = (2.0, 3.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 50.0)
"""Cutoffs of the low-pass tried for each cell with knowledge of the truth, Hz."""

USUAL = 'finite differences + 10 Hz'
BEST_CUTOFF = 'finite differences, best cutoff'
SMOOTHER = 'smoother (recorded data)'

ONLINE: dict[str, Callable[[int], object]] = {
    'Savitzky-Golay, causal': lambda n: SavitzkyGolay(n, delay=0.0, window=0.1, order=3),
    'Savitzky-Golay, 30 ms': lambda n: SavitzkyGolay(n),
    'one Kalman filter': lambda n: FixedKalmanFilter(n),
    'bank, position only': lambda n: MotionEstimator(n, velocity='position-only'),
    **{f'bank, {delay} ms': partial(MotionEstimator, delay=1e-3 * delay)
       for delay in (0, 10, 20, 50)},
}


class Result(NamedTuple):
    """Estimates at claimed instants t; how far those lie `behind` (s); us per sample."""

    t: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    behind: float
    cost: float


def feed(estimator: Any, stamps: np.ndarray, positions: np.ndarray,
         velocities: np.ndarray | None) -> Result:
    """Run an estimator sample by sample."""
    rows, cost, behind = [], [], []
    for k, stamp in enumerate(stamps.tolist()):
        begin = perf_counter()
        velocity = None if velocities is None else velocities[k]
        motion = estimator.update(stamp, positions[k], velocity)
        cost.append(perf_counter() - begin)
        if motion is not None:
            rows.append((motion.stamp, motion.velocity, motion.acceleration))
            behind.append(stamp - motion.stamp)
    t, v, a = (np.array(column) for column in zip(*rows))
    return Result(t, v, a, float(np.median(behind)), 1e6 * float(np.median(cost)))


def run_usual(recording: Recording, condition: Condition, cutoff: float = 10.0) -> Result:
    """Run today's usual practice; it is given samples in order and spared false velocities."""
    stamps, positions, velocities = recording.ordered
    if not isinstance(condition.velocity, float):
        velocities = None
    estimator = FiniteDifferences(positions.shape[1], cutoff=cutoff)
    return feed(estimator, stamps, positions, velocities)


def run_online(name: str, recording: Recording) -> Result:
    """Run one of `ONLINE` on the samples as they arrive."""
    return feed(ONLINE[name](recording.positions.shape[1]),
                recording.stamps, recording.positions, recording.velocities)


def run_smoother(recording: Recording) -> Result:
    """Run the smoother on the whole recording."""
    begin = perf_counter()
    motion = smooth(recording.stamps, recording.positions, recording.velocities)
    cost = 1e6 * (perf_counter() - begin) / len(motion.stamps)
    return Result(motion.stamps, motion.velocity, motion.acceleration, float('inf'), cost)
