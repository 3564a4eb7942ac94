# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The estimators compared, and how each is run on samples."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from time import perf_counter
from typing import Any, NamedTuple

from benchmark.estimation import from_papers, peers
from benchmark.estimation.samples import Result, Samples
import numpy as np

from screw_kinematics.motion import (
    FiniteDifferences, FixedKalmanFilter, MotionEstimator, SavitzkyGolay, smooth)

CUTOFFS = (2.0, 3.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 50.0)
"""Cutoffs of low-passes that are tried with knowledge of the truth, Hz."""

BANDWIDTHS = (2.0, 4.0, 8.0, 16.0)
WINDOWS = (0.03, 0.06, 0.1, 0.2, 0.4)

USUAL = 'finite differences + 10 Hz'
BEST_CUTOFF = 'finite differences, best cutoff'
SMOOTHER = 'smoother (recorded data)'


class Candidate(NamedTuple):
    """How an estimator is run on samples, tunings of which the best counts, what it needs."""

    run: Callable[[Samples, Any], Result]
    tunings: tuple[Any, ...] = (None,)
    module: str = ''


def feed(make: Callable[[int], Any], samples: Samples, _: Any = None) -> Result:
    """Run an online estimator sample by sample."""
    estimator = make(samples.positions.shape[1])
    rows, motions, cost = [], [], []
    velocities = samples.velocities
    for k, (stamp, position) in enumerate(zip(samples.stamps.tolist(), samples.positions)):
        begin = perf_counter()
        motion = estimator.update(stamp, position, None if velocities is None else velocities[k])
        cost.append(perf_counter() - begin)
        if motion is not None:
            rows.append(k)
            motions.append(motion)
    t = np.array([motion.stamp for motion in motions])
    state = np.array([motion.state for motion in motions])
    covariance = np.array([motion.covariance for motion in motions])
    return Result(np.array(rows), t, state[:, 1], state[:, 2],
                  float(np.median(samples.stamps[rows] - t)), 1e6 * float(np.median(cost)),
                  np.diagonal(covariance, axis1=2, axis2=3).transpose(0, 2, 1))


def run_usual(samples: Samples, cutoff: float = 10.0) -> Result:
    """Run today's usual practice."""
    return feed(partial(FiniteDifferences, cutoff=cutoff), samples)


def run_smoother(samples: Samples, _: Any = None) -> Result:
    """Run the smoother on the whole recording."""
    begin = perf_counter()
    motion = smooth(samples.stamps, samples.positions, samples.velocities)
    cost = 1e6 * (perf_counter() - begin) / len(motion.stamps)
    return Result(np.flatnonzero(motion.used), motion.stamps, motion.velocity,
                  motion.acceleration, float('inf'), cost, motion.variance)


def _online(make: Callable[[int], Any]) -> Candidate:
    return Candidate(partial(feed, make))


OURS: dict[str, Candidate] = {
    'bank, position only': _online(partial(MotionEstimator, velocity='position-only')),
    **{f'bank, {delay} ms': _online(partial(MotionEstimator, delay=1e-3 * delay))
       for delay in (0, 10, 20, 50)},
    SMOOTHER: Candidate(run_smoother),
}
"""What the package recommends."""

SIMPLE: dict[str, Candidate] = {
    'Savitzky-Golay, causal': _online(partial(SavitzkyGolay, delay=0.0, window=0.1, order=3)),
    'Savitzky-Golay, 30 ms': _online(SavitzkyGolay),
    'one Kalman filter': _online(FixedKalmanFilter),
}
"""What it has beside, for comparison and for those who want to tune."""

PEERS: dict[str, Candidate] = {
    'adaptive window (FOAW)': Candidate(from_papers.adaptive_window, (2.0, 5.0, 15.0)),
    'exact differentiator (RED)': Candidate(from_papers.exact_differentiator, (
        1e2, 1e3, 1e4, 1e5)),
    'ros2_control, smoothed': Candidate(from_papers.exponential_smoothing, CUTOFFS),
    'AlgDiff': Candidate(peers.algebraic, WINDOWS, 'AlgDiff'),
    'pynumdiff, Kalman filter': Candidate(peers.pynumdiff_filter, BANDWIDTHS, 'pynumdiff'),
    'pynumdiff, RTS smoother': Candidate(peers.pynumdiff_rts, BANDWIDTHS, 'pynumdiff'),
    'kalmangrad': Candidate(peers.kalmangrad, (3.0, 8.0), 'kalmangrad'),
    'savgol_filter': Candidate(peers.savitzky_golay, WINDOWS, 'scipy'),
    'make_smoothing_spline': Candidate(peers.smoothing_spline, (None,), 'scipy'),
}
"""What others have."""

CANDIDATES = {BEST_CUTOFF: Candidate(run_usual, CUTOFFS), **SIMPLE, **OURS, **PEERS}


def present(names: Iterable[str]) -> tuple[list[str], list[str]]:
    """Return the candidates that can run, and a line for each that cannot."""
    able, lines = [], []
    for name in names:
        module = CANDIDATES[name].module if name in CANDIDATES else ''
        how = peers.missing(module) if module else ''
        if how:
            lines.append(f'{name}: left out, {module} is not installed: {how}')
        else:
            able.append(name)
    return able, lines


def best(name: str, samples: Samples, error: Callable[[Result], float]) -> Result:
    """Run a candidate with each of its tunings; return the result of least error."""
    run, tunings, _ = CANDIDATES[name]
    if len(tunings) == 1:
        return run(samples, tunings[0])
    with np.errstate(all='ignore'):     # a tuning that blows up is not the best
        results = [run(samples, tuning) for tuning in tunings]
        errors = [error(result) for result in results]
    return results[int(np.nanargmin(errors))]
