# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Which samples an estimator takes: order of stamps, gaps, jumps, bad numbers, turns."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
import math

import numpy as np

from .joint_motion import Array
from ..errors import InvalidValueError

START = 0.0
"""Returned by `SampleGuard.admit` for the first sample of a run."""

REFUSED = -1.0
"""Returned by `SampleGuard.admit` for a sample that must not be used."""

LARGEST = 1e6
"""Positions beyond this (rad or m) cannot be differentiated in double precision."""


class SampleGuard:
    """
    Decide about each sample and count the decisions by reason.

    A *refused* sample leaves no trace but its count. A *restart* begins a new run with the sample
    at hand: the estimator forgets what came before.

    Parameters
    ----------
    n_joints:
        Number of joints.
    max_gap:
        A pause longer than this (s) restarts.
    max_back:
        Stamps that step back by more than this (s) restart; smaller steps are refused.
    max_velocity, max_jump:
        A joint that moves by more than `max_velocity` * dt + `max_jump` (rad or m) is refused.
    patience:
        After this many implausible samples in a row the next one restarts.
    back_patience:
        After this many stamps in a row that do not advance the next one restarts.
    continuous: shape (n_joints,)
        Joints whose position wraps at 2 pi; it is unwrapped.

    """

    def __init__(
        self,
        n_joints: int,
        *,
        max_gap: float = 0.25,
        max_back: float = 0.5,
        max_velocity: float = 20.0,
        max_jump: float = 0.02,
        patience: int = 5,
        back_patience: int = 20,
        continuous: Sequence[bool] | None = None,
    ) -> None:
        limits = {'max_gap': max_gap, 'max_back': max_back, 'max_velocity': max_velocity,
                  'max_jump': max_jump, 'patience': patience, 'back_patience': back_patience}
        for name, value in limits.items():
            if not value > 0:
                raise InvalidValueError(f'{name} is {value}; allowed: more than 0')
        self.n_joints = n_joints
        self.max_gap = max_gap
        self.max_back = max_back
        self.max_velocity = max_velocity
        self.max_jump = max_jump
        self.patience = patience
        self.back_patience = back_patience
        wraps = np.zeros(n_joints, bool) if continuous is None else np.asarray(continuous, bool)
        self.wraps = wraps if wraps.any() else None
        self.refusals: Counter[str] = Counter()
        self.restarts: Counter[str] = Counter()
        self.last_refusal: str | None = None
        self.position = np.full(n_joints, np.nan)
        self._shape = self.position.shape
        self._values = self.position.tolist()
        self._stamp = math.nan
        self._shortest = 0.0
        self._backward = 0
        self._implausible = 0

    def reset(self) -> None:
        """Let the next good sample start a new run; the counts stay."""
        self._stamp = math.nan

    @property
    def run(self) -> tuple[float, float, Array]:
        """Latest stamp, the shortest step to count as one, and position, of the run at hand."""
        return self._stamp, self._shortest, self.position

    @run.setter
    def run(self, run: tuple[float, float, Array]) -> None:
        """Go on as after a good sample."""
        self._stamp, self._shortest, self.position = run
        self._values = self.position.tolist()
        self._backward = self._implausible = 0

    def admit(self, stamp: float, position: Array) -> float:
        """
        Judge one sample.

        Parameters
        ----------
        stamp:
            Time of the sample, s.
        position: shape (n_joints,)
            Measured positions, rad or m; an array that nobody changes from now on.

        Returns
        -------
        The time since the last admitted sample in s, or `START`, or `REFUSED`. Unless refused,
        the attribute `position` is the unwrapped position.

        """
        dt = stamp - self._stamp
        if self._shortest < dt <= self.max_gap and position.shape == self._shape:
            if self.wraps is not None:
                step = position - self.position
                step -= np.where(self.wraps, 2 * np.pi * np.rint(step / (2 * np.pi)), 0.0)
                unwrapped = self.position + step
            else:
                unwrapped = position
            values = unwrapped.tolist()
            limit = self.max_velocity * dt + self.max_jump
            # The norm bounds each component, and is NaN if any is: one number settles most cases.
            if (math.dist(values, self._values) <= limit
                    or np.abs(unwrapped - self.position).max() <= limit):
                self.position = unwrapped
                self._values = values
                self._stamp = stamp
                self._shortest += 1e-3 * (1e-3 * dt - self._shortest)
                self._backward = self._implausible = 0
                return dt
        return self._judge(stamp, position, dt)

    def _judge(self, stamp: float, position: Array, dt: float) -> float:
        """Handle whatever is out of the ordinary."""
        if not math.isfinite(stamp):
            return self._refuse('stamp_not_finite')
        if position.shape != self.position.shape:
            return self._refuse('wrong_length')
        if not np.isfinite(position).all():
            return self._refuse('nan_position')
        if np.abs(position).max() > LARGEST:
            return self._refuse('implausible_position')
        if math.isnan(self._stamp):
            return self._start(stamp, position)
        if dt <= self._shortest:
            self._backward += 1
            if dt < -self.max_back:
                return self._restart('stamp_jump_back', stamp, position)
            if self._backward > self.back_patience:
                return self._restart('stamps_stuck', stamp, position)
            return self._refuse('stamp_not_increasing')
        if dt > self.max_gap:
            return self._restart('gap', stamp, position)
        self._implausible += 1
        if self._implausible > self.patience:
            return self._restart('jump', stamp, position)
        return self._refuse('implausible_jump')

    def _refuse(self, reason: str) -> float:
        self.refusals[reason] += 1
        self.last_refusal = reason
        return REFUSED

    def _restart(self, reason: str, stamp: float, position: Array) -> float:
        self.restarts[reason] += 1
        return self._start(stamp, position)

    def _start(self, stamp: float, position: Array) -> float:
        self.position = position
        self._values = position.tolist()
        self._stamp = stamp
        self._backward = self._implausible = 0
        self._shortest = 0.0
        return START
