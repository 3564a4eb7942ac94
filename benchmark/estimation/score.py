# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Scores of estimators on simulated recordings, and their summary over many."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from benchmark.estimation.candidates import best, BEST_CUTOFF, OURS, run_usual, USUAL
from benchmark.estimation.conditions import ALL
from benchmark.estimation.motions import MOVING
from benchmark.estimation.samples import Result, Samples
from benchmark.estimation.simulated import Recording, record
import numpy as np

WARM_UP = 0.5
"""Seconds that are not scored."""

NOTHING = 1e-9
"""Errors below have no price, rad/s^2: exact positions at rest are smoothed without any."""


def evaluate(kind: str, name: str, seed: int, candidates: Iterable[str]) -> dict[str, dict]:
    """
    Return the scores of the candidates on one recording.

    Usual practice, by which all are measured, is given samples in order with right stamps, and
    spared false velocities; all others get what arrives. Of our estimators `price` is the error
    over that on the same motion without what is wrong.
    """
    condition = ALL[name]
    recording = record(kind, condition, seed)
    spared = recording.ordered
    if not isinstance(condition.velocity, float):
        spared = replace(spared, velocities=None)
    scores = {USUAL: score(recording, spared, run_usual(spared))}
    twin, right = recording, spared
    if condition.velocity is not None:
        right = replace(recording.arrived, velocities=None)
    elif not condition.stamps and condition.twin() != condition:
        twin = record(kind, condition.twin(), seed)
        right = twin.ordered
    for candidate in candidates:
        if candidate == USUAL:
            continue
        samples = spared if candidate == BEST_CUTOFF else recording.arrived
        scores[candidate] = score(recording, samples, best(
            candidate, samples, lambda result: acceleration_error(recording, samples, result)))
        if candidate in OURS:
            without = acceleration_error(twin, right, best(candidate, right, lambda _: 0.0))
            scores[candidate]['price'] = (
                max(scores[candidate]['acceleration'], NOTHING) / max(without, NOTHING))
    return scores


def acceleration_error(recording: Recording, samples: Samples, result: Result) -> float:
    """Return the RMS error of the accelerations at the claimed instants."""
    late = result.t > samples.stamps[0] + WARM_UP
    t = (result.t - samples.ahead[result.rows])[late]
    return _rms(result.acceleration[late] - recording.truth(t)[2])


def score(recording: Recording, samples: Samples, result: Result) -> dict[str, float]:
    """Return RMS errors at the claimed instants, and the behaviour at sudden stops."""
    late = result.t > samples.stamps[0] + WARM_UP
    t = (result.t - samples.ahead[result.rows])[late]
    truth = recording.truth(t)
    scores = {'acceleration': _rms(result.acceleration[late] - truth[2]),
              'velocity': _rms(result.velocity[late] - truth[1]),
              'delay': result.behind, 'cost': result.cost}
    overshoot, settling = [], []
    for j, end, deceleration in recording.stops():
        after = (t > end) & (t < end + 0.19)
        if after.sum() < 5 or end < t[0]:
            continue
        a = result.acceleration[late][after, j] / deceleration
        overshoot.append(max(0.0, -a.min()))
        loud = np.flatnonzero(np.abs(a) > 0.05)
        settling.append(t[after][loud[-1]] - end if len(loud) else 0.0)
    if overshoot:
        scores |= {'overshoot': float(np.mean(overshoot)), 'settling': float(np.mean(settling))}
    return scores


def geometric_mean(values: Iterable[float]) -> float:
    """Return the geometric mean."""
    return float(np.exp(np.mean(np.log(np.asarray(list(values))))))


def summary(cells: list[dict], candidate: str) -> dict[str, Any]:
    """
    Return the summary of one candidate.

    `relative` is the geometric mean over the moving cells of the acceleration error over that of
    today's usual practice; `worst` the largest of those; `velocity` the same for the velocity;
    `conditions` and `prices` the means by condition.
    """
    def ratios(cells: list[dict], key: str = 'acceleration') -> list[float]:
        return [c['scores'][candidate][key] / c['scores'][USUAL][key] for c in cells]

    moving = [c for c in cells if c['motion'] in MOVING]
    still = [c['scores'][candidate]['acceleration'] for c in cells if c['motion'] == 'standstill']
    stops = [c['scores'][candidate] for c in cells if c['motion'] == 'sudden stop']
    relative = ratios(moving) or [np.nan]
    result: dict[str, Any] = {
        'relative': geometric_mean(relative), 'worst': max(relative),
        'velocity': geometric_mean(ratios(moving, 'velocity') or [np.nan]),
        'standstill': float(np.median(still)) if still else float('nan'),
        'overshoot': float(np.mean([s.get('overshoot', np.nan) for s in stops] or [np.nan])),
        'settling': float(np.mean([s.get('settling', np.nan) for s in stops] or [np.nan])),
        'delay': float(np.median([c['scores'][candidate]['delay'] for c in cells])),
        'cost': float(np.median([c['scores'][candidate]['cost'] for c in cells])),
        'conditions': {}, 'prices': {}}
    for condition in dict.fromkeys(c['condition'] for c in moving):
        there = [c for c in moving if c['condition'] == condition]
        result['conditions'][condition] = geometric_mean(ratios(there))
        if 'price' in there[0]['scores'][candidate]:
            result['prices'][condition] = geometric_mean(
                c['scores'][candidate]['price'] for c in there)
    return result


def _rms(errors: np.ndarray) -> float:
    return float(np.sqrt(np.mean(errors**2)))
