# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Today's usual practice: finite differences and a Butterworth low-pass; for comparison."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .guard import LARGEST
from .guarded_estimator import GuardedEstimator
from .joint_motion import Array
from ..errors import InvalidValueError


class FiniteDifferences(GuardedEstimator):
    """
    Finite differences, and a second-order Butterworth low-pass on the acceleration.

    The velocity is the measured one where there is one (and it is finite throughout), else the
    difference of positions. The filter's lag is not made good: the estimate is stamped with the
    sample, as is usual, although it describes an earlier instant.

    Parameters
    ----------
    n_joints:
        Number of joints.
    cutoff:
        Cutoff frequency of the low-pass, Hz.
    velocity:
        ``'auto'``: difference the measured velocity; ``'position-only'``: ignore it.
    **limits:
        `max_gap`, ... of `SampleGuard`.

    """

    def __init__(
        self, n_joints: int, *, cutoff: float = 10.0, velocity: str = 'auto', **limits: Any
    ) -> None:
        limits.setdefault('min_samples', 3)
        super().__init__(n_joints, **limits)
        if self.delay:
            raise InvalidValueError(f'finite differences: delay is {self.delay} s; allowed: 0')
        if not cutoff > 0.0:
            raise InvalidValueError(f'cutoff is {cutoff} Hz; allowed: more than 0')
        self.cutoff = float(cutoff)
        self.velocity_source = velocity

    def _start(self, stamp: float, position: Array, velocity: Array | None) -> None:
        self._period = math.nan
        self._position, self._velocity = position, self._usable(velocity)
        self._inputs = np.zeros((2, self.n_joints))
        self._outputs = np.zeros((2, self.n_joints))
        self._count = 1

    def _usable(self, velocity: Array | None) -> Array | None:
        if velocity is None or self.velocity_source == 'position-only':
            return None
        return velocity.copy() if np.abs(velocity).max() < LARGEST else None

    def _advance(
        self, stamp: float, dt: float, position: Array, velocity: Array | None
    ) -> Array | None:
        self._count += 1
        period = self._period
        self._period = period = (
            dt if math.isnan(period) else period + max(0.05, 1 / self._count) * (dt - period))
        rate = self._usable(velocity)
        if rate is None:
            rate = (position - self._position) / dt
        raw = np.zeros(self.n_joints) if self._velocity is None else (rate - self._velocity) / dt
        k = math.tan(math.pi * min(self.cutoff * period, 0.45))
        norm = 1.0 / (1.0 + math.sqrt(2.0) * k + k * k)
        x1, x2 = self._inputs
        y1, y2 = self._outputs
        smooth = norm * (k * k * (raw + 2 * x1 + x2) - 2 * (k * k - 1) * y1
                         - (1 - math.sqrt(2.0) * k + k * k) * y2)
        jerk = (smooth - y1) / dt
        self._inputs = np.stack([raw, x1])
        self._outputs = np.stack([smooth, y1])
        self._position, self._velocity = position, rate
        if self._count < self.min_samples:
            return None
        self.stamp = stamp
        return np.stack([position, rate, smooth, jerk])
