# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joint motion from recorded samples, with the past and the future of each instant in view."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from .guard import REFUSED, SampleGuard, START
from .interval_smoother import smooth_batch
from .joint_motion import Array
from .sampling_clock import SamplingClock
from .velocity_trust import VelocityTrust
from ..errors import InvalidValueError, ShapeError

OVERLAP = 0.4
"""How far a piece of a long run reaches into its neighbours, s; the filters remember less."""

CORE = 1200
"""Samples of a piece without its overlaps."""

BATCH = 24
"""Pieces smoothed together; bounds the memory."""


@dataclass(frozen=True)
class SmoothedMotion:
    """
    Motion of n joints at N recorded instants; all arrays but `used` have N rows.

    Attributes
    ----------
    stamps: shape (N,)
        The instants, s: those of the samples that were used (a regular clock's where the stamps
        of a periodic sampler jitter).
    position, velocity, acceleration, jerk: shape (N, n)
        rad or m, per s, s^2, s^3.
    variance: shape (N, 4, n)
        Variances of the four.
    used: shape of the input's stamps
        Which samples were used; the others were out of order, not finite, or outliers.

    """

    stamps: Array
    position: Array
    velocity: Array
    acceleration: Array
    jerk: Array
    variance: Array
    used: Array


def smooth(
    stamps: Array, positions: Array, velocities: Array | None = None, *,
    continuous: Sequence[bool] | None = None, max_gap: float = 0.25, max_velocity: float = 20.0,
    progress: Callable[[float], None] | None = None,
) -> SmoothedMotion:
    """
    Smooth recorded samples: the best estimate where no answer is needed at once.

    The same models and the same self-tuning as `MotionEstimator`, run forwards and backwards over
    each run of samples (a gap begins a new one). Long runs are cut into overlapping pieces that
    are smoothed side by side, so that memory stays bounded.

    Parameters
    ----------
    stamps: shape (N,)
        Stamps in s; subtract the first in integer nanoseconds.
    positions: shape (N, n)
        Measured positions, rad or m.
    velocities: shape (N, n)
        Measured velocities, NaN where not measured; used where they deserve trust throughout.
    continuous: shape (n,)
        Joints that wrap at 2 pi.
    max_gap:
        A pause longer than this (s) begins a new run.
    max_velocity:
        A joint that seems to move faster (rad/s or m/s) is refused.
    progress:
        Called with the share that is done, 0 to 1.

    Raises
    ------
    ShapeError
        If the arrays do not belong together.
    InvalidValueError
        If no run has as many as eight good samples.

    References
    ----------
    G. J. Bierman, "Fixed interval smoothing with discrete measurements", Int. J. Control 18
    (1973) 65-75.

    """
    stamps, positions = np.asarray(stamps, float), np.asarray(positions, float)
    if positions.ndim != 2 or len(positions) != len(stamps):
        raise ShapeError('positions', f'({len(stamps)}, n)', positions.shape)
    if velocities is not None:
        velocities = np.asarray(velocities, float)
        if velocities.shape != positions.shape:
            raise ShapeError('velocities', str(positions.shape), velocities.shape)
    guard = SampleGuard(positions.shape[1], max_gap=max_gap, max_velocity=max_velocity,
                        continuous=continuous)
    used, times, unwrapped, starts = _admit(guard, stamps, positions)
    bounds = np.append(np.flatnonzero(starts), len(times))
    long_enough = np.repeat(np.diff(bounds) >= 8, np.diff(bounds))
    if not long_enough.any():
        raise InvalidValueError('recorded samples: no run of at least 8 good ones')
    used[np.flatnonzero(used)[~long_enough]] = False
    times, unwrapped, starts = times[long_enough], unwrapped[long_enough], starts[long_enough]
    bounds = np.append(np.flatnonzero(starts), len(times))
    measured = None if velocities is None else velocities[used]
    ratio = None if measured is None else _velocity_ratio(times, unwrapped, measured)
    if ratio is None:
        measured = None

    n = positions.shape[1]
    state, variance = np.empty((len(times), 4, n)), np.empty((len(times), 4, n))
    pieces = sorted(_pieces(times, bounds), key=lambda piece: piece[3] - piece[0])
    for first in range(0, len(pieces), BATCH):
        batch = pieces[first:first + BATCH]
        for (begin, core, end, _), (x, p) in zip(
                batch, smooth_batch(times, unwrapped, measured, ratio, batch)):
            state[core:end], variance[core:end] = (
                x[core - begin:end - begin], p[core - begin:end - begin])
        if progress is not None:
            progress(min(1.0, (first + BATCH) / len(pieces)))
    return SmoothedMotion(
        times, state[:, 0], state[:, 1], state[:, 2], state[:, 3], variance, used)


def _admit(
    guard: SampleGuard, stamps: Array, positions: Array
) -> tuple[Array, Array, Array, Array]:
    """Return which samples are used, and their times, unwrapped positions and run starts."""
    used = np.zeros(len(stamps), bool)
    starts = np.zeros(len(stamps), bool)
    times, unwrapped = stamps.copy(), positions.copy()
    clock = SamplingClock()
    last = -np.inf
    for k, (stamp, position) in enumerate(zip(stamps.tolist(), positions)):
        dt = guard.admit(stamp, position)
        if dt == REFUSED:
            continue
        if dt == START:
            clock.start()
            starts[k] = True
            last = -np.inf
        time = clock.push(stamp, guard.position)
        last = time if time > last else last + 1e-9
        used[k], times[k], unwrapped[k] = True, last, guard.position
    return used, times[used], unwrapped[used], starts[used]


def _velocity_ratio(times: Array, positions: Array, velocities: Array) -> Array | None:
    """Return the velocity's noise ratio per joint, judged on stretches spread over the record."""
    count = len(times)
    stretch = 2000
    trust = VelocityTrust(positions.shape[1])
    worst = np.zeros(trust.n_joints)
    for begin in np.linspace(0, max(0, count - stretch), min(8, -(-count // stretch))).astype(int):
        trust.start()
        for k in range(begin, min(begin + stretch, count)):
            trust.push(times[k], positions[k], velocities[k])
        ratio = np.full_like(worst, np.inf) if trust.ratio is None else trust.ratio
        # One stretch of distrust is enough: the worst ratio counts. Those that prove nothing do
        # not.
        distrust = trust.lagging | trust.differenced | np.isfinite(ratio)
        worst = np.where(distrust, np.maximum(worst, ratio), worst)
    worst[(worst == 0.0) | ~np.isfinite(velocities).all(axis=0)] = np.inf
    return worst if np.isfinite(worst).any() else None


def _pieces(times: Array, bounds: Array) -> Iterator[tuple[int, int, int, int]]:
    """Yield (begin, core begin, core end, end) of overlapping pieces of the runs."""
    for start, stop in zip(bounds[:-1].tolist(), bounds[1:].tolist()):
        for core in range(start, stop, CORE):
            end = min(core + CORE, stop)
            begin = np.searchsorted(times[start:core], times[core] - OVERLAP) + start
            after = np.searchsorted(times[end:stop], times[end - 1] + OVERLAP) + end
            yield int(begin), core, end, int(after)
