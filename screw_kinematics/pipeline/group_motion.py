# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The motion of joints that are measured together: from readings to positions and rates.

Where the rates come from is decided once, in :func:`make_motion`: each of the classes here is
one way, and all have the same ``update``.
"""
from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import hypot, isnan, nan
from typing import Protocol

from .joint_groups import LARGEST, Reading
from .settings import MotionSettings
from ..errors import Reason
from ..motion import make_estimator, MotionEstimator
from ..motion.clock_error import ClockError, EXACT
from ..motion.joint_estimator import JointEstimator
from ..motion.joint_motion import JointMotion

MAX_BACK_NS = 500_000_000
BACK_PATIENCE = 20
"""The rule of the estimators: stamps that step back further, or so often, begin anew."""

SLOPE_SPAN_NS = 20_000_000


@dataclass
class Motion:
    """
    The motion of joints at one instant.

    Values are the positions of all joints [rad, m], then velocities, ... as far as they are known.
    Variances, of those to the jerks, are in the same order, NaN where not known, and empty unless
    asked for; the clock's error, of all joints alike, is in them. What tells more of them is the
    estimate, if they are of one.
    """

    stamp_ns: int
    values: Sequence[float]
    variances: Sequence[float] = ()
    clock_error: ClockError = field(default=EXACT, repr=False)
    estimate: JointMotion | None = field(default=None, repr=False, compare=False)

    def variances_after(self, dt: float) -> Sequence[float]:
        """Return the variances where its derivatives carry the motion on for a time [s]."""
        if self.estimate is None or dt == 0.0:
            return self.variances
        then = [x for order in range(4) for x in self.estimate.variances_after(dt, order)]
        return [nan if isnan(now) else x for now, x in zip(self.variances, then)]


class GroupMotion(Protocol):
    """One way from readings of a group of joints to their motion."""

    @property
    def estimator(self) -> JointEstimator | None:
        """Return the estimator at work, if there is one."""

    def update(self, reading: Reading) -> Motion | Reason:
        """Take a reading; return the motion it leads to, or why there is none."""

    def reset(self) -> None:
        """Forget all readings."""


def make_motion(settings: MotionSettings, continuous: Sequence[bool],
                max_velocity: Sequence[float], order: int, covariance: bool,
                before: GroupMotion | None = None, joined: bool = False) -> GroupMotion:
    """
    Return the motion of a group of joints as the settings ask for it.

    Up to the derivative of an order of 0 to 4; only an estimator knows variances. Where the joints
    and settings are the same as before, the estimator goes on. What is to be joined with that of
    other groups has all derivatives that are known: it is carried to another instant by them.
    """
    measured = settings.velocity_source == 'measured'
    if not covariance and settings.delay == 0 and order <= (1 if measured else 0):
        return MeasuredMotion(order)
    if joined:
        order = max(order, 3)
    estimator = before.estimator if before is not None else None
    if estimator is None:
        estimator = make_estimator(
            settings.estimator, len(continuous), delay=settings.delay,
            continuous=continuous, **{**settings.options, 'max_velocity': max_velocity})
    if isinstance(estimator, MotionEstimator):
        estimator.covariance_wanted = covariance
    motion: GroupMotion
    if measured and order > 0:
        motion = MeasuredVelocityMotion(estimator, order, covariance)
    elif settings.velocity_source == 'estimated':
        motion = PositionOnlyMotion(estimator, order, covariance)
    else:
        motion = EstimatedMotion(estimator, order, covariance)
    return WithSnap(motion) if order == 4 else motion


class MeasuredMotion:
    """Positions, and velocities where these are wanted, as they were measured."""

    estimator = None

    def __init__(self, order: int) -> None:
        self._velocity = order > 0
        self.reset()

    def reset(self) -> None:
        """Forget all readings."""
        self._last_ns: int | None = None
        self._backward = 0

    def update(self, reading: Reading) -> Motion | Reason:
        """Take a reading; return its own numbers."""
        if self._velocity and not _all_measured(reading.velocity):
            return Reason.NO_VELOCITY
        stamp, last = reading.stamp_ns, self._last_ns
        if last is not None and stamp <= last:
            self._backward += 1
            if stamp >= last - MAX_BACK_NS and self._backward <= BACK_PATIENCE:
                return Reason.STAMP_NOT_INCREASING
        self._backward = 0
        self._last_ns = stamp
        if not self._velocity:
            return Motion(stamp, reading.position)
        assert reading.velocity is not None
        return Motion(stamp, [*reading.position, *reading.velocity])


class EstimatedMotion:
    """All from an estimator, which weighs positions and velocities."""

    def __init__(self, estimator: JointEstimator, order: int, covariance: bool) -> None:
        self.estimator = estimator
        self._order = order
        self._covariance = covariance

    def reset(self) -> None:
        """Forget all readings."""
        self.estimator.reset()

    def update(self, reading: Reading) -> Motion | Reason:
        """Take a reading; return the estimate it leads to."""
        return self._estimate(reading, reading.velocity)

    def _estimate(self, reading: Reading, velocity: Sequence[float] | None) -> Motion | Reason:
        outcome = self.estimator.step(reading.stamp_ns, reading.position, velocity)
        if not isinstance(outcome, JointMotion):
            return outcome
        estimate = outcome      # whose type is in the .pxd
        values = estimate.values
        if self._order < 3 and not self._covariance:
            values = values[:(self._order + 1) * len(reading.position)]
        if not self._covariance:
            return Motion(estimate.stamp_ns, values, (), estimate.clock_error)
        return Motion(estimate.stamp_ns, values, estimate.variances, estimate.clock_error,
                      estimate)


class PositionOnlyMotion(EstimatedMotion):
    """All from an estimator, which never sees the measured velocities."""

    def update(self, reading: Reading) -> Motion | Reason:
        """Take a reading; return the estimate that its positions lead to."""
        return self._estimate(reading, None)


class MeasuredVelocityMotion(EstimatedMotion):
    """Positions and velocities as measured, and what lies above from an estimator."""

    def update(self, reading: Reading) -> Motion | Reason:
        """Take a reading; return what it says, and accelerations once they are known."""
        velocity = reading.velocity
        if not _all_measured(velocity):
            return Reason.NO_VELOCITY
        assert velocity is not None
        estimate = self._estimate(reading, velocity)
        known = [*reading.position, *velocity]
        unknown = (nan,) * len(known) if self._covariance else ()
        if isinstance(estimate, Motion):
            n = len(known)
            return Motion(reading.stamp_ns, [*known, *estimate.values[n:]],
                          (*unknown, *estimate.variances[n:]), estimate.clock_error,
                          estimate.estimate)
        if estimate is Reason.SETTLING:
            return Motion(reading.stamp_ns, known, unknown * 2)
        return estimate


class WithSnap:
    """A way to motion, and the slope of its jerk, as the estimators' model ends there."""

    def __init__(self, motion: GroupMotion) -> None:
        self._motion = motion
        self._jerks: deque[tuple[int, Sequence[float]]] = deque()
        self.estimator = motion.estimator

    def reset(self) -> None:
        """Forget all readings."""
        self._motion.reset()
        self._jerks.clear()

    def update(self, reading: Reading) -> Motion | Reason:
        """Take a reading; return the motion it leads to, to the fourth derivative."""
        motion = self._motion.update(reading)
        n = len(reading.position)
        if isinstance(motion, Reason) or len(motion.values) < 4 * n:
            return motion
        return Motion(motion.stamp_ns, [
            *motion.values, *self._slope(motion.stamp_ns, motion.values[3 * n:])],
            motion.variances, motion.clock_error, motion.estimate)

    def _slope(self, now: int, jerk: Sequence[float]) -> list[float]:
        jerks = self._jerks
        if jerks and not 0 < now - jerks[-1][0] < 10 * SLOPE_SPAN_NS:
            jerks.clear()
        jerks.append((now, jerk))
        while len(jerks) > 2 and now - jerks[1][0] >= SLOPE_SPAN_NS:
            jerks.popleft()
        before, old = jerks[0]
        if before == now:
            return [0.0] * len(jerk)
        span = (now - before) * 1e-9
        return [(j - k) / span for j, k in zip(jerk, old)]


def _all_measured(velocity: Sequence[float] | None) -> bool:
    return velocity is not None and hypot(*velocity) < LARGEST
