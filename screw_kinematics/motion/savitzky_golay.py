# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A polynomial fitted to the recent positions: simple, honest, and a good deal worse."""

from __future__ import annotations

from collections import deque
from math import factorial
from typing import Any

import numpy as np

from .guarded_estimator import GuardedEstimator
from .joint_motion import Array, CovarianceSource
from ..errors import InvalidValueError


class SavitzkyGolay(GuardedEstimator):
    """
    Least-squares polynomial over a sliding window, for any stamps, read `delay` back.

    Positions only. The covariance follows from the fit's residuals; it knows nothing of motion
    that the polynomial cannot follow.

    Parameters
    ----------
    n_joints:
        Number of joints.
    delay:
        Estimates describe the instant `delay` s ago; 0.03 s suits the default window.
    window:
        Length of the window, s.
    order:
        Order of the polynomial, 3 or more.
    **limits:
        `max_gap`, ... of `SampleGuard`.

    References
    ----------
    A. Savitzky, M. J. E. Golay, "Smoothing and differentiation of data by simplified least
    squares procedures", Analytical Chemistry 36 (1964) 1627-1639.

    """

    def __init__(
        self, n_joints: int, *, delay: float = 0.03, window: float = 0.15, order: int = 4,
        **limits: Any,
    ) -> None:
        if order < 3:
            raise InvalidValueError(f'order is {order}; allowed: 3 or more')
        limits['min_samples'] = max(limits.get('min_samples', 8), order + 2)
        super().__init__(n_joints, delay=delay, **limits)
        if not window > self.delay:
            raise InvalidValueError(f'window is {window} s; allowed: more than the delay {delay}')
        self.window = float(window)
        self.order = int(order)
        self._scale = np.array([factorial(i) / self.window**i for i in range(4)])[:, None]
        self._samples: deque[tuple[float, Array]] = deque()

    def _start(self, stamp: float, position: Array, velocity: Array | None) -> None:
        self._samples.clear()
        self._samples.append((stamp, position))
        self._count = 1

    def _advance(
        self, stamp: float, dt: float, position: Array, velocity: Array | None
    ) -> Array | None:
        samples = self._samples
        samples.append((stamp, position))
        self._count += 1
        while stamp - samples[0][0] > self.window and len(samples) > self.order + 2:
            samples.popleft()
        wanted = stamp - self.delay
        if self._count < self.min_samples or wanted < samples[0][0]:
            return None
        u = (np.array([t for t, _ in samples]) - wanted) / self.window
        basis = np.vander(u, self.order + 1, increasing=True)
        rows = np.array([q for _, q in samples]) - position
        fit = np.linalg.pinv(basis)
        coefficients = fit.dot(rows)
        state = coefficients[:4] * self._scale
        state[0] += position
        self.stamp = wanted
        self._fit = fit, rows - basis.dot(coefficients)
        return state  # type: ignore[no-any-return]

    def _covariance_source(self) -> CovarianceSource:
        fit, residuals = self._fit
        freedom = max(len(residuals) - self.order - 1, 1)

        def covariance() -> Array:
            variance = (residuals**2).sum(axis=0) / freedom
            unit = fit[:4].dot(fit[:4].T) * (self._scale * self._scale.T)
            return variance[:, None, None] * unit

        return covariance
