# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joint motion from recorded samples, with the past and the future of each instant in view."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import sqrt
import reprlib
from typing import Any

import numpy as np

from .device_clock import DeviceClock
from .divided_differences import divided_difference, roughness
from .estimator import MotionEstimator
from .joint_motion import Array
from .smoothed_velocity import fused, telling
from .units import unit_doubts
from ..core.interval_smoother import IntervalSmoother
from ..errors import InvalidValueError, Reason, ShapeError

BANDWIDTHS = tuple(0.1 * 1.65**k for k in range(17))
"""Bandwidths of the filters, Hz."""

WIDE, STEEP = 0.38, 0.34
"""Handicap of wide filters: what tells positions best is too wide for derivatives."""

OVERLAP = 2.0
"""How far a piece of a long run reaches into its neighbours, s; few filters remember more."""

PIECE, TOGETHER = 8000, 8
"""Readings of a piece without its overlaps, and most of an overlap, and joints that are smoothed
together; both bound the memory."""

FEWEST = 8
"""Readings that a run must have."""

JUMP = 0.02
"""What a position may jump by beside its noise and `max_velocity`, as in `MotionEstimator`."""

ODD = 6.0
"""Deviations from what all others say from which on a reading is odd."""


@dataclass(frozen=True)
class SmoothedMotion:
    """
    Motion of n joints at N recorded instants; all arrays but `used` have N rows.

    Parameters
    ----------
    stamps : array, shape (N,)
        The instants, s: the stamps of the samples that were used.
    position, velocity, acceleration, jerk : array, shape (N, n)
        rad or m, per s, s^2, s^3.
    variance : array, shape (N, 4, n)
        Variances of the four.
    used : array of bool, shape of the input's stamps
        Which samples were used; the others were out of order, not finite, or outliers.
    findings : tuple of str
        What is odd about the samples, as short sentences.
    refused : dict from Reason to int
        How many samples were not used, by reason.

    """

    stamps: Array
    position: Array
    velocity: Array
    acceleration: Array
    jerk: Array
    variance: Array
    used: Array
    findings: tuple[str, ...] = ()
    refused: Mapping[Reason, int] = field(default_factory=dict)


@dataclass
class _Run:
    """Samples without a gap: when they were read, and what is asked of them."""

    rows: list[int]             # of the samples
    instants: list[float]       # device time of their stamps
    rates: list[float]          # seconds of the stamps in a second of the device
    fresh: list[bool]           # whether they brought a new reading
    times: list[float]          # of the readings, device time
    positions: list[Any]        # of the readings, unwrapped
    odd: list[Any]              # by joint how many before each reading it shows to be odd
    clock: DeviceClock          # at its end


def smooth(
    stamps: Array, positions: Array, velocities: Array | None = None, *,
    continuous: Sequence[bool] | None = None, max_gap: float = 0.25,
    max_velocity: float | Sequence[float] = 20.0,
    joint_names: Sequence[str] | None = None,
    progress: Callable[[float], None] | None = None,
) -> SmoothedMotion:
    """
    Smooth recorded samples: the best estimate where no answer is needed at once.

    The same device clock, models and self-tuning as in `MotionEstimator`, but with the past and
    the future in view: what a first pass learns of the clock a second one knows from the start;
    the filters run forwards and backwards over each run of samples (a gap begins a new one); a
    reading that those after it, or all others, contradict is left out.

    Parameters
    ----------
    stamps : array, shape (N,)
        Stamps in s; subtract the first in integer nanoseconds.
    positions : array, shape (N, n)
        Measured positions, rad or m.
    velocities : array, shape (N, n)
        Measured velocities, NaN where not measured; used as far as they prove right.
    continuous : sequence of bool, length n
        Joints that wrap at 2 pi.
    max_gap, max_velocity : float
        As in `MotionEstimator`.
    joint_names : sequence of str, optional
        What findings call the joints; by default 'joint 0', 'joint 1', ...
    progress : callable, optional
        Called with the share that is done, 0 to 1.

    Returns
    -------
    SmoothedMotion
        At the stamps of the samples that were used.

    Raises
    ------
    ShapeError
        If the arrays do not belong together.
    InvalidValueError
        If no run has as many as eight good samples.

    """
    stamps, positions = _numbers('stamps', stamps), _numbers('positions', positions)
    if stamps.ndim != 1:
        raise ShapeError('stamps', '(N,)', stamps.shape)
    if positions.ndim != 2 or len(positions) != len(stamps):
        raise ShapeError('positions', f'({len(stamps)}, n)', positions.shape)
    if velocities is not None:
        velocities = _numbers('velocities', velocities)
        if velocities.shape != positions.shape:
            raise ShapeError('velocities', str(positions.shape), velocities.shape)
    limits = {'max_gap': max_gap, 'max_velocity': max_velocity, 'continuous': continuous,
              'max_jump': JUMP + ODD * sqrt(2.0) * _noise(positions)}
    clocks = [run.clock for run in _runs(stamps, positions, velocities, limits, [])[0]]
    report = progress or (lambda _: None)
    report(0.2)
    every, refused = _runs(stamps, positions, velocities, limits, clocks)
    runs = [run for run in every if len(run.times) >= FEWEST]
    short = sum(len(run.rows) for run in every if len(run.times) < FEWEST)
    if short:
        refused[Reason.RUN_TOO_SHORT] = short
    names = [f'joint {k}' for k in range(positions.shape[1])] if joint_names is None \
        else joint_names
    findings = dict.fromkeys(_odd_units(names, positions, continuous))
    if not runs:
        why = [f'{n} of {len(stamps)} refused: {reason}' for reason, n in refused.items()]
        step = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
        if step > max_gap:
            why.append(f'stamps, in s, are {step:.3g} apart, and max_gap is {max_gap:g}')
        raise InvalidValueError('; '.join(
            ['recorded samples: no run of at least 8 good ones', *why, *findings]))
    count, n = sum(len(run.rows) for run in runs), positions.shape[1]
    state, variance = np.empty((count, 4, n)), np.empty((count, 4, n))
    used = np.zeros(len(stamps), bool)
    done = 0
    for run in runs:
        end = done + len(run.rows)
        _smooth_run(run, stamps, velocities, state[done:end], variance[done:end])
        used[run.rows] = True
        done = end
        findings.update(dict.fromkeys(run.clock.doubts()))
        report(0.2 + 0.8 * done / count)
    return SmoothedMotion(stamps[used], state[:, 0], state[:, 1], state[:, 2], state[:, 3],
                          variance, used, tuple(findings), refused)


def _numbers(name: str, values: Any) -> Array:
    try:
        return np.asarray(values, float)
    except (TypeError, ValueError):
        raise InvalidValueError(f'{name} must be an array of numbers, got '
                                f'{reprlib.repr(values)}') from None


def _noise(positions: Array) -> float:
    """Return the deviation of the noisiest joint's noise: fourth differences leave little else."""
    with np.errstate(invalid='ignore'):
        fourth = np.abs(np.diff(positions, 4, axis=0))
    found = [np.median(column[np.isfinite(column)]) for column in fourth.T
             if np.isfinite(column).any()]
    return float(max(found, default=0.0)) / (0.6745 * sqrt(70.0))


def _odd_units(names: Sequence[str], positions: Array, continuous: Sequence[bool] | None,
               ) -> Iterator[str]:
    wraps = [False] * len(names) if continuous is None else continuous
    for name, position, may_wrap in zip(names, positions.T, wraps):
        for doubt in unit_doubts(position, 'continuous' if may_wrap else ''):
            yield f'{name} {doubt.problem}: {doubt.advice}'


def _runs(stamps: Array, positions: Array, velocities: Array | None, limits: dict[str, Any],
          known: Sequence[DeviceClock]) -> tuple[list[_Run], dict[Reason, int]]:
    """
    Return the runs of samples, and how many samples were refused.

    They are placed in the time of clocks that may be known by run.
    """
    n = positions.shape[1]
    estimator = MotionEstimator(n, **limits)
    runs: list[_Run] = []
    for k, (stamp, position) in enumerate(zip(stamps.tolist(), positions.tolist())):
        before = estimator.runs
        placed = estimator.place(stamp, tuple(position),
                                 None if velocities is None else tuple(velocities[k].tolist()),
                                 known[len(runs)] if len(runs) < len(known) else None)
        if isinstance(placed, Reason):
            continue
        if estimator.runs > before:
            runs.append(_Run([], [], [], [], [], [], [], estimator.clock))
        run = runs[-1]
        time = placed.time
        if time is not None and run.times and time <= run.times[-1]:
            time = None
        run.rows.append(k)
        run.instants.append(placed.instant)
        run.rates.append(placed.rate)
        run.fresh.append(time is not None)
        if time is not None:
            run.times.append(time)
            run.positions.append(estimator.position)
            run.odd.append(estimator.odd)
    return runs, dict(estimator.refusals)


def _smooth_run(run: _Run, stamps: Array, velocities: Array | None, state: Array,
                variance: Array) -> None:
    """Write the motion of a run, and its variance, at its samples."""
    times, positions, odd = np.array(run.times), np.array(run.positions), _marked(run.odd)
    instants, rates = np.array(run.instants), np.array(run.rates)
    fresh = np.array(run.fresh)
    measured = None
    if velocities is not None:
        measured = velocities[run.rows][fresh] * rates[fresh][:, None]
    given = stamps[run.rows]
    if _smoother_by(given[fresh], times, positions):
        # The clock has found nothing that is better than the stamps.
        times, instants, rates = given[fresh], given, np.ones(len(given))
    # The reading nearest to each sample's stamp, and how much later that is.
    nearest = np.searchsorted((times[1:] + times[:-1]) / 2.0, instants)
    onward = np.clip(instants - times[nearest], -0.05, 0.05)
    smoother = IntervalSmoother(BANDWIDTHS, WIDE, STEEP)
    for begin, core, end, after in _pieces(times):
        smoother.plan(np.ascontiguousarray(times[begin:after]))
        rows = np.flatnonzero((nearest >= core) & (nearest < end))
        at = nearest[rows] - begin
        h, rate = onward[rows].reshape(-1, 1), rates[rows].reshape(-1, 1)
        for first in range(0, positions.shape[1], TOGETHER):
            joints = slice(first, first + TOGETHER)
            x, p = _smoothed(smoother, times[begin:after], positions[begin:after, joints].T,
                             odd[begin:after, joints].T)
            if measured is not None:
                _fuse(smoother, times[begin:after], x, p, positions[begin:after, joints].T,
                      measured[begin:after, joints].T)
            q, v, a, jerk = (x[:, i, at].T for i in range(4))
            state[rows, 0, joints] = q + h * (v + h / 2 * (a + h / 3 * jerk))
            state[rows, 1, joints] = (v + h * (a + h / 2 * jerk)) / rate
            state[rows, 2, joints] = (a + h * jerk) / rate**2
            state[rows, 3, joints] = jerk / rate**3
            variance[rows, :, joints] = p[:, :, at].T


def _smoother_by(stamps: Array, times: Array, positions: Array) -> bool:
    """Whether the positions are smoother against stamps than against the clock's times."""
    by_stamps, by_clock = roughness(stamps, positions), roughness(times, positions)
    known = (by_stamps > 0.0) & (by_clock > 0.0)
    if not known.any():
        return bool((by_stamps <= by_clock).all())
    return bool(np.log(by_stamps[known] / by_clock[known]).sum() < 0.0)


def _fuse(smoother: IntervalSmoother, times: Array, x: Array, p: Array, positions: Array,
          velocities: Array) -> None:
    """Let the velocities of joints, as far as they tell anything, into states and variances."""
    told = [(j, velocity) for j, velocity in enumerate(map(
        telling, np.broadcast_to(times, positions.shape), x, positions, velocities))
        if velocity is not None]
    if not told:
        return
    values = np.stack([velocity for _, velocity in told])
    y, s, _ = _through(smoother, values, np.zeros(len(told)))
    for k, (j, velocity) in enumerate(told):
        x[j], p[j] = fused(times, x[j], p[j], positions[j], velocity, y[k], s[k])


def _through(smoother: IntervalSmoother, values: Array, floors: Array,
             ) -> tuple[Array, Array, Array]:
    """Return states, variances, and what each of J signals' samples differs from the others."""
    count, n = values.shape
    x, p, rest = np.empty((count, 4, n)), np.empty((count, 4, n)), np.empty((count, 2, n))
    smoother.smooth(np.ascontiguousarray(values), floors, x.reshape(-1, n), p.reshape(-1, n),
                    rest.reshape(-1, n))
    return x, p, rest


def _marked(before: Sequence[Sequence[int]]) -> Array:
    """Return which readings of which joint are odd, (N, n); each tells how many before it are."""
    counts = np.array(before)
    odd = np.zeros(counts.shape, bool)
    for back in range(1, int(counts.max(initial=0)) + 1):
        odd[:-back] |= counts[back:] >= back
    return odd


def _bridged(times: Array, values: Array, odd: Array) -> Array:
    """Return values with those that are odd on the cubic through two others to either side."""
    rows, others = np.flatnonzero(odd), np.flatnonzero(np.logical_not(odd))
    if not len(rows) or len(others) < 4:
        return values
    at = np.clip(np.searchsorted(others, rows), 2, len(others) - 2)
    near = others[at[:, None] + np.arange(-2, 2)]
    of = divided_difference(times[np.column_stack([near, rows])] - times[rows, None])
    bridged = values.copy()
    bridged[rows] = -(of[:, :4] * values[near]).sum(axis=1) / of[:, 4]
    return bridged


def _smoothed(smoother: IntervalSmoother, times: Array, values: Array, odd: Array,
              ) -> tuple[Array, Array]:
    """Return states and variances, shapes (J, 4, N), of joints; odd readings are left out."""
    floors = np.array([_rounding(signal) for signal in values])
    values = np.stack([_bridged(times, *joint) for joint in zip(values, odd)])
    x, p, rest = _through(smoother, values, floors)
    for j, signal in enumerate(values):
        x[j], p[j] = _without_odd(smoother, signal.copy(), floors[j:j + 1], x[j], p[j], rest[j])
    return x, p


def _without_odd(smoother: IntervalSmoother, values: Array, floor: Array, x: Array, p: Array,
                 rest: Array) -> tuple[Array, Array]:
    """Return state and variance of a joint, given what they are with its odd readings."""
    n = len(values)
    for _ in range(3):
        size = np.abs(rest[0]) / rest[1]
        odd = np.flatnonzero((size > ODD) & (size >= np.maximum(
            np.append(size[1:], 0.0), np.append(0.0, size[:-1]))))
        if not len(odd) or len(odd) > 0.05 * n:
            break
        before, kept = rest[0, odd].copy(), values[odd].copy()
        values[odd] -= before
        (x,), (p,), (rest,) = _through(smoother, values[None], floor)
        # A reading was odd if its neighbours are at peace without it; else the joint turned.
        near = np.stack([np.abs(rest[0, np.clip(odd + k, 0, n - 1)]) for k in (-2, -1, 1, 2)])
        real = near.max(axis=0) > 0.2 * np.abs(before)
        values[odd[real]] = kept[real]
        if real.any():
            (x,), (p,), _ = _through(smoother, values[None], floor)
            break
    return x, p


def _rounding(values: Array) -> float:
    """Return the variance of rounding to the step of the encoder; 0 if there is none."""
    changes = np.unique(np.round(np.abs(np.diff(values)), 9))
    changes = changes[changes > 1e-8]
    if not len(changes) or len(changes) > 0.5 * len(values):
        return 0.0
    step = float(changes[0])
    apart = np.abs(changes - step * np.rint(changes / step))
    return step * step / 12.0 if (apart < 0.1 * step).mean() > 0.9 else 0.0


def _pieces(times: Array) -> Iterator[tuple[int, int, int, int]]:
    """Yield (begin, core begin, core end, end) of overlapping pieces of a run."""
    count = len(times)
    for core in range(0, count, PIECE):
        end = min(core + PIECE, count)
        begin = max(int(np.searchsorted(times, times[core] - OVERLAP)), core - PIECE)
        after = min(int(np.searchsorted(times, times[end - 1] + OVERLAP)), end + PIECE)
        yield (max(0, begin), core, end, min(max(after, end), count))
