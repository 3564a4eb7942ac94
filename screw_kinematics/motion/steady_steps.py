# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The steps of a filter bank while its gains are kept: few operations, or compiled ones."""

from __future__ import annotations

from collections.abc import Callable
import math

import numpy as np

from screw_kinematics.motion.compiled import Kernels, ROWS
from screw_kinematics.motion.filter_step import Innovation, SteadyGains, Step
from screw_kinematics.motion.joint_motion import Array
from screw_kinematics.motion.wiener_process import TIME_UNIT, transition

FLOOR = 1e-26
"""Added to mean squares before their logarithm, rad^2: far below any measured noise."""

REWEIGH = 4e-3
"""Time between renewals of the weights while the gains are kept, s; a part of their memory."""

Snapshot = Callable[[], 'tuple[Array, Array, Array, Array]']


class SteadySteps:
    """
    The part of `FilterBank` that runs at a regular clock; shapes are given there.

    Attributes
    ----------
    mean: shape (4, n)
        Weighted mean of the filters' scaled states.
    kernels:
        Compiled functions to use, if any.
    remember:
        Whether a step has to be returned, because a smoother needs it.

    """

    p: Array
    mean: Array

    def __init__(self, n_joints: int, window: float) -> None:
        self.n_joints = n_joints
        self.window = window
        self.kernels: Kernels | None = None
        self.remember = True
        self._clear()

    def _clear(self) -> None:
        """Forget steps whose weights or arrays are still to be brought home."""
        self._record: Array | None = None
        self._unweighed: list[tuple[float, Step]] = []
        self._unweighed_time = 0.0
        self._span = 0.0

    def _bring_home(self, steady: SteadyGains) -> None:
        """Hand over to steps with changing gains."""
        record = self._record
        if record is not None:
            self._x, self._weights = record[4:8], record[12]
            self._noise, self._velocity_noise = record[10], record[11]
            self._record = None
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
            return lambda: (record[12], record[10], record[4:8], p)
        parts = self._weights, self._noise, self._x, p
        return lambda: parts

    def _steady_step(
        self, steady: SteadyGains, dt: float, position: Array, velocity: Array | None
    ) -> Step | None:
        if self.kernels is not None:
            return self._compiled_step(self.kernels, steady, dt, position, velocity)
        predicted = transition(dt).dot(self._x.reshape(4, -1)).reshape(self._x.shape)
        gain, precision, _ = steady.step.position
        error = position - predicted[0]
        of_position, of_velocity = Innovation(gain, precision, error), None
        x = gain * error
        x += predicted
        if velocity is not None and steady.step.velocity is not None:
            gain, precision, _ = steady.step.velocity
            error = velocity * TIME_UNIT - x[1]
            of_velocity = Innovation(gain, precision, error)
            x += gain * error
        self._x = x
        step = Step(dt, predicted, steady.step.covariance, of_position, of_velocity)
        self._unweighed.append((dt, step))
        self._unweighed_time += dt
        if self._unweighed_time >= REWEIGH:
            self._reweigh_steady(steady)
        self.mean = np.add.reduce(self._weights * x, axis=1)
        return step if self.remember else None

    def _reweigh_steady(self, steady: SteadyGains) -> None:
        """Do for all steps since the last time at once what `_reweigh` does for one."""
        steps, self._unweighed, self._unweighed_time = self._unweighed, [], 0.0
        shares, share = [], 1.0
        for dt, _ in reversed(steps):
            kept = math.exp(-dt / self.window)
            shares.append((1.0 - kept) * share)
            share *= kept
        for dt, _ in steps:
            self._span = math.exp(-dt / self.window) * self._span + 1.0
        of_steps = np.array(shares[::-1])

        def mean(old: Array, errors: Array, precision: Array) -> Array:
            errors *= errors
            new = of_steps.dot(errors.reshape(len(steps), -1)).reshape(old.shape)
            new *= precision
            new += share * old
            return new

        self._noise = noise = mean(
            self._noise, np.array([step.position.error for _, step in steps]),
            steady.step.position.precision)
        score = np.log(noise + FLOOR)
        if steady.step.velocity is not None:
            self._velocity_noise = noise = mean(
                self._velocity_noise,
                np.array([step.velocity.error for _, step in steps if step.velocity]),
                steady.step.velocity.precision)
            score += steady.used * np.log(noise + FLOOR)
        score += steady.log_constant
        score -= np.minimum.reduce(score)
        score *= -0.5 * self._span
        weights = np.exp(score, out=score)
        weights /= np.add.reduce(weights)
        self._weights = weights

    def _compiled_step(
        self, kernels: Kernels, steady: SteadyGains, dt: float, position: Array,
        velocity: Array | None,
    ) -> Step | None:
        old = self._record
        if old is None:
            old = np.empty((ROWS, *self.weights.shape))
            old[4:8], old[10], old[11] = self._x, self._noise, self._velocity_noise
        self._record = new = np.empty_like(old)
        self.mean = mean = np.empty((4, self.n_joints))
        forget = 1.0 - math.exp(-dt / self.window)
        self._span = span = (1.0 - forget) * self._span + 1.0
        kernels.steady_step(
            old, new, mean, steady.table, steady.velocity_table, position,
            position if velocity is None else velocity * TIME_UNIT, dt / TIME_UNIT, forget, span,
            FLOOR)
        if not self.remember:
            return None
        _, _, covariance, of_position, of_velocity = steady.step
        return Step(
            dt, new[:4], covariance,
            Innovation(of_position.gain, of_position.precision, new[8]),
            None if of_velocity is None else Innovation(
                of_velocity.gain, of_velocity.precision, new[9]))
