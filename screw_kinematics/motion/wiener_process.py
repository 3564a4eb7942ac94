# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The motion model of the estimators: white noise integrated three or four times.

A joint's state is (q, q', q'', q'''), scaled by a time unit T to (q, q' T, q'' T^2 / 2,
q''' T^3 / 6) so that all components are of the order of a position: with T about the length of
an estimator's memory, covariances stay well conditioned. In these units the transition over dt
holds the binomial coefficients times powers of dt / T.

References
----------
Y. Bar-Shalom, X. R. Li, T. Kirubarajan, "Estimation with Applications to Tracking and
Navigation", Wiley 2001, section 6.2 (discretised continuous-time kinematic models).

"""

from __future__ import annotations

from math import factorial
from typing import Any

import numpy as np

from .joint_motion import Array

TIME_UNIT = 0.02
"""The time unit T of scaled states, s."""

SCALE = np.array([TIME_UNIT**i / factorial(i) for i in range(4)])
"""Scaled state = state * SCALE, component by component."""


_IDENTITY = np.eye(4)


def transition(dt: float) -> Array:
    """
    Return the transition matrix of scaled states over `dt` seconds, shape (4, 4).

    Examples
    --------
    >>> transition(0.02)[0]
    array([1., 1., 1., 1.])

    """
    f = _IDENTITY.copy()
    fill_transition(f.reshape(16).data, dt)
    return f


def fill_transition(cells: Any, dt: float) -> None:
    """Write the transition over `dt` seconds to the 16 cells of an identity matrix."""
    # By hand: building the matrix takes longer than using it.
    r = dt / TIME_UNIT
    r2 = r * r
    cells[1] = r
    cells[2] = r2
    cells[3] = r2 * r
    cells[6] = 2.0 * r
    cells[7] = 3.0 * r2
    cells[11] = 3.0 * r


def _noise_terms(order: int) -> tuple[Array, Array]:
    """Return coefficient and exponent of dt of the process noise of a scaled state."""
    coefficient, exponent = np.zeros((4, 4)), np.ones((4, 4))
    for i in range(order):
        for j in range(order):
            exponent[i, j] = 2 * order - 1 - i - j
            coefficient[i, j] = SCALE[i] * SCALE[j] / (
                exponent[i, j] * factorial(order - 1 - i) * factorial(order - 1 - j))
    return coefficient, exponent


NOISE_TERMS = {order: _noise_terms(order) for order in (3, 4)}
"""Coefficients and exponents of dt of the process noise, by order of the model."""


def process_noise(order: int, dt: float) -> Array:
    """
    Return the covariance that unit white noise in derivative `order` adds over `dt` seconds.

    Of order 3 the jerk is white noise, its state unused and zero; of order 4 the snap is. Shape
    (4, 4), of scaled states, per unit of the noise's spectral density.
    """
    coefficient, exponent = NOISE_TERMS[order]
    return coefficient * dt**exponent
