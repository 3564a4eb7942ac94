# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The steps of a filter bank while its gains are kept: few operations."""

from __future__ import annotations

from collections.abc import Callable
import math
from typing import NamedTuple

import numpy as np

from .filter_step import SteadyGains, Step
from .joint_motion import Array
from .wiener_process import fill_transition, SCALE, TIME_UNIT

REWEIGH = 8e-3
"""Time between renewals of the weights while the gains are kept, s; a part of their memory."""

FLOOR = 1e-26
"""Added to mean squares before their logarithm, rad^2: far below any measured noise."""

Snapshot = Callable[[], 'tuple[Array, Array, Array, Array]']


class Numbers(NamedTuple):
    """What a bank knows, but for its gains; M filters, n joints."""

    steps: int
    """Steps since the run began."""

    x: Array
    """Scaled states, shape (4, M, n)."""

    noise: Array
    velocity_noise: Array
    """Mean squares of the innovations of position and velocity, shape (M, n)."""

    weights: Array
    """Weights of the filters for each joint, shape (M, n)."""

    span: float
    """Number of steps that the mean squares remember."""

    unweighed_time: float
    """Time since the weights were renewed, s."""


class SteadySteps:
    """
    The part of `FilterBank` that runs at a regular clock; shapes are given there.

    Attributes
    ----------
    state: shape (4, n)
        Weighted mean of the filters' states, not scaled; not kept up to date while `remember`.
    weights: shape (M, n)
        Weights of the filters for each joint.
    remember:
        Whether a step has to be returned, because a smoother needs it.

    """

    p: Array
    state: Array
    weights: Array
    _x: Array
    _noise: Array
    _velocity_noise: Array
    _steps: int

    def __init__(self, n_joints: int, n_filters: int, window: float) -> None:
        self.n_joints = n_joints
        self.n_filters = n_filters
        self.window = window
        self.remember = True
        self._physical = np.repeat(1.0 / SCALE[:, None], n_joints, axis=1)
        # The weights as a matrix (M n, n), so that the weighted mean is one product.
        self._mixing = np.zeros((n_filters * n_joints, n_joints))
        self._mixing_weights = np.einsum(
            'mjj->mj', self._mixing.reshape(n_filters, n_joints, n_joints))
        self._mixed: Array | None = None
        self._ones = np.ones(n_filters)
        # What a step works on; the last is the flat view of the states.
        self._transition = np.eye(4)
        self._cells = self._transition.reshape(16).data
        self._predicted = np.empty((4, n_filters * n_joints))
        self._predicted_position = self._predicted[0].reshape(n_filters, n_joints)
        self._product = np.empty_like(self._predicted)
        self._flat = self._product
        self._flat_of: Array | None = None
        self._errors = np.zeros((2, 0, n_filters, n_joints))
        self._make_room(8)
        self._clear()

    def _make_room(self, steps: int) -> None:
        """Make room for the innovations of some steps, keeping those that are there."""
        errors = np.zeros((2, steps, self.n_filters, self.n_joints))
        errors[:, :self._errors.shape[1]] = self._errors
        self._errors = errors
        self._rows = [[(row, row.reshape(-1)) for row in rows] for rows in errors]

    def _clear(self) -> None:
        """Forget steps whose weights are still to be found."""
        self._unweighed: list[float] = []       # shares of steps in the means, over `_remaining`
        self._remaining = 1.0        # share of what was before these
        self._unweighed_time = 0.0
        self._span = 0.0

    def snapshot(self) -> Snapshot:
        """
        Return a function for weights, noise variances, states and covariances as they are now.

        The states are changed in place while gains are kept, the other arrays never.
        """
        x = self._x.copy() if self._x is self._flat_of and not self.remember else self._x
        parts = self.weights, self._noise, x, self.p
        return lambda: parts

    @property
    def numbers(self) -> Numbers | None:
        """Return what the bank knows; None while some steps are still to enter it."""
        if self._unweighed:
            return None
        return Numbers(self._steps, self._x, self._noise, self._velocity_noise, self.weights,
                       self._span, self._unweighed_time)

    @numbers.setter
    def numbers(self, numbers: Numbers) -> None:
        """Go on with these; the gains are kept."""
        (self._steps, self._x, self._noise, self._velocity_noise, self.weights,
         self._span, self._unweighed_time) = numbers

    def _steady_step(
        self, steady: SteadyGains, dt: float, position: Array, velocity: Array | None
    ) -> Step | None:
        if self._x is not self._flat_of:
            self._x = self._flat_of = np.ascontiguousarray(self._x)
            self._flat = self._x.reshape(4, -1)
        x, predicted, product = self._flat, self._predicted, self._product
        unweighed = self._unweighed
        step = len(unweighed)
        if step == len(self._rows[0]):
            self._make_room(2 * step)
        fill_transition(self._cells, dt)
        np.dot(self._transition, x, predicted)
        error, flat = self._rows[0][step]
        np.subtract(position, self._predicted_position, error)
        np.multiply(steady.gain, flat, product)
        np.add(predicted, product, x)
        velocity_error = None
        if velocity is not None and steady.step.velocity is not None:
            velocity_error, flat = self._rows[1][step]
            np.subtract(velocity * TIME_UNIT, self._x[1], velocity_error)
            np.multiply(steady.velocity_gain, flat, product)
            np.add(x, product, x)
        kept = math.exp(-dt / self.window)
        self._span = kept * self._span + 1.0
        self._remaining = share = kept * self._remaining
        unweighed.append((1.0 - kept) / share)
        self._unweighed_time += dt
        if self._unweighed_time >= REWEIGH:
            self._reweigh_steady(steady)
        if self.remember:
            return steady.repeated(dt, predicted.reshape(self._x.shape).copy(), error.copy(), (
                None if velocity_error is None else velocity_error.copy()))
        self.state = state = self.mean(x)
        state *= self._physical
        return None

    def mean(self, x: Array) -> Array:
        """Return the weighted mean over the filters, shape (4, n), of what has 4 M n numbers."""
        if self._mixed is not self.weights:
            self._mixing_weights[...] = self._mixed = self.weights
        return x.reshape(4, -1).dot(self._mixing)  # type: ignore[no-any-return]

    def _reweigh_steady(self, steady: SteadyGains) -> None:
        """Do for all steps since the last time at once what `_reweigh` does for one."""
        shares, kept, steps = np.array(self._unweighed), self._remaining, len(self._unweighed)
        self._unweighed, self._remaining, self._unweighed_time = [], 1.0, 0.0
        if steps:
            def mean(errors: Array, precision: Array, old: Array) -> Array:
                squares = errors[:steps].reshape(steps, -1)
                new: Array = shares.dot(squares * squares).reshape(old.shape)
                new *= precision
                new += old
                new *= kept
                return new

            self._noise = mean(self._errors[0], steady.table[4], self._noise)
            if steady.step.velocity is not None:
                self._velocity_noise = mean(
                    self._errors[1], steady.velocity_table[4], self._velocity_noise)
        self.weights = self._weighed(steady)

    def _weighed(self, steady: SteadyGains) -> Array:
        """Return the weights that follow from the mean squares."""
        score = np.log(self._noise + FLOOR)
        if steady.step.velocity is not None:
            score += steady.velocity_table[5] * np.log(self._velocity_noise + FLOOR)
        score += steady.table[5]
        score -= np.minimum.reduce(score)
        score *= -0.5 * self._span
        weights = np.exp(score, out=score)
        weights /= self._ones.dot(weights)      # faster than their sum
        return weights
