# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What one step of the filter bank leaves behind."""

from __future__ import annotations

from typing import NamedTuple

from screw_kinematics.motion.joint_motion import Array


class Step(NamedTuple):
    """
    One step of the bank, as smoothing needs it; M filters, n joints, g = 1 or n.

    Shapes: states (4, M, n), covariances (4, 4, M, g), gains (4, M, g), innovations (M, n), their
    inverse variances (M, g); those of the velocity are None where it was not used.
    """

    transition: Array
    state: Array
    covariance: Array
    gain: Array
    error: Array
    precision: Array
    velocity_gain: Array | None
    velocity_error: Array | None
    velocity_precision: Array | None


class SteadyGains(NamedTuple):
    """Converged gains and innovation statistics, and what they hold for; shapes as in `Step`."""

    reference: float
    ratio: Array | None
    covariance: Array
    gain: Array
    precision: Array
    velocity_gain: Array | None
    velocity_precision: Array | None
    both_gains: Array
    log_s: Array
    log_s_velocity: Array
    used: Array | float
    log_constant: Array
