# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What one step of the filter bank leaves behind; M filters, n joints, g = 1 or n."""

from __future__ import annotations

from typing import NamedTuple

from .joint_motion import Array


class Innovation(NamedTuple):
    """One measurement against its prediction."""

    gain: Array
    """Kalman gain, shape (4, M, g)."""

    precision: Array
    """Inverse variance of the innovation in units of R, shape (M, g)."""

    error: Array
    """The innovation, scaled, shape (M, n)."""


class Step(NamedTuple):
    """One step of the bank, as smoothing needs it."""

    dt: float
    """Time since the step before, s."""

    state: Array
    """Predicted scaled states, shape (4, M, n)."""

    covariance: Array
    """Their covariances in units of R, shape (4, 4, M, g)."""

    position: Innovation
    velocity: Innovation | None
    """Applied after that of the position; None where no velocity was used."""


class SteadyGains(NamedTuple):
    """A step whose gains have converged, and what they hold for."""

    reference: float
    """Sampling period, s."""

    ratio: Array | None
    """Variance of the velocity's noise over that of the position."""

    step: Step
    gains: Array
    """All gains, to compare others with."""

    log_s: Array
    """Logarithm of the variance of the position innovations, shape (M, g)."""

    log_s_velocity: Array
    """Logarithm of the variance of the velocity innovations over that of their noise."""

    table: Array
    """Gains, precision, and the constant part of the likelihood's score, shape (6, M, n)."""

    velocity_table: Array
    """Gains and precision of the velocity, and 1 where it is used, else 0; shape (6, M, n), or
    (0, M, n) if none is."""

    gain: Array
    velocity_gain: Array
    """The gains in these tables, shape (4, M n) or (0, M n)."""

    def repeated(
        self, dt: float, predicted: Array, error: Array, velocity_error: Array | None
    ) -> Step:
        """Return a step with these gains, for smoothing."""
        _, _, covariance, (gain, precision, _), velocity = self.step
        return Step(
            dt, predicted, covariance, Innovation(gain, precision, error),
            None if velocity is None or velocity_error is None
            else Innovation(velocity.gain, velocity.precision, velocity_error))
