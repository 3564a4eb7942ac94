# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How far the velocity field of each joint deserves to be believed."""

from __future__ import annotations

from collections import deque
from itertools import islice
import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from .divided_difference import divided_difference
from .joint_motion import Array
from .wiener_process import TIME_UNIT

NOISE_MEMORY = 0.5
"""Memory of the noise estimates, s."""

BIAS_MEMORY = 0.1
"""Memory of the integral of velocity against position, s."""

RELEASE = 5.0
"""Time in which a velocity that disagreed wins back trust, s."""

COHERENT_LIMIT = 10.0
"""A coherent disagreement beyond this multiple of the white noise: not used."""

CORRELATION_LIMIT = 0.25
"""Squared correlation with differenced position noise beyond which velocity brings no news."""

PAUSE = 0.1
"""A pause in the velocities after which old ones are forgotten, s."""

BLOCK, BLOCK_TIME, LONGEST_BLOCK = 8, 0.02, 64
"""Samples are judged together when there are `BLOCK`, and after the first blocks when these span
`BLOCK_TIME` s too, or there are `LONGEST_BLOCK`."""

FIRST_BLOCKS = 12
"""The blocks from which the noise is first known."""

LARGEST = 1e6
"""Velocities beyond this (rad/s or m/s) count as not measured."""

CHANGE = 2.5
"""The ratio of variances is left as it is while the new one is within this factor."""


class VelocityTrust:
    """
    Noise of position and velocity, and whether the velocity is what it claims to be.

    White noise of both is read from fourth divided differences; a velocity that lags, is filled
    with zeros, or otherwise is not the derivative of the position shows in the leaky integral of
    velocity minus position step; one that the driver merely differenced from the position shows
    in the correlation of the two noises.

    Attributes
    ----------
    lagging, differenced, idle: shape (n,)
        Why a velocity is not used: it disagrees with the positions for longer than noise would
        (late, or wrong); it repeats the noise of differenced positions; it was never non-zero.
    ratio: shape (n,)
        Variance of the velocity's noise over the position's, in scaled units; infinite where the
        velocity is not used. None where no joint's is used.

    """

    def __init__(self, n_joints: int) -> None:
        self.n_joints = n_joints
        zeros = np.zeros(n_joints)
        self._position_noise, self._velocity_noise = zeros, zeros
        self._difference_noise, self._covariance = zeros, zeros
        self._windows = zeros
        self._bias_square = zeros
        self._moved = zeros.astype(bool)
        self.start()

    def start(self) -> None:
        """Begin a run; what is known of the noise stays."""
        self._samples: deque[tuple[float, Array, Array]] = deque(maxlen=LONGEST_BLOCK + 5)
        self._fresh = 0
        self._judged = -math.inf
        self._integral = np.zeros(self.n_joints)
        self._bias_now = np.zeros(self.n_joints)
        self._blocks = 0
        self.ratio: Array | None = None
        self.lagging = self.differenced = self.idle = np.zeros(self.n_joints, bool)

    def push(
        self, stamp: float, position: Array, velocity: Array | None
    ) -> tuple[Array | None, Array | None]:
        """
        Take one sample.

        Returns
        -------
        The velocity with zeros where it is not measured, and `ratio` with infinity there; a pair
        of None if no joint's velocity is of use.

        """
        if velocity is None:
            return None, None
        whole = math.hypot(*velocity.tolist()) < LARGEST
        if not whole:
            velocity = np.where(np.abs(velocity) < LARGEST, velocity, np.nan)
        samples = self._samples
        if samples and stamp - samples[-1][0] > PAUSE:
            samples.clear()
        samples.append((stamp, position, velocity))
        self._fresh += 1
        if self._fresh >= BLOCK and (
                stamp - self._judged >= BLOCK_TIME or self._blocks < FIRST_BLOCKS
                or self._fresh >= LONGEST_BLOCK):
            fresh = min(self._fresh, len(samples) - 5)
            if fresh >= BLOCK:
                self._judge(fresh)
                self._fresh = 0
                self._judged = stamp
        ratio = self.ratio
        if ratio is None:
            return None, None
        if not whole:
            measured = np.isfinite(velocity)
            velocity = np.where(measured, velocity, 0.0)
            if (np.isfinite(ratio) & ~measured).any():
                ratio = np.where(measured, ratio, np.inf)
        return velocity, ratio

    def _judge(self, fresh: int) -> None:
        """Judge the latest samples; those before them serve as neighbours."""
        samples = self._samples
        stamps, positions, velocities = zip(
            *islice(samples, len(samples) - fresh - 5, None))
        t, q, v = np.array(stamps), np.array(positions), np.array(velocities)
        q -= q[-1]
        self._moved = self._moved | (v != 0.0).any(axis=0)
        self._measure_noise(t, q, v)
        self._measure_bias(t[2:], q[2:], v[2:])
        self._blocks += 1
        ratio = self._weigh((t[-1] - t[0]) / (len(t) - 1))
        if not np.isfinite(ratio).any():
            self.ratio = None
        elif self.ratio is None or not _alike(1.0 / ratio, 1.0 / self.ratio):
            self.ratio = ratio

    def _measure_noise(self, t: Array, q: Array, v: Array) -> None:
        """White noise of q, v and of differenced q, from every other window of five."""
        t, q, v, u = t[1:], q[1:], v[1:], np.diff(q, axis=0) / np.diff(t)[:, None]
        c = divided_difference(sliding_window_view(t, 5)[::-2])

        def apply(x: Array) -> Array:
            return np.einsum('wi,wni->wn', c, sliding_window_view(x, 5, axis=0)[::-2])

        dq, du, dv = apply(q), apply(u), apply(v)
        good = (dq != 0.0) & np.isfinite(dv)
        count = good.sum(axis=0)
        self._windows = self._windows + count
        span = t[-1] - t[3]
        gain = np.maximum(1 - math.exp(-span / NOISE_MEMORY), count / np.maximum(self._windows, 1))
        gain = np.where(count > 0, gain, 0.0)
        dq, du, dv = (np.where(good, d, 0.0) for d in (dq, du, dv))
        scale = 1.0 / np.maximum(count, 1)

        def forget(old: Array, products: Array) -> Array:
            return old + gain * (products.sum(axis=0) * scale - old)

        self._position_noise = forget(self._position_noise, dq * dq)
        self._velocity_noise = forget(self._velocity_noise, dv * dv)
        self._difference_noise = forget(self._difference_noise, du * du)
        self._covariance = forget(self._covariance, du * dv)

    def _measure_bias(self, t: Array, q: Array, v: Array) -> None:
        """Leaky integral of v dt - dq; the integral is that of the cubic through four samples."""
        h = np.diff(t)[:, None]
        first = np.diff(v, axis=0) / h
        second = np.diff(first, axis=0) / (h[1:] + h[:-1])
        third = np.diff(second, axis=0) / (h[2:] + h[1:-1] + h[:-2])
        middle, before = h[1:-1], h[:-2]
        integral = (0.5 * middle * (v[1:-2] + v[2:-1]) - middle**3 / 6 * second[:-1]
                    - (middle**4 / 12 + middle**3 * before / 6) * third)
        # The newest interval is judged with the next block, when it has a sample on either side.
        wrong = integral - np.diff(q, axis=0)[1:-1]
        age = np.exp((t[2:-1] - t[-2]) / BIAS_MEMORY)[:, None]
        span = t[-2] - t[1]
        leak = math.exp(-span / BIAS_MEMORY)
        finite = np.isfinite(wrong).all(axis=0)
        self._integral = np.where(
            finite, leak * self._integral + (age * np.where(finite, wrong, 0.0)).sum(axis=0), 0.0)
        bias = self._integral / BIAS_MEMORY
        gain = max(0.5 * (1 - leak), 1.0 / (self._blocks + 1)) * finite
        self._bias_now = self._bias_now + gain * (bias * bias - self._bias_now)
        # Distrust at once, trust again slowly.
        self._bias_square = np.maximum(
            self._bias_now, self._bias_square * math.exp(-span / RELEASE))

    def _weigh(self, period: float) -> Array:
        white = (period / (2 * BIAS_MEMORY) * self._velocity_noise
                 + self._position_noise / BIAS_MEMORY**2)
        coherent = np.maximum(0.0, self._bias_square - 1.5 * white) * (2 * BIAS_MEMORY / period)
        with np.errstate(divide='ignore', invalid='ignore'):
            ratio = (self._velocity_noise + coherent + 1e-18) / (self._position_noise + 1e-20)
        self.lagging = coherent > COHERENT_LIMIT * self._velocity_noise
        self.differenced = (
            self._covariance**2
            > CORRELATION_LIMIT * self._difference_noise * self._velocity_noise)
        self.idle = ~self._moved & (self._windows > 0)
        useless = self.lagging | self.differenced | ~self._moved | (ratio > 1e10)
        useless |= (self._windows == 0) | (self._position_noise <= 0.0)
        return np.where(useless, np.inf, ratio * TIME_UNIT**2)


def _alike(a: Array, b: Array) -> bool:
    """Whether two arrays of weights differ by no more than the factor `CHANGE`; zero is zero."""
    return bool(((a <= CHANGE * b) & (b <= CHANGE * a)).all())
