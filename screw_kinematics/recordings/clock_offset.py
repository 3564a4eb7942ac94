# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
How far the clocks of two recorded streams are apart that saw the same motion.

One stream y is linear in features X of the other one's motion, y(t) = X(t + offset) B + noise,
with a B that need not be known: mounting, scale and bias are in it. The offset is where the
residual is least; its interval comes from the scores of half a second each, so that noise may be
coloured.
"""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .interpolation import interpolate
from ..errors import ToolError
from ..screws.se3 import Array

SEARCH = 0.25
"""Offsets are looked for up to this [s]."""

BLOCK = 0.5
"""Residuals further apart in time are taken to be independent [s]."""
VAGUE = 2e-3
"""Standard deviation of an offset that tells little [s]."""
UNRELATED = 0.5
"""Share of the variance below which the streams saw something else."""

_GRID = 8e-3        # of the search [s]
_ROWS = 300         # that it looks at
_STEP = 500_000     # to either side of an instant, for the features' slope [ns]
_FEWEST = 50
_UNLIKELY = 4.0     # less log likelihood, twice, than the best offset has
_LOST = 4.0         # periods of the joints: in a longer step samples are lost
_SHORT = 3e7        # step over which motion is interpolated anyway [ns]
_ITERATIONS = 30


@dataclass(frozen=True)
class Channels:
    """Some measured quantities, and what they are linear in."""

    values: Array      # (N, k), at the stamps of the other stream
    features: Array    # (M, f), at those of the joint motion; a constant is added


@dataclass(frozen=True)
class ClockOffset:
    """What is added to another stream's stamps to have those of the joints, and what tells it."""

    offset: float                # [s]
    deviation: float             # standard deviation of the offset [s]
    drift: float                 # by how much the offset grows in a second
    drift_deviation: float       # [s/s]
    shares: list[float]          # of the variance of each group of channels, explained by motion
    residuals: list[Array]       # (k,) each, standard deviations of what is left of each channel
    coefficients: list[Array]    # (f + 1, k) each, from features and a constant to channels
    freedoms: int                # of the deviations

    @property
    def interval(self) -> tuple[float, float]:
        """Return the 95 % interval of the offset [s]."""
        half = (1.96 + 2.4 / self.freedoms) * self.deviation     # of Student's distribution
        return self.offset - half, self.offset + half

    def told(self) -> str:
        """Return what to say of the stream's stamps."""
        low, high = self.interval
        return (f'stamps are {1e3 * abs(self.offset):.3f} ms '
                f'{"early" if self.offset > 0 else "late"} against those of the joint states '
                f'(offset {1e3 * self.offset:+.3f} ms, 95 % between {1e3 * low:+.3f} and '
                f'{1e3 * high:+.3f} ms)')


def find_offset(joint_stamps: Array, stamps: Array, groups: Sequence[Channels]) -> ClockOffset:
    """
    Return the offset of a stream from the joints' clock; both have stamps that increase [ns].

    Raises
    ------
    ToolError
        The streams do not overlap, or nothing moves, or what moves is something else.

    """
    margin = round((SEARCH + _GRID) * 1e9) + 4 * _STEP
    inside = (stamps > joint_stamps[0] + margin) & (stamps < joint_stamps[-1] - margin)
    if inside.sum() < _FEWEST:
        raise ToolError(
            f'the streams share {int(inside.sum())} samples that are {SEARCH} s off both ends; '
            f'allowed: at least {_FEWEST} (do they overlap in time?)')
    at = stamps[inside]
    groups = [Channels(group.values[inside], group.features) for group in groups]
    telling = [group for group in groups if (np.ptp(group.features, axis=0) > 1e-9).any()]
    if not telling:
        raise ToolError('nothing moves in the recording: an offset cannot be seen')
    for group in telling:       # what slides only never turns
        if not (np.ptp(group.values, axis=0) > 1e-12).any():
            raise ToolError('some of what the other stream measures never changes, but is always '
                            f'{group.values[0].tolist()}: is the sensor connected?')
    thin = max(len(at) // _ROWS, 1)
    offsets = np.arange(-SEARCH, SEARCH + _GRID / 2, _GRID)
    whole = _whole(joint_stamps)
    misfits = _misfits(joint_stamps, whole, at[::thin], [
        Channels(group.values[::thin], group.features) for group in groups], offsets.tolist())
    offset, drift = float(offsets[int(np.argmin(misfits))]), 0.0
    middle = (at - at[len(at) // 2]) * 1e-9
    for _ in range(_ITERATIONS):
        step, covariance, fits = _improve(
            joint_stamps, whole, at, groups, offset, drift, middle)
        offset, drift = offset + step[0], drift + step[1]
        if abs(step[0]) < 1e-8:
            break
    if not abs(offset) < SEARCH:
        raise ToolError(f'no offset within {SEARCH} s fits: is it the same motion?')
    deviation, drift_deviation = np.sqrt(np.diag(covariance))
    # Where the motion hardly tells, the slope at the minimum does not say how far it reaches.
    likely = offsets[len(at[::thin]) * (np.array(misfits) - min(misfits)) < _UNLIKELY]
    reach = float(likely[-1] - likely[0])
    deviation = max(float(deviation), reach if reach > 2 * _GRID else 0.0)
    return ClockOffset(
        offset, deviation, drift, float(drift_deviation),
        [1 - float((r**2).mean() / max(((g.values - g.values.mean(axis=0))**2).mean(), 1e-24))
         for g, (_, r) in zip(groups, fits)],
        [r.std(axis=0) for _, r in fits], [b for b, _ in fits],
        max(int((at[-1] - at[0]) * 1e-9 / BLOCK) - 2, 1))


def predicted(joint_stamps: Array, stamps: Array, group: Channels, coefficients: Array,
              offset: float) -> Array:
    """
    Return what the motion says of channels at stamps of the other stream, shape (N, k).

    By the coefficients found, of shape (f + 1, k), with clocks apart by an offset [s].
    """
    return _features(joint_stamps, group.features,
                     stamps + round(offset * 1e9)) @ coefficients


def shares_explained(joint_stamps: Array, stamps: Array, group: Channels, offsets: Array,
                     ) -> Array:
    """
    Return how much of the variance of channels the motion explains, by offset of the clocks.

    Offsets are of shape (K,), at most SEARCH [s]; so are the shares, from 0 to 1.
    """
    margin = round((SEARCH + _GRID) * 1e9)
    inside = np.flatnonzero((stamps > joint_stamps[0] + margin)
                            & (stamps < joint_stamps[-1] - margin))
    chosen = inside[::max(len(inside) // _ROWS, 1)]
    y = group.values[chosen] - group.values[chosen].mean(axis=0)
    y = y / np.maximum(y.std(axis=0), 1e-30)
    shares = []
    for offset in offsets:
        x = _features(joint_stamps, group.features, stamps[chosen] + round(offset * 1e9))
        rest = y - x @ np.linalg.lstsq(x, y, rcond=1e-10)[0]
        shares.append(1 - float((rest**2).mean()))
    return np.array(shares)


def _features(joint_stamps: Array, features: Array, at: Array) -> Array:
    """Return the features at instants, and the constant."""
    found = interpolate(joint_stamps, features, at)
    return np.concatenate([found, np.ones((len(at), 1))], axis=1)


def _whole(joint_stamps: Array) -> Array:
    """Return for each step between samples of the joints whether none are lost in it."""
    steps = np.diff(joint_stamps)
    return np.asarray(steps <= max(_LOST * float(np.median(steps)), _SHORT))


def _covered(joint_stamps: Array, whole: Array, at: Array) -> Array:
    """Return at which instants the joints' motion is known: not where samples of it are lost."""
    after = np.searchsorted(joint_stamps, at, side='right').clip(1, len(whole))
    return np.asarray(whole[after - 1])


def _misfits(joint_stamps: Array, whole: Array, at: Array, groups: Sequence[Channels],
             offsets: Sequence[float]) -> list[float]:
    """Return the logarithms of what is left, by which groups of any units can be added."""
    misfits = []
    features = np.concatenate([group.features for group in groups], axis=1)
    ends = np.cumsum([group.features.shape[1] for group in groups]).tolist()
    for offset in offsets:
        shifted = at + round(offset * 1e9)
        known = _covered(joint_stamps, whole, shifted)
        if known.sum() < _FEWEST:
            misfits.append(float('inf'))
            continue
        found, left = _features(joint_stamps, features, shifted[known]), 0.0
        for group, begin, end in zip(groups, [0, *ends], ends):
            x, y = found[:, [*range(begin, end), -1]], group.values[known]
            rest = y - x @ np.linalg.lstsq(x, y, rcond=1e-10)[0]
            left += float(np.log((rest**2).mean(axis=0) + 1e-30).sum())
        misfits.append(left)
    return misfits


def _improve(joint_stamps: Array, whole: Array, at: Array, groups: Sequence[Channels],
             offset: float, drift: float, middle: Array,
             ) -> tuple[Array, Array, list[tuple[Array, Array]]]:
    """Return a Gauss-Newton step of offset and drift, their covariance, and the fits."""
    shifted = at + np.rint((offset + drift * middle) * 1e9).astype(np.int64)
    known = _covered(joint_stamps, whole, shifted)
    shifted, middle = shifted[known], middle[known]
    block = ((at[known] - at[0]) // round(BLOCK * 1e9)).astype(int)
    normal, scores = np.zeros((2, 2)), np.zeros((2, int(block[-1]) + 1))
    fits = []
    for group in groups:
        x, before, after = (_features(joint_stamps, group.features, shifted + step)
                            for step in (0, -_STEP, _STEP))
        values = group.values[known]
        b = np.linalg.lstsq(x, values, rcond=1e-10)[0]
        rest = values - x @ b
        slope = (after - before) @ b / (2e-9 * _STEP)
        basis = np.linalg.svd(x, full_matrices=False)
        q = basis[0][:, basis[1] > 1e-10 * basis[1][0]]
        weights = 1 / np.maximum(rest.var(axis=0), 1e-30)
        # What offset and drift do to the channels, beyond what another B would do as well.
        effects = [g - q @ (q.T @ g) for g in (slope, slope * middle[:, None])]
        for i in range(2):
            scores[i] += np.bincount(block, ((effects[i] * rest) @ weights), len(scores[i]))
            for j in range(2):
                normal[i, j] += float(((effects[i] * effects[j]).sum(axis=0) @ weights))
        fits.append((b, rest))
    inverse = np.linalg.pinv(normal, rcond=1e-12)
    # Blocks of scores: noise may be coloured within them.
    coloured = inverse @ (scores @ scores.T) @ inverse
    covariance = np.diag(np.maximum(np.diag(coloured), np.diag(inverse)))
    return inverse @ scores.sum(axis=1), covariance, fits
