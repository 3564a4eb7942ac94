# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Which settings of the estimator suit recorded joint samples, tried on the samples."""
from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from .findings import FACT, Finding, REMARK
from ...motion import make_estimator
from ...motion.smoother import smooth
from ...recordings.interpolation import interpolate
from ...screws.se3 import Array

DELAYS = (0.0, 0.01, 0.02, 0.03, 0.05)
_MOST = 5000        # samples; enough to judge, and tried in seconds
_LEAST = 200
_ENOUGH = 1.5       # times the error of the longest delay


class Trial(NamedTuple):
    """RMS errors of the joint accelerations with one delay, at rest and in motion [SI]."""

    delay: float
    at_rest: float
    in_motion: float


def recommend(label: str, names: Sequence[str], time: Array, position: Array,
              velocity: Array | None, continuous: Sequence[bool]) -> Iterator[Finding]:
    """
    Yield what the estimator makes of the samples, and the settings to choose.

    The truth is taken from the acausal smoother, which sees the future of each sample.

    Parameters
    ----------
    label : str
        Of the samples, for messages.
    names : sequence of str
        Of the joints.
    time : array, shape (N,)
        Stamps that increase [s].
    position : array, shape (N, n)
        Positions [rad, m], finite.
    velocity : array, shape (N, n), optional
        Velocities [rad/s, m/s].
    continuous : sequence of bool
        Whether positions wrap at 2 pi.

    """
    time, position = time[-_MOST:], position[-_MOST:]
    velocity = None if velocity is None else velocity[-_MOST:]
    if len(time) < _LEAST:
        yield Finding(REMARK, f'{label}: {len(time)} samples are too few to recommend settings',
                      f'at least {_LEAST} are needed; listen longer')
        return
    truth = smooth(time, position, velocity, continuous=continuous)
    speed = np.sqrt((truth.velocity**2).mean(axis=1))
    moving = speed > max(0.02 * float(speed.max()), 1e-4)
    trials: list[Trial] = []
    doubts: list[str] = []
    for delay in DELAYS:
        trial, doubts = _try(delay, time, position, velocity, continuous, truth, moving)
        trials.append(trial)
    signal = float(np.sqrt((truth.acceleration[moving]**2).mean())) if moving.any() else 0.0
    for trial in trials:
        yield Finding(FACT, f'{label}: delay {1e3 * trial.delay:.0f} ms: RMS error of '
                            f'accelerations {_errors(trial, signal)} [rad/s2, m/s2]')
    for doubt in doubts:
        yield Finding(REMARK, f'{label}: {_with_names(doubt, names)}')
    for what, there in (('at rest', ~moving), ('in motion', moving)):
        if there.mean() < 0.05:
            yield Finding(REMARK, f'{label}: hardly any samples {what}',
                          f'listen again while the robot is {what} for some seconds')
    yield Finding(FACT, f'{label}: recommended: estimator.delay: {_choice(trials):g}, '
                        'velocity_source: auto',
                  'where states are needed at once, keep estimator.delay: 0')


def _errors(trial: Trial, signal: float) -> str:
    parts = []
    if np.isfinite(trial.at_rest):
        parts.append(f'{trial.at_rest:.2g} at rest')
    if np.isfinite(trial.in_motion):
        parts.append(f'{trial.in_motion:.2g} in motion, '
                     f'{100 * trial.in_motion / signal:.2g} % of the signal')
    return '; '.join(parts)


def _with_names(doubt: str, names: Sequence[str]) -> str:
    """Return a doubt of an estimator with the names of the joints it gives by index."""
    what, found, numbers = doubt.partition(': joints ')
    if not found:
        return doubt
    return f'{what}: {", ".join(names[int(number)] for number in numbers.split(", "))}'


def _choice(trials: Sequence[Trial]) -> float:
    """Return the shortest delay that is nearly as good as the longest."""
    errors = np.array([t.in_motion if np.isfinite(t.in_motion) else t.at_rest for t in trials])
    good = np.flatnonzero(errors <= _ENOUGH * errors[-1])
    return trials[int(good[0])].delay if len(good) else trials[-1].delay


def _try(delay: float, time: Array, position: Array, velocity: Array | None,
         continuous: Sequence[bool], truth: object, moving: Array) -> tuple[Trial, list[str]]:
    estimator = make_estimator('bank', position.shape[1], delay=delay,
                               continuous=np.array(continuous, bool))
    stamps, accelerations = [], []
    for i, stamp in enumerate(time.tolist()):
        motion = estimator.update(stamp, position[i],
                                  None if velocity is None else velocity[i])
        if motion is not None:
            stamps.append(motion.stamp)
            accelerations.append(motion.acceleration)
    at = np.rint(np.array(stamps) * 1e9).astype(np.int64)
    known = np.rint(truth.stamps * 1e9).astype(np.int64)    # type: ignore[attr-defined]
    # Half a second to settle; and the smoother has no future at the very end.
    inside = (at >= known[0] + 500_000_000) & (at <= known[-1] - 100_000_000)
    exact = interpolate(known, truth.acceleration, at[inside])    # type: ignore[attr-defined]
    squares = ((np.array(accelerations)[inside] - exact)**2).mean(axis=1)
    in_motion = moving[np.clip(np.searchsorted(known, at[inside]), 0, len(known) - 1)]
    return Trial(delay, _root_mean(squares[~in_motion]), _root_mean(squares[in_motion])), (
        estimator.doubts())


def _root_mean(squares: Array) -> float:
    return float(np.sqrt(squares.mean())) if len(squares) else float('nan')
