# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Which samples are taken: order of stamps, gaps, jumps, bad numbers, turns.

What no robot can do is refused here. What is merely improbable is weighed by the filters.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from math import dist, isfinite, isnan, nan, pi
from numbers import Real

from .numbers import for_joints, positive, Row, whole
from ..errors import Reason

START = 0.0
"""Returned by `Admission.admit` for the first sample of a run."""

LARGEST = 1e6
"""Positions beyond this (rad or m) cannot be differentiated in double precision."""

AT_ONCE = 1e-4
"""Messages closer than this, s, came at once: they had waited, and when they were read is not
known before the device's clock is. The run begins with the last of them."""

BORNE, WAITED, BEGUN = 8, 1000, 40
"""After the first messages of a run so many that come at once are borne, as drivers send bursts;
who sends more of them again, or so many at a time, does so as a rule. After as many that were
apart as the last number says a run has begun for good."""

TURN = 2.0 * pi


class Admission:
    """
    Decide about each sample, and count the decisions by reason.

    A *refused* sample leaves no trace but its count. A *restart* begins a new run with the sample
    at hand: the estimator forgets what came before.

    Limits are in s, rad and m; all are as in `MotionEstimator`.

    Raises
    ------
    InvalidValueError
        If there is no joint, a limit is not positive, or there are not as many as joints.

    """

    def __init__(
        self, n_joints: int, *, max_gap: float = 0.25, max_back: float = 0.5,
        max_velocity: float | Sequence[float] = 20.0, max_jump: float = 0.02, patience: int = 5,
        back_patience: int = 20, continuous: Sequence[bool] | None = None,
    ) -> None:
        self.n_joints = n_joints = whole('n_joints', n_joints)
        self.max_gap = positive('max_gap', max_gap)
        self.max_back = positive('max_back', max_back)
        each = ([max_velocity] * n_joints if isinstance(max_velocity, Real)
                else for_joints('max_velocity', max_velocity, n_joints, 'one, or '))
        self.max_velocity = [positive('max_velocity', value) for value in each]
        self.max_jump = positive('max_jump', max_jump)
        self.patience = positive('patience', patience)
        self.back_patience = positive('back_patience', back_patience)
        wraps = [False] * n_joints if continuous is None else [
            bool(c) for c in for_joints('continuous', continuous, n_joints)]
        self.wraps = wraps if any(wraps) else None
        self.refusals: Counter[Reason] = Counter()
        self.restarts: Counter[str] = Counter()
        self.longest_gap = 0.0
        """The longest pause that restarted, s."""
        self.position: Row = (nan,) * n_joints
        self.stamp = nan
        """Of the latest good sample of the run; NaN before the first."""
        self.period = 0.0
        """Time that passes between readings at least, s, whatever late stamps say; 0: unknown."""
        self._slowest = min(self.max_velocity)
        self._shortest = 0.0
        self.at_once = 0
        """How many messages came at once, where the clock of the device is not known."""
        self._borne = self._apart = 0
        self._backward = 0
        self._implausible = 0

    def reset(self) -> None:
        """Let the next good sample start a new run; the counts stay."""
        self.stamp = nan

    def admit(self, stamp: float, position: Row) -> float | Reason:
        """
        Judge one sample, of a stamp, s, and measured positions, rad or m.

        Return the time since the last admitted sample in s, or `START`, or why it is refused.
        Unless refused, the attribute `position` is the unwrapped position.
        """
        dt = stamp - self.stamp
        # Where the clock of the device is known, messages may come on each other's heels.
        shortest = 0.0 if self.period else self._shortest
        if shortest < dt <= self.max_gap and len(position) == self.n_joints:
            if self.wraps is not None:
                position = self._unwrapped(position)
            # The norm bounds each component, and is NaN if any is: it settles most cases.
            passed = dt if dt > self.period else self.period
            if (dist(position, self.position) <= self._slowest * passed + self.max_jump
                    or self._plausible(position, passed)):
                self.position = position
                self.stamp = stamp
                self._shortest += 1e-3 * (1e-3 * dt - self._shortest)
                self._backward = self._implausible = 0
                if self.period or not self._had_waited(dt):
                    return dt
                return START
        return self._judge(stamp, position, dt, shortest)

    def refuse(self, reason: Reason) -> Reason:
        """Count a refusal."""
        self.refusals[reason] += 1
        return reason

    def _unwrapped(self, position: Row) -> Row:
        assert self.wraps is not None
        return tuple([
            q - TURN * round((q - last) / TURN) if wraps and isfinite(q) else q
            for q, last, wraps in zip(position, self.position, self.wraps)])

    def _plausible(self, position: Row, dt: float) -> bool:
        return all(abs(q - last) <= limit * dt + self.max_jump for q, last, limit in zip(
            position, self.position, self.max_velocity))

    def _judge(self, stamp: float, position: Row, dt: float,
               shortest: float) -> float | Reason:
        """Handle whatever is out of the ordinary."""
        if not isfinite(stamp):
            return self.refuse(Reason.STAMP_NOT_FINITE)
        if len(position) != self.n_joints:
            return self.refuse(Reason.WRONG_LENGTH)
        if not all(map(isfinite, position)):
            return self.refuse(Reason.NOT_FINITE)
        if max(map(abs, position)) > LARGEST:
            return self.refuse(Reason.IMPLAUSIBLE_POSITION)
        if isnan(self.stamp):
            return self._start(stamp, position)
        if dt <= shortest:
            self._backward += 1
            if dt < -self.max_back:
                return self._restart('stamp_jump_back', stamp, position)
            if self._backward > self.back_patience:
                return self._restart('stamps_stuck', stamp, position)
            return self.refuse(Reason.STAMP_NOT_INCREASING)
        if dt > self.max_gap:
            self.longest_gap = max(self.longest_gap, dt)
            return self._restart('gap', stamp, position)
        self._implausible += 1
        if self._implausible > self.patience:
            return self._restart('jump', stamp, position)
        return self.refuse(Reason.IMPLAUSIBLE_JUMP)

    def farthest(self, position: Row) -> tuple[int, float]:
        """Return the joint that is farthest from its latest position taken, and how far."""
        if self.wraps is not None:
            position = self._unwrapped(position)
        apart = [abs(q - last) for q, last in zip(position, self.position)]
        return apart.index(max(apart)), max(apart)

    def _restart(self, reason: str, stamp: float, position: Row) -> float:
        self.restarts[reason] += 1
        return self._start(stamp, position)

    def _start(self, stamp: float, position: Row) -> float:
        self.position = position
        self.stamp = stamp
        self._backward = self._implausible = 0
        self._shortest = 0.0
        self.at_once = self._borne = self._apart = 0
        return START

    def _had_waited(self, dt: float) -> bool:
        """Whether a message came at once with those before it, more of them than are borne."""
        if dt < AT_ONCE:
            self.at_once += 1
            return self._borne < self.at_once < WAITED
        self._apart += 1
        if self._apart == 1:
            self._borne = BORNE
        elif self.at_once > self._borne or self._apart > BEGUN:
            self._borne = WAITED
        self.at_once = 0
        return False
