# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Which settings of the estimator suit recorded joint samples, tried on the samples."""
from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from .findings import FACT, Finding, PROBLEM, REMARK
from ...errors import InvalidValueError
from ...motion import make_estimator
from ...motion.smoother import smooth, SmoothedMotion
from ...recordings.interpolation import interpolate
from ...screws.se3 import Array

DELAYS = (0.0, 0.01, 0.02, 0.03, 0.05)
_MOST = 5000        # samples; enough to judge, and tried in seconds
_LEAST = 200
_ENOUGH = 1.5       # times the error of the best delay
_TOO_LARGE = 1 / 3  # an error as a share of the signal


class Trial(NamedTuple):
    """RMS errors of the joint accelerations with one delay, at rest and in motion [SI]."""

    delay: float
    at_rest: float
    in_motion: float


def recommend(label: str, names: Sequence[str], time: Array, position: Array,
              velocity: Array | None, continuous: Sequence[bool], delay: float,
              ) -> Iterator[Finding]:
    """
    Yield what the estimator makes of the samples, and the settings to choose.

    The truth is taken from the acausal smoother, which sees the future of each sample. Positions
    and velocities are of shape (N, n) [rad, m], finite; the delay is that set at present [s].
    """
    time, position = time[-_MOST:], position[-_MOST:]
    velocity = None if velocity is None else velocity[-_MOST:]
    if len(time) < _LEAST:
        yield Finding(REMARK, f'{label}: {len(time)} samples are too few to recommend settings',
                      f'at least {_LEAST} are needed; listen longer')
        return
    try:
        truth = smooth(time, position, velocity, continuous=continuous, joint_names=names)
    except InvalidValueError as error:
        yield Finding(PROBLEM, f'{label}: nothing can be estimated: {error}',
                      'see what is said of stamps and positions')
        return
    left_out = len(time) - int(truth.used.sum())
    if left_out:
        yield Finding(REMARK, f'{label}: {left_out} of {len(time)} samples are refused: out of '
                              'order, or jumps that no joint makes')
    speed = np.sqrt((truth.velocity**2).mean(axis=1))
    moving = speed > max(0.02 * float(speed.max()), 1e-4)
    trials: list[Trial] = []
    doubts: list[str] = []
    for tried in sorted({*DELAYS, delay}):
        trial, doubts = _try(tried, names, time, position, velocity, continuous, truth, moving)
        trials.append(trial)
    if not any(np.isfinite((trial.at_rest, trial.in_motion)).any() for trial in trials):
        yield Finding(PROBLEM, f'{label}: the node would publish next to nothing: nowhere are '
                               'there enough good samples in a row',
                      'see what is said of stamps and positions')
        return
    signal = float(np.sqrt((truth.acceleration[moving]**2).mean())) if moving.any() else 0.0
    for trial in trials:
        yield Finding(FACT, f'{label}: delay {1e3 * trial.delay:.0f} ms: RMS error of '
                            f'accelerations {_errors(trial, signal)} [rad/s2, m/s2]')
    for doubt in doubts:
        yield Finding(REMARK, f'{label}: {doubt}')
    for what, there in (('at rest', ~moving), ('in motion', moving)):
        if there.mean() < 0.05:
            yield Finding(REMARK, f'{label}: hardly any samples {what}',
                          f'listen again while the robot is {what} for some seconds')
    yield from _judge(label, trials, delay, signal)


def _judge(label: str, trials: Sequence[Trial], delay: float, signal: float) -> Iterator[Finding]:
    """Yield whether the delay that is set will do, and the one to choose."""
    shares = {trial.delay: trial.in_motion / signal for trial in trials
              if signal and np.isfinite(trial.in_motion)}
    usable = [trial for trial in trials if not shares.get(trial.delay, 0.0) > _TOO_LARGE]
    best = _choice(usable)
    if shares.get(delay, 0.0) > _TOO_LARGE:
        yield Finding(
            PROBLEM, f'{label}: with estimator.delay: {delay:g} accelerations are wrong by '
            f'{_percent(shares[delay])} of the signal', 'no delay helps: mend what is remarked '
            'above; until then take states from recordings, by the tool bag' if best is None
            else f'set estimator.delay: {best:g}')
    elif best is not None:
        yield Finding(
            FACT, f'{label}: recommended: estimator.delay: {best:g}, velocity_source: auto',
            '' if usable[0].delay or not best else
            'where states are needed at once, keep estimator.delay: 0')


def _errors(trial: Trial, signal: float) -> str:
    parts = []
    if np.isfinite(trial.at_rest):
        parts.append(f'{trial.at_rest:.2g} at rest')
    if np.isfinite(trial.in_motion):
        parts.append(f'{trial.in_motion:.2g} in motion, '
                     f'{_percent(trial.in_motion / signal)} of the signal')
    return '; '.join(parts)


def _percent(share: float) -> str:
    return f'{100 * share:.0f} %' if share > 1 else f'{100 * share:.2g} %'


def _choice(trials: Sequence[Trial]) -> float | None:
    """Return the shortest delay that is nearly as good as the best; None if there is none."""
    errors = [t.in_motion if np.isfinite(t.in_motion) else t.at_rest for t in trials]
    least = min((error for error in errors if np.isfinite(error)), default=np.nan)
    return next((trial.delay for trial, error in zip(trials, errors)
                 if error <= _ENOUGH * least), None)


def _try(delay: float, names: Sequence[str], time: Array, position: Array, velocity: Array | None,
         continuous: Sequence[bool], truth: SmoothedMotion, moving: Array,
         ) -> tuple[Trial, list[str]]:
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
    known = np.rint(truth.stamps * 1e9).astype(np.int64)
    # Half a second to settle; and the smoother has no future at the very end.
    inside = (at >= known[0] + 500_000_000) & (at <= known[-1] - 100_000_000)
    exact = interpolate(known, truth.acceleration, at[inside])
    found = np.array(accelerations).reshape(-1, position.shape[1])[inside]
    squares = ((found - exact)**2).mean(axis=1)
    in_motion = moving[np.clip(np.searchsorted(known, at[inside]), 0, len(known) - 1)]
    return Trial(delay, _root_mean(squares[~in_motion]), _root_mean(squares[in_motion])), (
        estimator.doubts(names))


def _root_mean(squares: Array) -> float:
    return float(np.sqrt(squares.mean())) if len(squares) else float('nan')
