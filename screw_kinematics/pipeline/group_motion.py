# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The motion of joints that are measured together: from samples to positions and rates."""
from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import hypot
from typing import Any

import numpy as np

from ..errors import Reason
from ..motion.estimator import MotionEstimator
from ..motion.factory import make_estimator
from ..motion.joint_estimator import JointEstimator
from ..motion.joint_motion import JointMotion

VELOCITY_SOURCES = ('auto', 'measured', 'estimated')

NO_VELOCITY = 'velocity_not_measured'
NOT_INCREASING = 'stamp_not_increasing'

LARGEST = 1e9
"""Beyond this [rad, m, rad/s, m/s] a number is no measurement."""

_MAX_BACK_NS = 500_000_000
_BACK_PATIENCE = 20
_SLOPE_SPAN_NS = 20_000_000


@dataclass(frozen=True)
class MotionSettings:
    """
    How joint motion is obtained from samples.

    Parameters
    ----------
    velocity_source : {'auto', 'measured', 'estimated'}
        'auto': the estimator weighs the measured velocity as far as it earns trust;
        'measured': position and velocity are the measured ones, accelerations are estimated;
        'estimated': the measured velocity is ignored.
    estimator : str
        Kind of estimator, see :func:`make_estimator`.
    delay : float
        The motion describes the instant this long before the latest sample [s].
    options : mapping
        Further keyword arguments of the estimator.

    """

    velocity_source: str = 'auto'
    estimator: str = 'bank'
    delay: float = 0.0
    options: Mapping[str, Any] = field(default_factory=dict)

    def make_estimator(self, continuous: Sequence[bool]) -> JointEstimator:
        """Return a new estimator for joints of which these are continuous ones."""
        return make_estimator(self.estimator, len(continuous), delay=self.delay,
                              continuous=np.array(continuous, bool), **self.options)


class GroupMotion:
    """
    Joint motion of one group of joints.

    Parameters
    ----------
    settings : MotionSettings
    continuous : sequence of bool
        For each joint whether its position wraps at 2 pi.
    order : int
        Highest derivative that is wanted, 0 to 4.
    covariance : bool
        Whether the covariance is wanted, which only an estimator knows.

    """

    def __init__(self, settings: MotionSettings, continuous: Sequence[bool], order: int = 2,
                 covariance: bool = False) -> None:
        self.settings = settings
        self.estimator: JointEstimator | None = None
        self.stamp_ns = 0
        self.refusal: str | None = None
        self._continuous = tuple(continuous)
        self._measured = settings.velocity_source == 'measured'
        self._ignored = settings.velocity_source == 'estimated'
        self._last_ns: int | None = None
        self.motion: JointMotion | None = None
        """The latest estimate; None if there is none."""
        self._backward = 0
        self._jerks: deque[tuple[int, Sequence[float]]] = deque()
        self.want(order, covariance)

    def want(self, order: int, covariance: bool = False) -> None:
        """Say what is wanted from now on; a running estimator goes on."""
        self.order = order
        estimated = self.settings.delay > 0 or covariance or (
            order > 1 if self._measured else order > 0)
        if estimated and self.estimator is None:
            self.estimator = self.settings.make_estimator(self._continuous)
        if isinstance(self.estimator, MotionEstimator):
            self.estimator.covariance_wanted = covariance
        self._estimated = estimated

    def reset(self) -> None:
        """Forget all samples."""
        self._last_ns = None
        self.motion = None
        self._jerks.clear()
        if self.estimator is not None:
            self.estimator.reset()

    def update(self, stamp_ns: int, position: Sequence[float],
               velocity: Sequence[float] | None) -> Sequence[float] | None:
        """
        Take a sample; return the motion it leads to.

        Parameters
        ----------
        stamp_ns : int
            Time of the sample [ns].
        position : sequence of float
            [rad, m], finite.
        velocity : sequence of float, optional
            [rad/s, m/s]; NaN where not measured.

        Returns
        -------
        list of float or None
            Positions, then velocities, ... up to the wanted order, at the instant
            ``self.stamp_ns``. If None, ``self.refusal`` tells why the sample was refused, and
            is None where more samples are needed.

        """
        self.refusal = None
        if self._measured and self.order > 0 and not _all_measured(velocity):
            self.refusal = NO_VELOCITY
            return None
        if not self._estimated:
            return self._as_measured(stamp_ns, position, velocity)
        estimator = self.estimator
        assert estimator is not None
        outcome = estimator.step(stamp_ns, position, None if self._ignored else velocity)
        if isinstance(outcome, Reason):
            if not outcome.used:
                self.refusal = outcome
            return None
        self.motion = outcome
        self.stamp_ns = outcome.stamp_ns
        n, order = len(position), self.order
        values = outcome.values
        if order < 3:
            values = values[:(order + 1) * n]
        if self._measured and order > 0:
            values = [*position, *velocity, *values[2 * n:]]     # type: ignore[misc]
        if order == 4:
            values = [*values, *self._slope_of_jerk(values[3 * n:])]
        return values

    def _as_measured(self, stamp_ns: int, position: Sequence[float],
                     velocity: Sequence[float] | None) -> Sequence[float] | None:
        last = self._last_ns
        if last is not None and stamp_ns <= last:
            # The rule of the estimators: a jump back is a new beginning, a step back an error.
            self._backward += 1
            if stamp_ns >= last - _MAX_BACK_NS and self._backward <= _BACK_PATIENCE:
                self.refusal = NOT_INCREASING
                return None
        self._backward = 0
        self._last_ns = self.stamp_ns = stamp_ns
        if self.order == 0:
            return [*position]
        return [*position, *velocity]   # type: ignore[misc]

    def _slope_of_jerk(self, jerk: Sequence[float]) -> list[float]:
        """Return the fourth derivative, which the estimators' model leaves open."""
        jerks = self._jerks
        now = self.stamp_ns
        if jerks and not 0 < now - jerks[-1][0] < 10 * _SLOPE_SPAN_NS:
            jerks.clear()
        jerks.append((now, jerk))
        while len(jerks) > 2 and now - jerks[1][0] >= _SLOPE_SPAN_NS:
            jerks.popleft()
        before, old = jerks[0]
        if before == now:
            return [0.0] * len(jerk)
        span = (now - before) * 1e-9
        return [(j - k) / span for j, k in zip(jerk, old)]


def _all_measured(velocity: Sequence[float] | None) -> bool:
    return velocity is not None and hypot(*velocity) < LARGEST
