# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The steps of a filter bank while its gains are kept: few operations, or compiled ones."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
import math

import numpy as np

from .compiled import FLOOR, Kernels, ROWS
from .filter_step import SteadyGains, Step
from .joint_motion import Array
from .wiener_process import SCALE, TIME_UNIT, transition

REWEIGH = 4e-3
"""Time between renewals of the weights while the gains are kept, s; a part of their memory."""

Snapshot = Callable[[], 'tuple[Array, Array, Array, Array]']


def _of_record(record: Array, p: Array) -> tuple[Array, Array, Array, Array]:
    return record[12], record[10], record[4:8], p


class SteadySteps:
    """
    The part of `FilterBank` that runs at a regular clock; shapes are given there.

    Attributes
    ----------
    state: shape (4, n)
        Weighted mean of the filters' states, not scaled; not kept up to date while `remember`.
    kernels:
        Compiled functions to use, if any.
    remember:
        Whether a step has to be returned, because a smoother needs it.

    """

    p: Array
    state: Array

    def __init__(self, n_joints: int, window: float) -> None:
        self.n_joints = n_joints
        self.window = window
        self.kernels: Kernels | None = None
        self.remember = True
        self._physical = np.repeat(1.0 / SCALE[:, None], n_joints, axis=1)
        self._clear()

    def _clear(self) -> None:
        """Forget steps whose weights or arrays are still to be brought home."""
        self._record: Array | None = None
        self._unweighed: list[tuple[float, Array, Array | None]] = []
        self._unweighed_time = 0.0
        self._span = 0.0

    def _bring_home(self, steady: SteadyGains) -> None:
        """Hand over to steps with changing gains."""
        record = self._record
        if record is not None:
            self._x, self._weights = record[4:8], record[12]
            self._noise, self._velocity_noise = record[10], record[11]
            self._record = None
            if self._unweighed_time:
                self._weights = self._weighed(steady)
                self._unweighed_time = 0.0
        elif self._unweighed:
            self._reweigh_steady(steady)

    @property
    def weights(self) -> Array:
        """Weights of the filters for each joint, shape (M, n)."""
        return self._weights if self._record is None else self._record[12]

    def snapshot(self) -> Snapshot:
        """
        Return a function for weights, noise variances, states and covariances as they are now.

        The filters' arrays are never changed in place, so that nothing needs to be copied.
        """
        record, p = self._record, self.p
        if record is not None:
            return partial(_of_record, record, p)
        parts = self._weights, self._noise, self._x, p
        return lambda: parts

    def _steady_step(
        self, steady: SteadyGains, dt: float, position: Array, velocity: Array | None
    ) -> Step | None:
        if self.kernels is not None:
            return self._compiled_step(self.kernels, steady, dt, position, velocity)
        predicted = transition(dt).dot(self._x.reshape(4, -1)).reshape(self._x.shape)
        error = position - predicted[0]
        x = steady.table[:4] * error
        x += predicted
        velocity_error = None
        if velocity is not None and steady.step.velocity is not None:
            velocity_error = velocity * TIME_UNIT - x[1]
            x += steady.velocity_table[:4] * velocity_error
        self._x = x
        self._unweighed.append((dt, error, velocity_error))
        self._unweighed_time += dt
        if self._unweighed_time >= REWEIGH:
            self._reweigh_steady(steady)
        if self.remember:
            return steady.repeated(dt, predicted, error, velocity_error)
        # As one product for each joint: faster than the sum over the middle one of three axes.
        mean = np.matmul(self._weights.T[:, None], x.T)[:, 0].T
        self.state = mean * self._physical
        return None

    def _reweigh_steady(self, steady: SteadyGains) -> None:
        """Do for all steps since the last time at once what `_reweigh` does for one."""
        steps, self._unweighed, self._unweighed_time = self._unweighed, [], 0.0
        shares, share = [], 1.0
        for dt, _, _ in reversed(steps):
            kept = math.exp(-dt / self.window)
            shares.append((1.0 - kept) * share)
            share *= kept
        for dt, _, _ in steps:
            self._span = math.exp(-dt / self.window) * self._span + 1.0
        of_steps = np.array(shares[::-1])

        def mean(old: Array, errors: Array, precision: Array) -> Array:
            errors *= errors
            new = of_steps.dot(errors.reshape(len(steps), -1)).reshape(old.shape)
            new *= precision
            new += share * old
            return new

        self._noise = mean(self._noise, np.array([e for _, e, _ in steps]), steady.table[4])
        if steady.step.velocity is not None:
            self._velocity_noise = mean(
                self._velocity_noise, np.array([e for _, _, e in steps]),
                steady.velocity_table[4])
        self._weights = self._weighed(steady)

    def _weighed(self, steady: SteadyGains) -> Array:
        """Return the weights that follow from the mean squares."""
        score = np.log(self._noise + FLOOR)
        if steady.step.velocity is not None:
            score += steady.velocity_table[5] * np.log(self._velocity_noise + FLOOR)
        score += steady.table[5]
        score -= np.minimum.reduce(score)
        score *= -0.5 * self._span
        weights = np.exp(score, out=score)
        weights /= np.add.reduce(weights)
        return weights

    def _compiled_step(
        self, kernels: Kernels, steady: SteadyGains, dt: float, position: Array,
        velocity: Array | None,
    ) -> Step | None:
        old = self._record
        if old is None:
            old = np.empty((ROWS, *self.weights.shape))
            old[4:8], old[10], old[11] = self._x, self._noise, self._velocity_noise
            old[12] = self._weights
        self._record = new = np.empty(old.shape)
        self.state = state = np.empty((4, self.n_joints))
        keep = math.exp(-dt / self.window)
        self._span = span = keep * self._span + 1.0
        self._unweighed_time += dt
        if self._unweighed_time < REWEIGH:
            span = 0.0
        else:
            self._unweighed_time = 0.0
        kernels.steady_step(
            old, new, state, steady.table, steady.velocity_table, position,
            position if velocity is None else velocity, dt / TIME_UNIT, 1.0 - keep, span,
            TIME_UNIT)
        if not self.remember:
            return None
        return steady.repeated(
            dt, new[:4], new[8], None if steady.step.velocity is None else new[9])
