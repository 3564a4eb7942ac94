# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
A reference for recordings without a truth: a smooth motion that knows past and future.

A penalised quintic B-spline (fourth differences of its coefficients) through the readings at
their ticks: no lag, and half of the amplitude at its cutoff. Each joint's cutoff is where the
expected squared error of the acceleration is least, by its spectrum: the noise is flat, or nearly
so, and the motion is what stands above it at lower frequencies. How far the reference can be
trusted is found by simulation: `Twin`, whose truth is known, is put through the same.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from benchmark.estimation.samples import Samples
from benchmark.estimation.ticks import reading_times
import numpy as np

DEGREE, ORDER = 5, 4
EDGE = 0.5
"""Seconds at the ends that are not vouched for."""

GAP, NEAR_GAP = 0.1, 0.2
"""Pauses, s, that are gaps; how far from them nothing is vouched for."""

FINEST = 0.02
"""Longest distance of knots, s."""

LOWEST, HIGHEST = 2.0, 400.0
"""Cutoffs that are looked for, Hz."""

STEEP = 2.0
"""The motion's spectrum falls at least with this power of the frequency, noise less."""

RICHER = 1.5
"""Cutoff of a twin's truth over that of the reference."""


class Smoother:
    """A spline that passes half the amplitude at a cutoff, for readings at given times."""

    def __init__(self, times: np.ndarray, cutoff: float) -> None:
        from scipy import sparse
        from scipy.interpolate import BSpline
        span = times[-1] - times[0]
        pieces = int(np.ceil(span / min(1 / (12 * cutoff), FINEST)))
        h = span / pieces
        self._knots = times[0] + h * np.arange(-DEGREE, pieces + DEGREE + 1)
        inside = np.clip(times, times[0], np.nextafter(times[-1], -np.inf))
        self._design = BSpline.design_matrix(inside, self._knots, DEGREE).tocsr()
        count = self._design.shape[1]
        coefficients = np.diff(np.eye(ORDER + 1), n=ORDER, axis=0)[0]
        rough = sparse.diags([np.full(count - ORDER, c) for c in coefficients],
                             list(range(ORDER + 1)), shape=(count - ORDER, count))
        stiffness = (len(times) - 1) / span * h / (2 * np.pi * cutoff * h)**(2 * ORDER)
        normal = (self._design.T @ self._design + stiffness * (rough.T @ rough)).tocsr()
        self._banded = np.zeros((DEGREE + 1, count))
        for k in range(DEGREE + 1):
            self._banded[DEGREE - k, k:] = normal.diagonal(k)

    def fit(self, readings: np.ndarray) -> object:
        """Return the spline."""
        from scipy.interpolate import BSpline
        from scipy.linalg import solveh_banded
        return BSpline(self._knots, solveh_banded(self._banded, self._design.T @ readings),
                       DEGREE)


@dataclass(frozen=True)
class Reference:
    """Smooth motions through readings."""

    times: np.ndarray      # (N,), of the samples' readings, s
    fresh: np.ndarray      # (N,), which samples brought a new one
    period: float          # of the device, s; 0.0 where stamps are the readings' own
    cutoffs: np.ndarray    # of the joints, Hz
    splines: list          # of the joints

    def at(self, t: np.ndarray, order: int) -> np.ndarray:
        """Return a derivative at times t, (len(t), n); NaN where nothing is vouched for."""
        known = self.times[self.fresh]
        good = (t >= known[0] + EDGE) & (t <= known[-1] - EDGE)
        for k in np.flatnonzero(np.diff(known) > GAP):
            good &= (t < known[k] - NEAR_GAP) | (t > known[k + 1] + NEAR_GAP)
        values = np.full((len(t), len(self.splines)), np.nan)
        for j, spline in enumerate(self.splines):
            values[good, j] = spline(t[good], order)
        return values


def reference_of(samples: Samples, cutoff: float | None = None) -> Reference:
    """Return the reference motion of samples whose stamps increase."""
    times, fresh, period = reading_times(samples.stamps, samples.positions)
    t, q = times[fresh], samples.positions[fresh]
    if cutoff is None:
        cutoffs = np.array([best_cutoff(*_spectrum(t, y)) for y in q.T])
    else:
        cutoffs = np.full(q.shape[1], cutoff)
    return _through(Reference(times, fresh, period, cutoffs, []), q)


def _through(like: Reference, q: np.ndarray) -> Reference:
    """Return a reference at the same times through fresh readings (N, n)."""
    t = like.times[like.fresh]
    smoothers = {c: Smoother(t, c) for c in set(like.cutoffs.tolist())}
    return replace(like, splines=[
        smoothers[c].fit(y) for c, y in zip(like.cutoffs.tolist(), q.T)])


def _spectrum(t: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies, Hz, and the spectral density of positions."""
    from scipy.interpolate import CubicSpline
    from scipy.signal import welch
    step = float(np.median(np.diff(t)))
    regular = CubicSpline(t, y)(np.arange(t[0], t[-1], step))
    # By way of second differences, so that slow motion does not leak.
    bent = np.diff(regular, 2) / step**2
    f, density = welch(bent, 1 / step, nperseg=min(len(bent), int(4 / step)), detrend=False)
    return f[1:], density[1:] / ((2 * np.sin(np.pi * f[1:] * step) / step)**4)


def best_cutoff(f: np.ndarray, density: np.ndarray) -> float:
    """Return the cutoff of least expected error of the acceleration, Hz."""
    level = _noise(f, density)
    noise = np.full(len(f), level)
    motion = np.maximum(density - noise, 0.0)
    drowned = np.flatnonzero(density < 2 * noise)
    if len(drowned):
        motion[drowned[0]:] = 0.0
    weight = (2 * np.pi * f)**4
    cutoffs = np.geomspace(LOWEST, min(HIGHEST, f[-1]), 60)
    risk = []
    for c in cutoffs:
        passed = 1 / (1 + (f / c)**(2 * ORDER))
        risk.append((weight * ((1 - passed)**2 * motion + passed**2 * noise)).sum())
    return float(cutoffs[int(np.argmin(risk))])


def _noise(f: np.ndarray, density: np.ndarray) -> float:
    """
    Return the noise's density, where the spectrum first falls no longer as motions do.

    What is more than twice that further up is motion, too.
    """
    centres = f[-1] * 2.0 ** np.arange(np.log2(1.5 / f[-1]), -0.4, 0.25)
    levels = np.array([np.log2(np.median(density[(f > c / 1.4) & (f < c * 1.4)]) / np.log(2))
                       for c in centres])
    octave = 4
    slopes = levels[octave:] - levels[:-octave]
    for first in range(len(slopes) - 1):
        level = np.median(levels[first + octave:first + 2 * octave + 1])
        if (slopes[first:first + 2] > -STEEP).all() and (
                levels[first + octave:] < level + 1.0).all():
            return float(2.0**level)
    return float(2.0 ** levels[-1])


@dataclass(frozen=True)
class Twin:
    """A recording made anew: the same ticks and stamps, and a truth that is known."""

    samples: Samples
    truth: Reference


def twin_of(samples: Samples, reference: Reference, seed: int = 0) -> Twin:
    """
    Return simulated samples like recorded ones.

    The truth is the motion with half more bandwidth; the noise of positions has the spectrum of
    what the reference leaves of them (below the cutoff the level just above it); velocities err
    as recorded ones do.
    """
    rng = np.random.default_rng(seed)
    t = reference.times[reference.fresh]
    readings = samples.positions[reference.fresh]
    truth = _through(replace(reference, cutoffs=RICHER * reference.cutoffs), readings)
    made = np.empty_like(readings)
    for j, spline in enumerate(truth.splines):
        left = readings[:, j] - reference.splines[j](t)
        made[:, j] = spline(t) + _alike(left, t, float(reference.cutoffs[j]), rng)
        step = _quantum(readings[:, j])
        if step:
            made[:, j] = np.round(made[:, j] / step) * step
    positions = made[np.cumsum(reference.fresh) - 1]
    velocities = samples.velocities
    if velocities is not None:
        velocities = velocities + np.stack(
            [true(reference.times, 1) - own(reference.times, 1)
             for true, own in zip(truth.splines, reference.splines)], axis=1)
    return Twin(replace(samples, positions=positions, velocities=velocities), truth)


def _alike(left: np.ndarray, t: np.ndarray, cutoff: float,
           rng: np.random.Generator) -> np.ndarray:
    """Return noise with the spectrum of what is left of readings, in random phases."""
    f = np.fft.rfftfreq(len(left), float(np.median(np.diff(t))))
    power = np.abs(np.fft.rfft(left))**2
    above = (f > 1.3 * cutoff) & (f < min(3 * cutoff, f[-1]))
    if not above.any():
        above = f > 0.8 * f[-1]
    power[f <= 1.3 * cutoff] = power[above].mean()
    width = max(5, int(1.0 / f[1]))
    power = np.convolve(power, np.ones(width) / width, 'same')
    phases = np.exp(2j * np.pi * rng.random(len(f)))
    return np.fft.irfft(np.sqrt(power) * phases, len(left))


def _quantum(readings: np.ndarray) -> float:
    """Return the step in which readings are written, 0.0 if there is none."""
    for step in (1e-3, 1e-4, 1e-5, 1e-6):
        if np.abs(readings - np.round(readings / step) * step).max() < 1e-3 * step:
            return step
    return 0.0


def floor(samples: Samples, reference: Reference, within: bool = False) -> np.ndarray:
    """
    Return by how much the reference misses the acceleration of a twin, RMS, shape (n,).

    That is the noise it lets pass and, unless only what is `within` its cutoff is called motion,
    what of the motion goes on above.
    """
    t = reference.times[reference.fresh]
    twin = twin_of(samples, reference)
    again_times, fresh, _ = reading_times(twin.samples.stamps, twin.samples.positions)
    again = _through(replace(reference, times=again_times, fresh=fresh),
                     twin.samples.positions[fresh])
    truth = twin.truth if not within else _through(
        reference, np.stack([spline(t) for spline in twin.truth.splines], axis=1))
    missed = again.at(samples.stamps, 2) - truth.at(samples.stamps, 2)
    return np.sqrt(np.nanmean(missed**2, axis=0))   # type: ignore[no-any-return]
