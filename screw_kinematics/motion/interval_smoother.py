# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Fixed-interval smoothing of many pieces of a recording side by side."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from screw_kinematics.motion.filter_bank import DENSITY_CAP, FLOOR, PRIOR_DEVIATION
from screw_kinematics.motion.joint_motion import Array
from screw_kinematics.motion.wiener_process import NOISE_TERMS, SCALE, TIME_UNIT

BANDWIDTHS = 1.5 * 2.1 ** np.arange(7)
"""Bandwidths of the filters, Hz; smoothing asks less of them than filtering."""

WINDOW = 0.1
"""Memory of the likelihood to either side of an instant, s."""

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


class _Smoother:
    """
    Modified Bryson-Frazier smoother for C pieces of T samples with M filters of n joints.

    States have shape (4, M, C, n), covariances (4, 4, M, C, g) with g = 1, or n with velocities.
    """

    def __init__(
        self, t: Array, q: Array, v: Array | None, ratio: Array | None, valid: Array
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
        self.gain = np.empty((len(self.channels), length, 4, m, pieces, g))
        self.weighted = np.empty((len(self.channels), length, m, pieces, n))
        self.precision = np.empty((len(self.channels), length, m, pieces, g))
        self.past = np.empty((len(self.channels), length, m, pieces, n))
        self.log_s = np.empty((len(self.channels), length, m, pieces, g))
        self.span = np.empty((length, pieces, 1))

    def run(self) -> tuple[Array, Array]:
        """Return states and variances in physical units, shapes (T, 4, C, n)."""
        self._forward()
        return self._backward()

    def _forward(self) -> None:
        length, pieces, n = self.q.shape
        x = np.zeros(self.x.shape[1:])
        x[0] = self.q[0]
        p = np.zeros(self.p.shape[1:])
        for i in range(4):
            p[i, i] = (PRIOR_DEVIATION[i] * SCALE[i]) ** 2
        coefficient, exponent = NOISE_TERMS[4]
        cap, power = DENSITY_CAP[4]
        square = np.zeros(self.past.shape[:1] + self.past.shape[2:])
        log_s = np.zeros(self.log_s.shape[:1] + self.log_s.shape[2:])
        span = np.zeros((pieces, 1))
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
            forget = (1.0 - np.exp(-dt / WINDOW) if k else np.ones(pieces))[:, None]
            span = (1.0 - forget) * span + self.valid[k][:, None]
            self.span[k] = span
            for c, (i, measured, variance) in enumerate(self.channels):
                spread = p[i, i]
                precision = self.valid[k][:, None] / (spread + variance)
                gain = p[:, i] * precision
                error = measured[k] - x[i]
                self.gain[c, k], self.precision[c, k] = gain, precision
                self.weighted[c, k] = weighted = error * precision
                share = forget if k > 8 else max(1.0 / (k + 1), 0.0)
                square[c] += share * (error * weighted - square[c])
                log_s[c] += share * (np.log1p(spread / variance) - log_s[c])
                self.past[c, k], self.log_s[c, k] = square[c], log_s[c]
                x = x + gain * error
                p = p - gain[:, None] * p[i]
            p = 0.5 * (p + p.swapaxes(0, 1))

    def _backward(self) -> tuple[Array, Array]:
        length, pieces, n = self.q.shape
        state = np.empty((length, 4, pieces, n))
        variance = np.empty_like(state)
        adjoint = np.zeros(self.x.shape[1:])
        information = np.zeros(self.p.shape[1:])
        square = np.zeros(self.past.shape[:1] + self.past.shape[2:])
        log_s = np.zeros(self.log_s.shape[:1] + self.log_s.shape[2:])
        span = np.zeros((pieces, 1))
        for k in range(length - 1, -1, -1):
            x, p = self.x[k], self.p[k]
            weights, noise = self._weigh(k, square, log_s, span)
            for c in reversed(range(len(self.channels))):
                i = self.channels[c][0]
                gain, precision = self.gain[c, k], self.precision[c, k]
                adjoint[i] += self.weighted[c, k] - (gain * adjoint).sum(axis=0)
                information[i] -= (gain[:, None] * information).sum(axis=0)
                information[:, i] -= (gain * information).sum(axis=1)
                information[i, i] += precision
            smoothed = x + (p * adjoint).sum(axis=1)
            mean = (weights * smoothed).sum(axis=1)
            state[k] = mean
            carried = (p[:, :, None] * information[None]).sum(axis=1)
            within = np.stack([p[i, i] - (carried[i] * p[:, i]).sum(axis=0) for i in range(4)])
            apart = smoothed - mean[:, None]
            variance[k] = (weights * (np.maximum(within, 0.0) * noise + apart * apart)).sum(axis=1)
            # What follows an instant weighs as much as what precedes it.
            forget = (1.0 - np.exp(-self.dt[k] / WINDOW) if k else np.ones(pieces))[:, None]
            forget = np.where(span > 0, forget, 1.0) * self.valid[k][:, None]
            span = (1.0 - forget) * span + self.valid[k][:, None]
            for c in range(len(self.channels)):
                error_square = self.weighted[c, k] ** 2 / np.maximum(self.precision[c, k], 1e-300)
                square[c] += forget * (error_square - square[c])
                log_s[c] += forget * (self._log_s_at(c, k) - log_s[c])
            if k:
                r = (self.dt[k] / TIME_UNIT)[:, None]
                _propagate_back(adjoint, r)
                _propagate_back(information, r)
                information = information.swapaxes(0, 1)
                _propagate_back(information, r)
        scale = 1.0 / SCALE[:, None, None]
        return state * scale, variance * scale**2

    def _log_s_at(self, c: int, k: int) -> Array:
        i, _, variance = self.channels[c]
        return np.log1p(self.p[k, i, i] / variance)  # type: ignore[no-any-return]

    def _weigh(
        self, k: int, square: Array, log_s: Array, span: Array
    ) -> tuple[Array, Array]:
        """Return weights and noise variances from the likelihood on both sides of sample k."""
        before = self.span[k]
        both = np.maximum(before + span, 1e-9)
        score: Array = np.zeros(self.past.shape[2:])
        for c in range(len(self.channels)):
            mean = (before * self.past[c, k] + span * square[c]) / both
            log_mean = (before * self.log_s[c, k] + span * log_s[c]) / both
            used = 1.0 if c == 0 or self.ratio is None else np.isfinite(self.ratio)
            score = score + used * (np.log(mean + FLOOR) + log_mean)
            if c == 0:
                noise = mean
        score = score - score.min(axis=0)
        weights = np.exp(-0.5 * both * score)
        return weights / weights.sum(axis=0), noise
