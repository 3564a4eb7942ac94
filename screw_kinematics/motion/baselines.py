# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Simpler estimators, for comparison and for those who want to tune."""

from __future__ import annotations

from abc import abstractmethod
from collections import deque
from collections.abc import Sequence
from math import factorial, hypot, isnan, nan, pi, sqrt, tan

import numpy as np

from .admission import Admission
from .estimator import MotionEstimator
from .joint_estimator import JointEstimator, LARGEST_VELOCITY
from .joint_motion import Array, JointMotion
from .numbers import positive, Row, whole
from ..core.bank import Bank
from ..errors import InvalidValueError, Reason


class PlainEstimator(JointEstimator):
    """Base of estimators that take the stamps as they are."""

    def _take(self, stamp: float, position: Row,
              velocity: Row | None) -> JointMotion | Reason:
        admission = self._admission
        dt = admission.admit(stamp, position)
        if isinstance(dt, Reason):
            return dt
        measured = None if velocity is None else self._measured(velocity)
        if dt == 0.0:
            self._start(stamp, admission.position, measured)
            return Reason.SETTLING
        return self._advance(stamp, dt, admission.position, measured)

    @abstractmethod
    def _start(self, stamp: float, position: Row,
               velocity: Row | None) -> None:
        """Begin a run with this sample."""

    @abstractmethod
    def _advance(self, stamp: float, dt: float, position: Row,
                 velocity: Row | None) -> JointMotion | Reason:
        """Take the next sample of the run, `dt` > 0 after the one before."""


class FixedKalmanFilter(MotionEstimator):
    """
    One filter of the bank, of given bandwidth and noise.

    Parameters
    ----------
    n_joints : int
        Number of joints.
    delay : float
        As in `MotionEstimator`.
    bandwidth : float
        Bandwidth of the filter, Hz.
    position_noise : float
        Standard deviation of the measured position, rad or m; it scales the covariance only,
        because the bandwidth fixes the ratio of process to measurement noise.
    regularise, max_gap, max_velocity, continuous : optional
        As in `MotionEstimator`.

    """

    def __init__(
        self, n_joints: int, delay: float = 0.0, *, bandwidth: float = 8.0,
        position_noise: float = 1e-5, regularise: bool = True, max_gap: float = 0.25,
        max_velocity: float | Sequence[float] = 20.0, continuous: Sequence[bool] | None = None,
    ) -> None:
        self.bandwidth = positive('bandwidth', bandwidth, ' Hz')
        self.position_noise = positive('position_noise', position_noise)
        super().__init__(n_joints, delay, 'position-only', regularise=regularise,
                         max_gap=max_gap, max_velocity=max_velocity, continuous=continuous)

    def _make_bank(self) -> Bank:
        return Bank(self.n_joints, [(4, self.bandwidth)], 0.0, self.delay,
                    self.position_noise**2)


class FiniteDifferences(PlainEstimator):
    """
    Today's usual practice: finite differences, and a low-pass on the acceleration.

    The velocity is the measured one where there is one (and it is finite throughout), else the
    difference of positions; the low-pass is a second-order Butterworth filter. Its lag is not
    made good: the estimate is stamped with the sample, as is usual, although it describes an
    earlier instant.

    Parameters
    ----------
    n_joints : int
        Number of joints.
    delay : float
        0; the method has no other.
    cutoff : float
        Cutoff frequency of the low-pass, Hz.
    velocity : str
        ``'auto'``: difference the measured velocity; ``'position-only'``: ignore it.
    max_gap, max_velocity, continuous : optional
        As in `MotionEstimator`.

    """

    def __init__(
        self, n_joints: int, delay: float = 0.0, *, cutoff: float = 10.0,
        velocity: str = 'auto', max_gap: float = 0.25,
        max_velocity: float | Sequence[float] = 20.0, continuous: Sequence[bool] | None = None,
    ) -> None:
        super().__init__(n_joints, delay, Admission(
            n_joints, max_gap=max_gap, max_velocity=max_velocity, continuous=continuous), 3)
        if self.delay:
            raise InvalidValueError(f'finite differences: delay is {self.delay} s; allowed: 0')
        self.cutoff = positive('cutoff', cutoff, ' Hz')
        self.velocity_source = velocity

    def _start(self, stamp: float, position: Row,
               velocity: Row | None) -> None:
        self._period = nan
        self._position, self._velocity = np.array(position), self._usable(velocity)
        self._inputs = np.zeros((2, self.n_joints))
        self._outputs = np.zeros((2, self.n_joints))
        self._count = 1

    def _usable(self, velocity: Row | None) -> Array | None:
        if velocity is None or self.velocity_source == 'position-only':
            return None
        return np.array(velocity) if hypot(*velocity) < LARGEST_VELOCITY else None

    def _advance(self, stamp: float, dt: float, position: Row,
                 velocity: Row | None) -> JointMotion | Reason:
        self._count += 1
        period, q = self._period, np.array(position)
        self._period = period = (
            dt if isnan(period) else period + max(0.05, 1 / self._count) * (dt - period))
        rate = self._usable(velocity)
        if rate is None:
            rate = (q - self._position) / dt
        raw = np.zeros(self.n_joints) if self._velocity is None else (rate - self._velocity) / dt
        k = tan(pi * min(self.cutoff * period, 0.45))
        norm = 1.0 / (1.0 + sqrt(2.0) * k + k * k)
        x1, x2 = self._inputs
        y1, y2 = self._outputs
        smooth = norm * (k * k * (raw + 2 * x1 + x2) - 2 * (k * k - 1) * y1
                         - (1 - sqrt(2.0) * k + k * k) * y2)
        jerk = (smooth - y1) / dt
        self._inputs = np.stack([raw, x1])
        self._outputs = np.stack([smooth, y1])
        self._position, self._velocity = q, rate
        if self._count < self.min_samples:
            return Reason.SETTLING
        return JointMotion(stamp, [*position, *rate.tolist(), *smooth.tolist(), *jerk.tolist()])


class SavitzkyGolay(PlainEstimator):
    """
    A least-squares polynomial over the recent positions, for any stamps, read `delay` back.

    Positions only. The covariance follows from the fit's residuals; it knows nothing of motion
    that the polynomial cannot follow.

    Parameters
    ----------
    n_joints : int
        Number of joints.
    delay : float
        Estimates describe the instant `delay` s ago; 0.03 s suits the default window.
    window : float
        Length of the window, s.
    order : int
        Order of the polynomial, 3 or more.
    max_gap, max_velocity, continuous : optional
        As in `MotionEstimator`.

    References
    ----------
    A. Savitzky, M. J. E. Golay, "Smoothing and differentiation of data by simplified least
    squares procedures", Analytical Chemistry 36 (1964) 1627-1639.

    """

    def __init__(
        self, n_joints: int, delay: float = 0.03, *, window: float = 0.15, order: int = 4,
        max_gap: float = 0.25, max_velocity: float | Sequence[float] = 20.0,
        continuous: Sequence[bool] | None = None,
    ) -> None:
        order = whole('order', order, 3)
        super().__init__(n_joints, delay, Admission(
            n_joints, max_gap=max_gap, max_velocity=max_velocity, continuous=continuous),
            max(8, order + 2))
        if not positive('window', window, ' s') > self.delay:
            raise InvalidValueError(f'window is {window} s; allowed: more than the delay {delay}')
        self.window = float(window)
        self.order = int(order)
        self._scale = np.array([factorial(i) / self.window**i for i in range(4)])[:, None]
        self._samples: deque[tuple[float, Array]] = deque()

    def _start(self, stamp: float, position: Row,
               velocity: Row | None) -> None:
        self._samples.clear()
        self._samples.append((stamp, np.array(position)))
        self._count = 1

    def _advance(self, stamp: float, dt: float, position: Row,
                 velocity: Row | None) -> JointMotion | Reason:
        samples = self._samples
        latest = np.array(position)
        samples.append((stamp, latest))
        self._count += 1
        while stamp - samples[0][0] > self.window and len(samples) > self.order + 2:
            samples.popleft()
        wanted = stamp - self.delay
        if self._count < self.min_samples or wanted < samples[0][0]:
            return Reason.SETTLING
        u = (np.array([t for t, _ in samples]) - wanted) / self.window
        basis = np.vander(u, self.order + 1, increasing=True)
        rows = np.array([q for _, q in samples]) - latest
        fit = np.linalg.pinv(basis)
        coefficients = fit.dot(rows)
        state = coefficients[:4] * self._scale
        state[0] += latest

        def covariance() -> Array:
            freedom = max(len(rows) - self.order - 1, 1)
            variance = ((rows - basis.dot(coefficients))**2).sum(axis=0) / freedom
            unit = fit[:4].dot(fit[:4].T) * (self._scale * self._scale.T)
            return variance[:, None, None] * unit  # type: ignore[no-any-return]

        return JointMotion(wanted, state.ravel().tolist(), covariance)
