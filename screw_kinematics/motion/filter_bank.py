# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A bank of Kalman filters of different bandwidths that weigh themselves by likelihood."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import math

import numpy as np

from .filter_step import Innovation, SteadyGains, Step
from .joint_motion import Array
from .steady_steps import FLOOR, SteadySteps
from .wiener_process import process_noise, SCALE, TIME_UNIT, transition

BANDWIDTHS = {4: tuple(1.5 * 1.6**k for k in range(12)), 3: (30.0, 60.0, 120.0)}
"""Bandwidths of the filters by order of their motion model, Hz."""

DENSITY_CAP = {4: (2.5e10, 7), 3: (2e9, 5)}
"""Largest process density by order: value / dt**power; beyond it a filter is dead-beat."""

PRIOR_DEVIATION = np.array([1.0, 2e5, 1.5e6, 3e7])
"""Prior deviation of (q, q', q'', q''') in units of the position noise, per s, s^2, s^3."""

CHECK = 8
"""Steps between looks at the gains."""

CONVERGED = 3e-3
"""Gains that change by less than this over `CHECK` steps are kept, ..."""

RETURNED = 1e-2
"""... and come back into use after a missing sample when they are met again this closely."""


def _close(a: Array, b: Array, tolerance: float) -> bool:
    return a.shape == b.shape and bool((np.abs(a - b) <= tolerance * np.abs(b)).all())


class FilterBank(SteadySteps):
    """
    Integrated-Wiener Kalman filters side by side, for all joints at once.

    Nobody has to enter a noise level: all covariances are in units of the unknown variance R of
    a joint's position noise, so that a filter is defined by its bandwidth alone, and the weight
    of each filter is its concentrated likelihood, in which R has been replaced by its estimate.

    Shapes: M filters, n joints; states (4, M, n), covariances (4, 4, M, g) with g = n, or 1
    while no velocity is used, because position-only gains are the same for all joints.

    Parameters
    ----------
    n_joints:
        Number of joints.
    bandwidths:
        Bandwidths of the filters in Hz by order of their model.
    window:
        Memory of the likelihood, s.
    keep_gains:
        Whether converged gains are kept at a regular clock; without, results are the same to
        about 1e-3 of the estimate's own deviation, and cost three times as much.

    """

    def __init__(
        self, n_joints: int, bandwidths: Mapping[int, Sequence[float]], window: float,
        keep_gains: bool = True,
    ) -> None:
        order = np.array([n for n, f in bandwidths.items() for _ in f])
        super().__init__(n_joints, len(order), window)
        self.keep_gains = keep_gains
        omega = 2 * np.pi * np.array([f for fs in bandwidths.values() for f in fs])
        self._groups = [(n, order == n, omega ** (2 * n)) for n in bandwidths]
        self._has_jerk = (order == 4).astype(float)
        self.steady: SteadyGains | None = None
        self._kept: SteadyGains | None = None
        self._checked: Array | None = None

    def start(self, position: Array) -> None:
        """Begin a run at a position."""
        self.steady = None
        self._checked = None
        self._clear()
        m, n = self.n_filters, self.n_joints
        self._x = np.zeros((4, m, n))
        self._x[0] = position
        self.p = np.zeros((4, 4, m, 1))
        for i in range(4):
            self.p[i, i] = (PRIOR_DEVIATION[i] * SCALE[i]) ** 2
        self.p[3, 3, :, 0] *= self._has_jerk
        self._noise = np.zeros((m, n))
        self._velocity_noise = np.zeros((m, n))
        self._ratio: Array | None = None
        self._used = np.zeros(n, bool)
        self._log_s = np.zeros((m, 1))
        self._log_s_velocity = np.zeros((m, 1))
        self._alone = self._noise, self._log_s
        self._steps = 0
        self.weights = np.full((m, n), 1 / m)

    def release(self) -> None:
        """Let the gains go again."""
        steady = self.steady
        if steady is not None:
            if self._unweighed_time:
                self._reweigh_steady(steady)
            self._log_s, self._log_s_velocity = steady.log_s, steady.log_s_velocity
        self.steady = None
        self._checked = None

    def step(
        self, dt: float, period: float, reference: float, position: Array,
        velocity: Array | None, ratio: Array | None,
    ) -> Step | None:
        """
        Predict by `dt`, update with a sample, reweigh.

        Parameters
        ----------
        dt, period:
            Time since the last sample and its mean, s.
        reference:
            The period for which gains may converge, s; 0 while sampling is irregular.
        position, velocity: shape (n,)
            Measured; the velocity finite, or None with `ratio`.
        ratio: shape (n,)
            Variance of the velocity's noise over that of the position, in scaled units; infinite
            for joints whose velocity is not used; None where no joint's is.

        """
        self._steps += 1
        if not self.keep_gains:
            reference = 0.0
        steady = self.steady
        if steady is not None:
            if (ratio is steady.ratio and reference == steady.reference
                    and 0.5 * reference < dt < 1.5 * reference):
                return self._steady_step(steady, dt, position, velocity)
            self.release()
        if ratio is not self._ratio:
            self._expect(ratio)
        f = transition(dt)
        x = f.dot(self._x.reshape(4, -1)).reshape(self._x.shape)
        if ratio is not None and self.p.shape[3] == 1:
            self.p = np.repeat(self.p, self.n_joints, axis=3)
        if 0.5 * reference < dt < 1.5 * reference:
            p = self._predict_covariance(transition(reference), reference, reference)
        else:
            p = self._predict_covariance(f, dt, reference or period)
        step = self._update(dt, x, p, position, velocity, ratio)
        self._reweigh(step, dt, ratio)
        if reference and self._steps % CHECK == 0:
            self._settle(step, reference, ratio)
        return step if self.remember else None

    def _expect(self, ratio: Array | None) -> None:
        """
        Be ready for velocities of other joints than before.

        With velocities all filters follow the positions well, so that these tell little about
        the bandwidth. Once the velocity of a joint is dropped, its filters are compared as they
        were before it was used; else those that are too lively without it would rule for a
        while. The mean squares of a velocity that was not used have faded: they go on from the
        noise that is expected, the same for all filters, for else one innovation would decide.
        """
        used = np.zeros(self.n_joints, bool) if ratio is None else np.isfinite(ratio)
        dropped, adopted = self._used & ~used, used & ~self._used
        self._ratio, self._used = ratio, used
        noise, log_s = self._alone
        self._alone = (
            np.where(adopted, self._noise, noise), np.where(adopted, self._log_s, log_s))
        if dropped.any():
            self._noise = np.where(dropped, noise, self._noise)
            self._log_s = np.where(dropped, log_s, self._log_s)
        missing = (self.weights * (self._noise - self._velocity_noise)).sum(axis=0)
        self._velocity_noise = self._velocity_noise + np.maximum(missing, 0.0)

    def _predict_covariance(self, f: Array, dt: float, period: float) -> Array:
        shape = self.p.shape
        p = f.dot(self.p.reshape(4, -1)).reshape(shape).transpose(1, 0, 2, 3)
        p = f.dot(p.reshape(4, -1)).reshape(shape)
        for order, members, power in self._groups:
            cap, exponent = DENSITY_CAP[order]
            density = np.minimum(power * period, cap / dt**exponent) * members
            p += (process_noise(order, dt)[:, :, None] * density)[..., None]
        return p

    def _update(
        self, dt: float, x: Array, p: Array, position: Array, velocity: Array | None,
        ratio: Array | None,
    ) -> Step:
        predicted = (dt, x, p)
        precision = 1.0 / (p[0, 0] + 1.0)
        gain = p[:, 0] * precision
        error = position - x[0]
        x = x + gain * error
        p = p - gain[:, None] * p[0]
        p[0] = gain                    # exact for R = 1, and better conditioned
        p[:, 0] = gain
        of_position, of_velocity = Innovation(gain, precision, error), None
        if velocity is not None and ratio is not None:
            self._spread = p[1, 1] / ratio
            precision = 1.0 / (p[1, 1] + ratio)
            gain = p[:, 1] * precision
            error = velocity * TIME_UNIT - x[1]
            x = x + gain * error
            p = p - gain[:, None] * p[1]
            of_velocity = Innovation(gain, precision, error)
        if self._steps % CHECK == 0:
            p = 0.5 * (p + p.transpose(1, 0, 2, 3))
        self._x, self.p = x, p
        return Step(*predicted, of_position, of_velocity)

    def _reweigh(self, step: Step, dt: float, ratio: Array | None) -> None:
        """Move the forgetful means of the likelihood's terms; turn them into weights."""
        forget = max(1.0 - math.exp(-dt / self.window), 1.0 / self._steps)
        self._span = (1.0 - forget) * self._span + 1.0
        _, precision, error = step.position
        self._noise = self._noise + forget * (error**2 * precision - self._noise)
        self._log_s = self._log_s - forget * (np.log(precision) + self._log_s)
        score = np.log(self._noise + FLOOR) + self._log_s
        if step.velocity is not None and ratio is not None:
            _, precision, error = step.velocity
            self._velocity_noise = self._velocity_noise + forget * (
                error**2 * precision - self._velocity_noise)
            self._log_s_velocity = self._log_s_velocity + forget * (
                np.log1p(self._spread) - self._log_s_velocity)
            score = score + np.isfinite(ratio) * (
                np.log(self._velocity_noise + FLOOR) + self._log_s_velocity)
        score = score - score.min(axis=0)
        weights = np.exp(-0.5 * self._span * score)
        self.weights = weights = weights / weights.sum(axis=0)
        self.state = np.einsum('mn,kmn->kn', weights, self._x) * self._physical

    def _settle(self, step: Step, reference: float, ratio: Array | None) -> None:
        """Keep the gains if they have converged."""
        gain = step.position.gain if step.velocity is None else np.stack(
            [step.position.gain, step.velocity.gain])
        kept = self._kept
        if kept is not None and kept.reference == reference and kept.ratio is ratio:
            if _close(gain, kept.gains, RETURNED):
                self.steady = kept
            return
        last, self._checked = self._checked, gain
        if last is None or not _close(gain, last, CONVERGED):
            return
        log_s = -np.log(step.position.precision)
        log_s_velocity = np.zeros((1, 1)) if ratio is None else np.log1p(self._spread)
        used = 0.0 if ratio is None else np.isfinite(ratio).astype(float)
        table = self._table(step.position, log_s + used * log_s_velocity)
        velocity_table = np.empty((0, *table.shape[1:]))
        if step.velocity is not None:
            velocity_table = self._table(step.velocity, used)
        self.steady = self._kept = SteadyGains(
            reference, ratio, step, gain, log_s, log_s_velocity, table, velocity_table,
            *(t.reshape(len(t), table[0].size)[:4] for t in (table, velocity_table)))

    def _table(self, innovation: Innovation, last: Array | float) -> Array:
        """Return gains, precision and one more row for each filter and joint."""
        table = np.empty((6, self.n_filters, self.n_joints))
        table[:4], table[4], table[5] = innovation.gain, innovation.precision, last
        return table
