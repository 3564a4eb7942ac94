# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A bank of Kalman filters of different bandwidths that weigh themselves by likelihood."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
import math
from typing import Any

import numpy as np

from screw_kinematics.motion.joint_motion import Array
from screw_kinematics.motion.wiener_process import process_noise, SCALE, TIME_UNIT, transition

BANDWIDTHS = {4: tuple(1.5 * 1.6**k for k in range(12)), 3: (30.0, 60.0, 120.0)}
"""Bandwidths of the filters by order of their motion model, Hz."""

DENSITY_CAP = {4: (2.5e10, 7), 3: (2e9, 5)}
"""Largest process density by order: value / dt**power; beyond it a filter is dead-beat."""

PRIOR_DEVIATION = np.array([1.0, 2e5, 1.5e6, 3e7])
"""Prior deviation of (q, q', q'', q''') in units of the position noise, per s, s^2, s^3."""

FLOOR = 1e-26
"""Added to mean squares before their logarithm, rad^2: far below any measured noise."""


class FilterBank:
    """
    Integrated-Wiener Kalman filters side by side, for all joints at once.

    Nobody has to enter a noise level: all covariances are in units of the unknown variance R of
    a joint's position noise, so that a filter is defined by its bandwidth alone, and the weight
    of each filter is its concentrated likelihood, in which R has been replaced by its estimate.

    Shapes: M filters, n joints; states (4, M, n), covariances (4, 4, M, n) (last axis 1 while
    no velocity is used, because position-only gains are the same for all joints).

    """

    def __init__(
        self, n_joints: int, bandwidths: Mapping[int, Sequence[float]], window: float
    ) -> None:
        self.n_joints = n_joints
        self.window = window
        order = np.array([n for n, f in bandwidths.items() for _ in f])
        omega = 2 * np.pi * np.array([f for fs in bandwidths.values() for f in fs])
        self._groups = [(n, order == n, omega ** (2 * n)) for n in bandwidths]
        self._first = (order == 4).astype(float)
        self.n_filters = len(order)

    def start(self, position: Array) -> None:
        """Begin a run at a position."""
        m, n = self.n_filters, self.n_joints
        self.x = np.zeros((4, m, n))
        self.x[0] = position
        self.p = np.zeros((4, 4, m, 1))
        for i in range(4):
            self.p[i, i] = (PRIOR_DEVIATION[i] * SCALE[i]) ** 2
        self.p[3, 3, :, 0] *= self._first
        self.noise = np.zeros((m, n))
        self.velocity_noise = np.ones((m, n))
        self._log_s = np.zeros((m, 1))
        self._log_s_velocity = np.zeros((m, 1))
        self._span = 0.0
        self._steps = 0
        self.weights = np.full((m, n), 1 / m)

    def step(
        self, dt: float, nominal_dt: float, position: Array, velocity: Array | None,
        ratio: Array | None,
    ) -> tuple[Any, ...]:
        """
        Predict by `dt`, update with a sample, reweigh.

        Parameters
        ----------
        dt, nominal_dt:
            Time since the last sample and its mean, s.
        position, velocity: shape (n,)
            Measured, in physical units; the velocity finite, or None with `ratio`.
        ratio: shape (n,)
            Variance of the velocity's noise over that of the position, in scaled units; infinite
            for joints whose velocity is not used; None where no joint's is.

        Returns
        -------
        What the fixed-lag smoother needs to know of this step.

        """
        m, n = self.n_filters, self.n_joints
        f = transition(dt)
        x = f.dot(self.x.reshape(4, -1)).reshape(4, m, n)
        p = self._predict_covariance(f, dt, nominal_dt)
        if ratio is not None and p.shape[3] == 1:
            p = np.repeat(p, n, axis=3)
        predicted = (x, p)

        s = p[0, 0] + 1.0
        gain = p[:, 0] / s
        error = position - x[0]
        x = x + gain * error
        p = p - gain[:, None] * p[0]
        p[0] = gain                    # exact for R = 1, and better conditioned
        p[:, 0] = gain
        forget = max(1.0 - math.exp(-dt / self.window), 1.0 / (self._steps + 1))
        weighted = error / s
        self.noise = self.noise + forget * (error * weighted - self.noise)
        self._log_s = self._log_s + forget * (np.log(s) - self._log_s)
        score = np.log(self.noise + FLOOR) + self._log_s
        velocity_gain = velocity_weighted = None
        if velocity is not None and ratio is not None:
            log_s = np.log1p(p[1, 1] / ratio)
            s = p[1, 1] + ratio
            velocity_gain = p[:, 1] / s
            error = velocity * TIME_UNIT - x[1]
            x = x + velocity_gain * error
            p = p - velocity_gain[:, None] * p[1]
            velocity_weighted = error / s
            self.velocity_noise = self.velocity_noise + forget * (
                error * velocity_weighted - self.velocity_noise)
            self._log_s_velocity = self._log_s_velocity + forget * (
                log_s - self._log_s_velocity)
            score = score + np.isfinite(ratio) * (
                np.log(self.velocity_noise + FLOOR) + self._log_s_velocity)
        if self._steps % 16 == 15:
            p = 0.5 * (p + p.transpose(1, 0, 2, 3))
        self.x, self.p = x, p
        self._span = (1.0 - forget) * self._span + 1.0
        self._steps += 1
        self._weigh(score)
        return (f, *predicted, gain, weighted, velocity_gain, velocity_weighted)

    def _predict_covariance(self, f: Array, dt: float, nominal_dt: float) -> Array:
        shape = self.p.shape
        p = f.dot(self.p.reshape(4, -1)).reshape(shape).transpose(1, 0, 2, 3)
        p = f.dot(p.reshape(4, -1)).reshape(shape)
        for order, members, power in self._groups:
            cap, exponent = DENSITY_CAP[order]
            density = np.minimum(power * nominal_dt, cap / dt**exponent) * members
            p += (process_noise(order, dt)[:, :, None] * density)[..., None]
        return p

    def _weigh(self, score: Array) -> None:
        score = score - score.min(axis=0)
        weights = np.exp(-0.5 * self._span * score)
        self.weights = weights / weights.sum(axis=0)


def combine(weights: Array, x: Array) -> Array:
    """Return the weighted mean of the filters' states in physical units, shape (4, n)."""
    return np.einsum('mn,kmn->kn', weights, x) / SCALE[:, None]


def mixture_covariance(weights: Array, x: Array, p: Array, noise: Array) -> Callable[[], Array]:
    """Return a function for the covariance within and between the filters, (n, 4, 4)."""
    def covariance() -> Array:
        apart = x - np.einsum('mn,kmn->kn', weights, x)[:, None]
        full = np.broadcast_to(p, (4, 4, *x.shape[1:]))
        within = np.einsum('mn,ijmn->nij', weights * noise, full)
        between = np.einsum('mn,imn,jmn->nij', weights, apart, apart)
        return (within + between) / np.outer(SCALE, SCALE)
    return covariance


class FixedLag:
    """
    Fixed-lag smoothing: the filters' states at an instant `delay` ago, given all since.

    The weighted innovations of the samples since that instant are carried back by the adjoint
    recursion to the state predicted there.

    References
    ----------
    G. J. Bierman, "Fixed interval smoothing with discrete measurements", Int. J. Control 18
    (1973) 65-75 (the modified Bryson-Frazier form, which inverts no covariance).

    """

    def __init__(self, delay: float) -> None:
        self.delay = delay
        self._steps: deque[tuple[float, tuple[Any, ...]]] = deque()

    def start(self) -> None:
        """Forget the run."""
        self._steps.clear()

    def push(self, stamp: float, step: tuple[Array, ...]) -> None:
        """Remember one step of the bank."""
        self._steps.append((stamp, step))

    def smooth(self, stamp: float) -> tuple[float, Array, Array] | None:
        """Return (time, states, covariances of the filters) at the last sample up to `stamp`."""
        steps = self._steps
        while len(steps) > 1 and steps[1][0] <= stamp + 1e-9:
            steps.popleft()
        if not steps or steps[0][0] > stamp + 1e-9:
            return None
        adjoint = np.zeros_like(steps[0][1][1])
        for _, (f, x, p, gain, weighted, velocity_gain, velocity_weighted) in reversed(steps):
            if velocity_gain is not None:
                adjoint[1] += velocity_weighted - (velocity_gain * adjoint).sum(axis=0)
            adjoint[0] += weighted - (gain * adjoint).sum(axis=0)
            before = adjoint
            adjoint = f.T.dot(adjoint.reshape(4, -1)).reshape(x.shape)
        time, (f, x, p, *_) = steps[0]
        return time, x + (p * before).sum(axis=1), p
