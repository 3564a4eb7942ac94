# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Scores of an estimator on one recording, and their summary over many."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from benchmark.estimation.candidates import Result, USUAL
from benchmark.estimation.conditions import Recording
from benchmark.estimation.motions import MOVING
import numpy as np

WARM_UP = 0.5
"""Seconds that are not scored."""


def score(recording: Recording, result: Result) -> dict[str, float]:
    """Return RMS errors at the claimed instants, and the behaviour at sudden stops."""
    late = result.t > recording.ordered[0][0] + WARM_UP
    t = result.t[late]
    truth = recording.truth(t)
    scores = {
        'acceleration': float(np.sqrt(np.mean((result.acceleration[late] - truth[2]) ** 2))),
        'velocity': float(np.sqrt(np.mean((result.velocity[late] - truth[1]) ** 2))),
        'delay': result.behind, 'cost': result.cost,
    }
    overshoot, settling = [], []
    for j, joint in enumerate(recording.joints):
        for end, deceleration in joint.stops:
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
    today's usual practice; `worst` the largest of those; `velocity` the same for the velocity.
    """
    def ratios(cells: list[dict], key: str = 'acceleration') -> list[float]:
        return [c['scores'][candidate][key] / c['scores'][USUAL][key] for c in cells]

    moving = [c for c in cells if c['motion'] in MOVING]
    still = [c['scores'][candidate]['acceleration'] for c in cells if c['motion'] == 'standstill']
    stops = [c['scores'][candidate] for c in cells if c['motion'] == 'sudden stop']
    result = {
        'relative': geometric_mean(ratios(moving)), 'worst': max(ratios(moving)),
        'velocity': geometric_mean(ratios(moving, 'velocity')),
        'standstill': float(np.median(still)) if still else float('nan'),
        'overshoot': float(np.mean([s.get('overshoot', np.nan) for s in stops] or [np.nan])),
        'settling': float(np.mean([s.get('settling', np.nan) for s in stops] or [np.nan])),
        'delay': float(np.median([c['scores'][candidate]['delay'] for c in moving])),
        'cost': float(np.median([c['scores'][candidate]['cost'] for c in cells])),
    }
    by_condition = {}
    for condition in dict.fromkeys(c['condition'] for c in moving):
        by_condition[condition] = geometric_mean(
            ratios([c for c in moving if c['condition'] == condition]))
    return result | {'conditions': by_condition}
