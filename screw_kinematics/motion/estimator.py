# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The default estimator: device clock, self-tuning bank, and an optional honest delay."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import inf
from typing import Any

from .admission import Admission
from .bank_covariance import BankCovariance
from .device_clock import DeviceClock, Placed
from .filter_bank import make_bank
from .foresight import UNFORESEEN
from .joint_estimator import JointEstimator, listed
from .joint_motion import JointMotion
from .numbers import Row
from ..core.bank import Bank
from ..errors import InvalidValueError, Reason

VELOCITY_CHOICES = ('auto', 'position-only')

SETTLED = 16
"""Samples after which the filters may foresee the next one for the clock."""

LONGEST_AGE, PERIODS = 0.02, 3.0
"""Outputs go on without a new reading, or describe what was after one that came late, for this
long, s, or for so many periods of the device."""

ONWARD = 0.4
"""Ticks that joints must have gone on for an older stamp to be of a clock that was set back."""

SHORTEST, PAUSE = 0.1, 0.01
"""While a run is shorter than `SHORTEST` s, accelerations within four times their noise are not
told; samples further apart than `PAUSE` s count as so far apart: a pause tells nothing."""

JUMPS, RECENT = 3.0, 0.02
"""Jumps that no joint can do, of late, from which on samples are of more than one device: of the
last 1 / `RECENT` samples, about. They tell no clock."""

MOST_AT_ONCE = 2
"""More messages than these at once, in a run that is that short, may be of a stall."""

FEW = 100
"""Samples from which on velocities are judged."""

LATE = 2e-3
"""Lag of a velocity that is told, s."""

USED = 0.02
"""Weight in the estimate from which on a velocity counts as used."""


class MotionEstimator(JointEstimator):
    """
    The self-tuning bank: filters of many bandwidths, weighted by how well each predicts.

    Nothing has to be tuned: noise level, encoder resolution, rate and the vigour of the motion
    are all read from the data, joint by joint; so is the clock of the device that reads the
    joints, which the stamps may know little of.

    Parameters
    ----------
    n_joints : int
        Number of joints.
    delay : float
        0: estimates describe the latest sample. Above: they describe, and are stamped with, the
        instant `delay` s before it, and are several times as accurate (0.02 s is a good choice).
    velocity : str
        ``'auto'``: the measured velocity is used per joint as far as it proves right;
        ``'position-only'``: it is ignored.
    regularise : bool
        Whether the device's own clock is looked for; without, readings are of their stamps.
    max_gap : float
        A pause longer than this (s) begins a new run.
    max_back : float
        So do stamps that step back by more than this (s); smaller steps are refused.
    max_velocity, max_jump : float or sequence of float
        A joint that moves by more than `max_velocity` * dt + `max_jump` (rad or m) is refused;
        the velocity for all joints, or one for each.
    patience, back_patience : int
        After so many implausible samples, or stamps that do not advance, a new run begins.
    continuous : sequence of bool, length n_joints
        Joints whose position wraps at 2 pi; it is unwrapped.
    min_samples : int
        Samples of a run before the first estimate; it waits up to 0.1 s while it is mostly
        noise.
    **unknown
        Nothing: what is misspelt is refused by its name.

    """

    def __init__(
        self, n_joints: int, delay: float = 0.0, velocity: str = 'auto', *,
        regularise: bool = True, max_gap: float = 0.25, max_back: float = 0.5,
        max_velocity: float | Sequence[float] = 20.0, max_jump: float = 0.02, patience: int = 5,
        back_patience: int = 20, continuous: Sequence[bool] | None = None, min_samples: int = 8,
        **unknown: Any,
    ) -> None:
        if unknown:     # compiled classes do not say whose argument it is
            raise TypeError('MotionEstimator.__init__() got an unexpected keyword argument '
                            f'{next(iter(unknown))!r}')
        super().__init__(n_joints, delay, Admission(
            n_joints, max_gap=max_gap, max_back=max_back, max_velocity=max_velocity,
            max_jump=max_jump, patience=patience, back_patience=back_patience,
            continuous=continuous), min_samples)
        if velocity not in VELOCITY_CHOICES:
            raise InvalidValueError(f'velocity is {velocity!r}; allowed: {VELOCITY_CHOICES}')
        self.velocity = velocity
        self.covariance_wanted = True
        """Whether motions shall know their covariance, which takes some microseconds."""
        self._clock = DeviceClock(n_joints)
        self._bank = self._make_bank()
        self._trusted = velocity == 'auto'
        self._regularise = regularise
        self.runs = 0
        """Runs that have begun."""
        self._settled = 0.0
        """Time that samples of the run have told of, s; up to `SHORTEST`."""
        self._shift = 0.0
        """By how much the stamps' clock was set back while the joints moved on, s."""
        self._jumps = 0.0
        """Jumps that no joint can do, of late."""
        self._back = inf
        """The latest stamp if it was old while the joints moved on, s; else infinite."""

    def _make_bank(self) -> Bank:
        return make_bank(self.n_joints, self.delay)

    @property
    def velocity_used(self) -> Sequence[bool]:
        """Whether the measured velocity of each joint enters the estimate."""
        return [share > USED for *_, share in self._bank.velocity_facts()]

    def doubts(self, joint_names: Sequence[str] | None = None) -> list[str]:
        # Also about when and how fast joints were read.
        names: Iterable[object] = range(self.n_joints) if joint_names is None else joint_names
        found = [*super().doubts(joint_names), *self._clock.doubts()]
        count = self._bank.count
        if not self._bank.with_velocity or count < FEW:
            return found
        facts = self._bank.velocity_facts()
        idle = [alive < 0.1 * FEW for alive, *_ in facts]
        differenced = [not still and back for still, (_, back, *_) in zip(idle, facts)]
        for what, joints in (
                ('always zero', idle), ('merely differenced from position', differenced),
                ('late', [lag > LATE and not (still or merely) for still, merely, (_, _, lag, *_)
                          in zip(idle, differenced, facts)])):
            if any(joints):
                late = max(lag for _, _, lag, *_ in facts)
                by = f' by up to {1e3 * late:.0f} ms' if what == 'late' else ''
                found.append(f'measured velocity is {what}{by}: joints {listed(names, joints)}')
        return found

    def _unset(self, stamp: float, position: Row) -> float:
        """Return the stamp by a clock that was not set back meanwhile."""
        own = stamp - self._shift
        last, bank = self._admission.stamp, self._bank
        if own > last or len(position) != self.n_joints or bank.count <= SETTLED:
            self._back = inf
            return own
        period = self._clock.period or 1e-3
        ticks, _, _ = bank.travel(position, period, period, UNFORESEEN)
        before, self._back = self._back, stamp if ticks > ONWARD else inf
        if ticks > ONWARD and stamp > before:
            # Two old stamps in order while the joints go on: the clock was set back. By how much
            # the joints tell best.
            passed = period + stamp - before
            own = last + min(max(period * ticks, passed - 0.2 * period), passed + 0.2 * period)
            self._shift = stamp - own
        return own

    def place(self, stamp: float, position: Row, velocity: Row | None = None,
              known: DeviceClock | None = None) -> Placed | Reason:
        """
        Take one sample, but read nothing; return where it is in the device's time.

        Parameters
        ----------
        stamp : float
            Time of the sample, s.
        position, velocity : tuple of float, length n_joints
            As for `update`.
        known : DeviceClock, optional
            The clock of the device, where a sample that begins a run may know it.

        Returns
        -------
        Placed or Reason
            Where it is, or why it is not taken.

        """
        admission, clock, bank = self._admission, self._clock, self._bank
        admission.period = clock.period
        dt = admission.admit(self._unset(stamp, position), position)
        if not isinstance(dt, float):
            self._jumps += dt is Reason.IMPLAUSIBLE_JUMP
            return dt
        position = admission.position
        if dt == 0.0:
            admission.stamp, self._shift = stamp, 0.0
            self.runs += 1
            self._settled = self._jumps = 0.0
            self._clock = clock = DeviceClock(self.n_joints)
            clock.start(stamp, position, known)
            bank.start(stamp, position)
            return Placed(stamp, stamp, 1.0, 0.0, [(stamp, position)])
        if self._settled < SHORTEST:
            self._settled += dt if dt < PAUSE else PAUSE
        own = admission.stamp
        placed = Placed(own, own, 1.0, 0.0, None) if not self._regularise else clock.update(
            own, position, bank if bank.count > SETTLED else None)
        if self._jumps > 0.0:
            self._jumps *= 1.0 - RECENT
            if self._jumps > JUMPS:
                clock.begin_anew()      # what it would have replayed is of both devices
        if placed.replay is not None:
            bank.start(*placed.replay[0])
            for time, replayed in placed.replay[1:]:
                bank.measure(time, replayed, replayed, False, 1.0)
            if placed.anew or len(placed.replay) > 1:   # the filters know these alone
                self._settled = min(SHORTEST, placed.replay[-1][0] - placed.replay[0][0])
        elif placed.time is not None:
            measured = None
            if velocity is not None and self._trusted:
                measured = self._measured(velocity)
            if measured is None:
                bank.measure(placed.time, position, position, False, placed.rate)
            else:
                bank.measure(placed.time, position, measured, True, placed.rate)
        return placed

    @property
    def position(self) -> Row:
        """Return the positions of the latest sample taken, continuous joints unwrapped."""
        return self._admission.position

    @property
    def odd(self) -> Sequence[int]:
        """Return by joint how many readings before the latest one that shows to be odd."""
        return self._bank.odd()  # type: ignore[no-any-return]

    @property
    def clock(self) -> DeviceClock:
        """Return what is known of the device's clock."""
        return self._clock

    def _take(self, stamp: float, position: Row,
              velocity: Row | None) -> JointMotion | Reason:
        outcome = self.place(stamp, position, velocity)
        if not isinstance(outcome, Placed):
            return outcome
        placed = outcome
        beyond = placed.age if placed.time is None else (
            placed.instant - placed.time - self.delay)
        if beyond > LONGEST_AGE and beyond > PERIODS * self._clock.period:
            return self._admission.refuse(Reason.NO_NEW_READING)
        bank, wanted = self._bank, self.covariance_wanted
        early = self._settled < SHORTEST
        if (bank.count + 1 < self.min_samples
                or early and not self._clock.period and self._admission.at_once > MOST_AT_ONCE
                or bank.read(placed.instant - self.delay / placed.rate, placed.time is not None,
                             placed.rate, wanted or early)
                or early and not bank.clear_of_noise()):
            return Reason.SETTLING
        values = bank.values()
        if not wanted:
            return JointMotion(stamp - self.delay, values)
        error = self._clock.error
        motion = JointMotion(stamp - self.delay, values,
                             BankCovariance(bank.variances(), values, error))
        motion.clock_error = error
        return motion
