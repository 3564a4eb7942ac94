# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Fixed-interval smoothing of many pieces of a recording side by side."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from .filter_bank import DENSITY_CAP, PRIOR_DEVIATION
from .joint_motion import Array
from .steady_steps import FLOOR
from .wiener_process import NOISE_TERMS, SCALE, TIME_UNIT

BANDWIDTHS = 1.5 * 1.8 ** np.arange(9)
"""Bandwidths of the filters, Hz; smoothing asks less of them than filtering."""

WINDOW = 0.1
"""How far to either side of an instant the filters are compared, s."""

Piece = tuple[int, int, int, int]


def smooth_batch(
    times: Array, positions: Array, velocities: Array | None, ratio: Array | None,
    pieces: Sequence[Piece],
) -> Iterator[tuple[Array, Array]]:
    """
    Smooth some pieces of a recording.

    Parameters
    ----------
    times, positions, velocities: shapes (N,), (N, n), (N, n)
        The recording; the velocities finite where `ratio` is.
    ratio: shape (n,)
        Variance of the velocity's noise over the position's, scaled; infinite where not used.
    pieces:
        Begin and end of each piece are its first and last number.

    Yields
    ------
    State and variance of each piece, shapes (length, 4, n).

    """
    lengths = [piece[3] - piece[0] for piece in pieces]
    index = np.array([
        np.minimum(np.arange(max(lengths)), length - 1) + piece[0]
        for piece, length in zip(pieces, lengths)]).T
    valid = np.arange(max(lengths))[:, None] < np.array(lengths)
    q = positions[index]
    offset = q[0].copy()
    t = times[index]
    v = None
    if velocities is not None and ratio is not None:
        v = np.where(np.isfinite(ratio), velocities, 0.0)[index] * TIME_UNIT
    state, variance = _Smoother(t, q - offset, v, ratio, valid).run()
    state[:, 0] += offset
    for i, length in enumerate(lengths):
        yield state[:length, :, i], variance[:length, :, i]


def _propagate(x: Array, r: Array) -> None:
    """Apply the transition over r time units to the first axis of x, in place."""
    x[0] += r * (x[1] + r * (x[2] + r * x[3]))
    x[1] += r * (2.0 * x[2] + 3.0 * r * x[3])
    x[2] += 3.0 * r * x[3]


def _propagate_back(x: Array, r: Array) -> None:
    """Apply the transposed transition to the first axis of x, in place."""
    x[3] += r * (3.0 * x[2] + r * (3.0 * x[1] + r * x[0]))
    x[2] += r * (2.0 * x[1] + r * x[0])
    x[1] += r * x[0]


def _around(x: Array, share: Array) -> Array:
    """Return at each instant the sum over time of x, fading to either side by `share` a step."""
    total = x.copy()
    for order in (range(len(x)), range(len(x) - 1, -1, -1)):
        faded = np.zeros_like(x[0])
        for k in order:
            if order.step > 0:
                faded *= share[k]
            total[k] += faded
            faded += x[k]
            if order.step < 0:
                faded *= share[k]
    return total


class _Smoother:
    """
    Modified Bryson-Frazier smoother for C pieces of T samples with M filters of n joints.

    States have shape (4, M, C, n), covariances (4, 4, M, C, g) with g = 1, or n with velocities.
    """

    def __init__(
        self, t: Array, q: Array, v: Array | None, ratio: Array | None,
        valid: NDArray[np.bool_],
    ) -> None:
        self.q, self.v, self.ratio, self.valid = q, v, ratio, valid
        self.dt = np.diff(t, axis=0, prepend=t[:1])
        samples = valid.sum(axis=0)
        period = (t[-1] - t[0]) / np.maximum(samples - 1, 1)
        omega = 2 * np.pi * BANDWIDTHS[:, None]
        self.density = omega**8 * period
        length, pieces, n = q.shape
        m, g = len(BANDWIDTHS), 1 if v is None else n
        self.x = np.empty((length, 4, m, pieces, n))
        self.p = np.empty((length, 4, 4, m, pieces, g))
        self.channels = [(0, q, np.ones(1))] if v is None or ratio is None else [
            (0, q, np.ones(1)), (1, v, ratio)]
        self.variance = np.empty((length, 4, m, pieces, g))
        self.gain = np.empty((len(self.channels), length, 4, m, pieces, g))
        self.weighted = np.empty((len(self.channels), length, m, pieces, n))
        self.precision = np.empty((len(self.channels), length, m, pieces, g))

    def run(self) -> tuple[Array, Array]:
        """Return states and variances in physical units, shapes (T, 4, C, n)."""
        self._forward()
        self._backward()
        return self._mix()

    def _forward(self) -> None:
        """Filter; remember predictions, gains and innovations."""
        length = len(self.q)
        x = np.zeros(self.x.shape[1:])
        x[0] = self.q[0]
        p = np.zeros(self.p.shape[1:])
        for i in range(4):
            p[i, i] = (PRIOR_DEVIATION[i] * SCALE[i]) ** 2
        coefficient, exponent = NOISE_TERMS[4]
        cap, power = DENSITY_CAP[4]
        for k in range(length):
            dt = self.dt[k]
            if k:
                r = (dt / TIME_UNIT)[:, None]
                _propagate(x, r)
                _propagate(p, r)
                p = p.swapaxes(0, 1)
                _propagate(p, r)
                noise = coefficient[:, :, None] * dt ** exponent[:, :, None]
                density = np.minimum(self.density, cap / np.maximum(dt, 1e-9) ** power)
                p = p + (noise[:, :, None] * density)[..., None]
            self.x[k], self.p[k] = x, p
            for c, (i, measured, variance) in enumerate(self.channels):
                precision = self.valid[k][:, None] / (p[i, i] + variance)
                gain = p[:, i] * precision
                error = measured[k] - x[i]
                self.gain[c, k], self.precision[c, k] = gain, precision
                self.weighted[c, k] = error * precision
                x = x + gain * error
                p = p - gain[:, None] * p[i]
            p = 0.5 * (p + p.swapaxes(0, 1))

    def _backward(self) -> None:
        """Replace predicted by smoothed states, and find their variances."""
        adjoint = np.zeros(self.x.shape[1:])
        information = np.zeros(self.p.shape[1:])
        for k in range(len(self.x) - 1, -1, -1):
            p = self.p[k]
            for c in reversed(range(len(self.channels))):
                i = self.channels[c][0]
                gain, precision = self.gain[c, k], self.precision[c, k]
                adjoint[i] += self.weighted[c, k] - (gain * adjoint).sum(axis=0)
                information[i] -= (gain[:, None] * information).sum(axis=0)
                information[:, i] -= (gain * information).sum(axis=1)
                information[i, i] += precision
            self.x[k] += (p * adjoint).sum(axis=1)
            carried = (p[:, :, None] * information[None]).sum(axis=1)
            for i in range(4):
                self.variance[k, i] = p[i, i] - (carried[i] * p[:, i]).sum(axis=0)
            if k:
                r = (self.dt[k] / TIME_UNIT)[:, None]
                _propagate_back(adjoint, r)
                _propagate_back(information, r)
                information = information.swapaxes(0, 1)
                _propagate_back(information, r)

    def _mix(self) -> tuple[Array, Array]:
        """Weigh the filters by how well they predicted the samples around each instant."""
        share = (np.exp(-self.dt / WINDOW) * self.valid)[:, :, None]
        span = np.maximum(_around(self.valid[:, :, None].astype(float), share), 1e-9)[:, None]
        score: Array = np.zeros(self.weighted.shape[1:])
        for c in reversed(range(len(self.channels))):
            known = np.where(self.precision[c] > 0, self.precision[c], 1.0)
            noise = _around(self.weighted[c] ** 2 / known, share) / span
            fresh = np.log(noise + FLOOR) - _around(np.log(known), share) / span
            score += fresh if c == 0 or self.ratio is None else np.where(
                np.isfinite(self.ratio), fresh, 0.0)
        score -= score.min(axis=1, keepdims=True)
        score *= -0.5 * span
        weights = np.exp(score)
        weights /= weights.sum(axis=1, keepdims=True)
        last = len(self.dt) - 1
        state = np.empty((last + 1, 4, *self.q.shape[1:]))
        variance = np.empty_like(state)
        for i in range(4):
            x = self.x[:, i]
            mean = (weights * x).sum(axis=1)
            x -= mean[:, None]
            spread = np.maximum(self.variance[:, i], 0.0) * noise + x * x
            state[:, i] = mean / SCALE[i]
            variance[:, i] = (weights * spread).sum(axis=1) / SCALE[i] ** 2
        return state, variance
