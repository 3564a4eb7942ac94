# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: initializedcheck=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Integrated-Wiener Kalman filters of many bandwidths for each joint, weighed by likelihood.

The same bank twice: one for positions and, with the same gains, one for velocities.
"""
from __future__ import annotations

from collections.abc import Sequence

try:
    import cython
except ImportError:
    from . import uncompiled as cython
from .channel import Channel
from .gains import Gains
from .mixture import Mixture
from .spread import Spread
from .steps import Pace, Steps
from .tables import (
    DENSEST, EVIDENCE, FINEST, NOTHING, row, SCALE, SPARSE, table, TIME_UNIT, WINDOW, zeros)
from .travel import Travel
from .velocity_trust import Fading, VelocityTrust
if cython.compiled:
    from cython.cimports.libc.math import exp, fabs, isfinite, sqrt
else:
    from math import exp, fabs, isfinite, sqrt

    from .readings import fill

PRIOR = (1.0, 2e5, 1.5e6, 3e7)
"""Deviations of the state before the first sample, in units of the noise, per s ..."""

PLAUSIBLE = cython.declare(cython.double, 220.0)
SLOW = cython.declare(cython.double, 3e-3)
"""A jump that this acceleration [rad/s2] explains need not wait, where samples are this far apart
[s]."""

DETERMINED = cython.declare(cython.longlong, 5)
"""Samples that only determine the state, and say nothing of the filters."""

FIRST_WAIT = cython.declare(cython.longlong, 12)
FIRST_FUSED = cython.declare(cython.longlong, 30)
"""Samples from which on an improbable one waits, and velocities enter the output."""

LONGEST_MISSING = cython.declare(cython.int, 20)
"""Samples without velocities after which there are none."""

NAN = cython.declare(cython.double, float('nan'))

# What `read` answers.
READ = cython.declare(cython.int, 0)
TOO_EARLY = cython.declare(cython.int, 1)
TOO_LONG_AGO = cython.declare(cython.int, 2)


class Bank:
    """
    A bank for n joints; see the module.

    ``bandwidths`` are, of each filter, the order of its model and its bandwidth [Hz]. ``wide`` is
    the handicap of wide filters: what the logarithm of the innovation's variance counts more.
    ``delay`` is how long before the latest sample instants are read [s]. ``noise`` is the variance
    of the positions' noise, for their covariance; 0: it is estimated.
    """

    def __init__(self, n: int, bandwidths: Sequence, wide: float, delay: float,
                 noise: float = 0.0) -> None:
        self.n, self.wide, self.delay, self.delayed = n, wide, delay, delay > 0.0
        self.gains = Gains(bandwidths)
        self.m = self.gains.m
        self.prior = row([(deviation * scale) ** 2 for deviation, scale in zip(PRIOR, SCALE)])
        self.scale, self.lsum, self.price = row(SCALE), zeros(self.m), zeros(self.m)
        self.position = Channel(n, self.gains, self.price, self.delayed)
        self.velocity = Channel(n, self.gains, self.price, self.delayed)
        self.trust, self.keep = [VelocityTrust() for _ in range(n)], Fading()
        self.steps, self.pace = Steps(self.gains), Pace()
        self.of_position = Mixture(self.position, self.gains, self.steps, self.delayed, 2)
        self.of_velocity = Mixture(self.velocity, self.gains, self.steps, self.delayed, 1)
        self.spread = Spread(n, self.gains, self.steps, self.delayed, noise)
        self.travelled = Travel(n)
        self.now, self.out, self.instead = table(4, n), table(14, n), zeros(n)
        self.at, self.speed = zeros(n), zeros(n)
        self.make_room(32 if self.delayed else 1)
        self.start(0.0, [0.0] * n)

    def start(self, time: cython.double, position: Sequence[float]) -> None:
        """Begin a run at a position."""
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        self.count, self.time, self.dt, self.rate = 0, time, 0.0, 1.0
        self.span = self.evidence = self.reach = 0.0
        self.pace.start(time)
        self.steady, self.missing, self.with_velocity = 0, 0, False
        self.steps.clear()
        self.gains.start(self.prior)
        for i in range(self.m):
            self.lsum[i], self.price[i] = 0.0, 1.0
        fill(self.at, position)
        self.position.start(self.at)
        self.spread.start()
        for j in range(self.n):
            for i in range(4):
                self.now[i, j] = 0.0
            self.now[0, j] = self.at[j]
            self.trust_in(j).await_sample()

    def trust_in(self, j: cython.Py_ssize_t) -> VelocityTrust:
        """Return what is known of a joint's velocity."""
        return self.trust[j]

    # ---- a sample

    def measure(self, time: cython.double, position: Sequence[float], velocity: Sequence[float],
                measured: cython.bint, rate: cython.double) -> None:
        """
        Take a sample, later than the one before.

        It was taken at a time [s]. The velocity is read if it was measured; ``rate`` is how many
        seconds of the clock that velocities are of are in a second of `time`.
        """
        j: cython.Py_ssize_t
        fill(self.at, position)
        if measured:
            fill(self.speed, velocity)
        dt: cython.double = time - self.time
        self.time, self.dt, self.rate = time, dt, rate
        self.count += 1
        step: cython.double = self.pace.follow(self.count, time, dt)
        self.steady = self.steady + 1 if self.gains.follow(step, self.pace.period) else 0
        share: cython.double = 1.0 - exp(-dt / WINDOW)
        if self.count > DETERMINED:
            first: cython.double = 1.0 / (self.count - DETERMINED)
            share = share if share > first else first
            self.span = (1.0 - share) * self.span + 1.0
            self.handicap(share)
        slot: cython.Py_ssize_t = 0
        if self.delayed:
            if self.steps.crowded(time - 1.25 * self.delay - dt):
                self.make_room(2 * self.steps.size)
            slot = self.steps.remember(time, step)
        # With a delay what comes after the instant tells.
        jump: cython.double = PLAUSIBLE * dt if not self.delayed else 0.0
        for j in range(self.n):
            parted: cython.double = self.trust_in(j).parted(
                self.at[j], self.speed[j] * rate if measured and self.with_velocity else NAN, dt)
            self.position.signal(j).parted = self.velocity.signal(j).parted = parted
        self.prepare(self.position, share, 0.5 * dt * jump, 0.0, slot)
        self.position.advance(self.at, self.at)
        self.position.average(self.scale, self.now)
        if not measured and not self.with_velocity:
            return
        self.missing = 0 if measured else self.missing + 1
        if not self.with_velocity:
            self.with_velocity = True
            for j in range(self.n):
                self.trust_in(j).await_sample()
                self.instead[j] = (self.speed[j] if isfinite(self.speed[j])
                                   else self.now[1, j] / rate)
            self.velocity.start(self.instead)
        else:
            whole: cython.bint = measured
            for j in range(self.n):
                whole = whole and isfinite(self.speed[j])
            for j in range(self.n):
                self.instead[j] = self.speed[j] if whole else self.now[1, j] / rate
            self.prepare(self.velocity, share, jump, 0.5 * dt * rate, slot)
            self.velocity.advance(self.speed if measured else self.instead, self.instead)
        self.keep.after(dt)
        for j in range(self.n):
            self.trust_in(j).compare(
                self.at[j], self.speed[j] * rate if measured else NAN, dt, self.keep,
                self.now[2, j], self.position.signal(j).noise, self.count <= FIRST_WAIT)
        self.with_velocity = self.missing < LONGEST_MISSING

    def handicap(self, share: cython.double) -> None:
        """Follow what wide filters pay for their innovations' variances, and what scores tell."""
        k: cython.Py_ssize_t
        wide: cython.double = self.wide
        if self.delayed:
            dense: cython.double = SPARSE / self.pace.period
            dense = dense if dense < DENSEST else DENSEST
            wide *= sqrt(dense)
        for k in range(self.m):
            before: cython.double = self.lsum[k]
            self.lsum[k] += share * ((1.0 + wide) * self.gains.logs[k] - before)
            if self.lsum[k] != before:
                self.price[k] = exp(self.lsum[k])
        self.evidence = -0.5 * EVIDENCE * self.span
        self.reach = exp(NOTHING / self.evidence)

    def prepare(self, c: Channel, share: cython.double, possible: cython.double,
                half: cython.double, slot: cython.Py_ssize_t) -> None:
        """Tell a channel of the step to its next sample."""
        c.r, c.share, c.possible = self.dt / TIME_UNIT, share, possible
        c.plausible = possible if self.dt > SLOW else 0.0
        c.evidence, c.reach = self.evidence, self.reach
        c.settling, c.slot, c.half = self.count <= FIRST_WAIT, slot, half
        c.determined, c.shaken = self.count > DETERMINED, self.pace.felt(self.time)
        c.paused = self.pace.pause

    def make_room(self, size: int) -> None:
        """Make room for so many steps; those that are remembered stay."""
        lanes = self.n * self.m
        for c in (self.position, self.velocity):
            c.states = self.steps.moved(c.states, size, 4 * lanes)
            c.errors = self.steps.moved(c.errors, size, lanes)
        self.steps.make_room(size)
        self.of_position.p = self.of_velocity.p = (
            self.steps.smoothed if self.delayed else self.gains.p)

    # ---- reading

    def read(self, at: cython.double, fresh: cython.bint, rate: cython.double,
             spread: cython.bint) -> cython.int:
        """
        Find the motion at an instant [s].

        ``fresh`` is whether a sample was taken since the last time, ``spread`` whether the
        covariance is wanted; ``rate`` is as for `measure`: derivatives are by that clock. Return
        READ, and `values` and `variances` are those; TOO_EARLY: before the run began;
        TOO_LONG_AGO: more steps ago than are remembered.
        """
        j: cython.Py_ssize_t
        k: cython.Py_ssize_t
        i: cython.longlong = self.count
        found: Mixture = self.of_position
        if self.delayed:
            i = self.steps.nearest(at)
            if i <= 0:
                return TOO_EARLY if i == 0 else TOO_LONG_AGO
            self.steps.make_taps(i, self.gains.step, self.steady)
        if spread and fresh:
            self.spread.begin(self.position, self.dt)
            self.spread.begin(self.velocity, self.dt)
        for j in range(self.n):
            found.look(j, i, at, self.time, spread)
            found.mix(j, self.pace.period)
            for k in range(4):
                self.out[k, j] = found.mean[k] / self.scale[k]
            if spread:
                self.spread.tell(found, self.position, j, self.dt if fresh else 0.0,
                                 self.out)
            if self.with_velocity:
                self.fuse(self.trust_in(j), j, at, fresh, spread)
            self.out[1, j] /= rate
            self.out[2, j] /= rate * rate
            self.out[3, j] /= rate * rate * rate
        return READ

    def fuse(self, trust: VelocityTrust, j: cython.Py_ssize_t, at: cython.double,
             fresh: cython.bint, spread: cython.bint) -> None:
        """Let the velocity's acceleration into what was read of a joint, by its weight."""
        trust.share = 0.0
        if self.count < FIRST_FUSED or not trust.usable():
            return
        found: Mixture = self.of_velocity
        unit: cython.double = TIME_UNIT
        ap: cython.double = self.out[2, j]
        sp: cython.double = self.of_position.variance * 4.0 / (unit * unit * unit * unit) + 1e-12
        wanted: cython.double = at + trust.lag
        i: cython.longlong = self.steps.nearest(wanted) if self.delayed else self.count
        found.look(j, i, wanted, self.time, spread)
        found.mix(j, self.pace.period)
        scale: cython.double = (1.0 + trust.scale) / self.rate
        av: cython.double = found.mean[1] / unit / scale
        sv: cython.double = found.variance / (unit * unit) + 1e-12
        w: cython.double = trust.weigh(av - ap, found.wider / unit / scale, sp, sv, self.keep,
                                       fresh)
        faster: cython.double = found.mean[0] / scale - self.out[1, j]
        if spread:
            made_good: cython.double = 0.0      # across a pause lag and scale are not found
            if self.position.shaken:
                made_good = fabs(trust.lag * av) + fabs(trust.scale * found.mean[0])
            self.spread.fuse(found, self.velocity, j, self.dt if fresh else 0.0, w, scale, faster,
                             av - ap, made_good * made_good, self.out)
        self.out[2, j] = ap + w * (av - ap)
        self.out[1, j] += w * faster
        self.out[3, j] += w * (found.mean[2] / self.scale[2] / scale - self.out[3, j])

    def values(self) -> list[float]:
        """Return position, velocity, acceleration and jerk that were read, in a row."""
        return in_a_row(self.out, 0, 4)

    def clear_of_noise(self) -> bool:
        """Whether accelerations, read with covariance, are clear of error, or it is little."""
        return self.spread.clear(self.position, self.count - DETERMINED, self.out)

    def variances(self) -> list[float]:
        """Return the upper triangle of the covariance of each joint: 10 n numbers, by rows."""
        return in_a_row(self.out, 4, 14)

    # ---- what the clock asks

    def travel(self, position: tuple[float, ...], unit: cython.double, span: cython.double,
               unforeseen: cython.double) -> tuple[float, float, tuple[float, ...]]:
        """Return ticks travelled, length of the move in one [rad], agreed positions: `Travel`."""
        j: cython.Py_ssize_t
        for j in range(self.n):
            self.speed[j] = self.now[1, j]
            if self.with_velocity:
                self.speed[j] = self.trust_in(j).speed(self.now[1, j], self.now[2, j])
        fill(self.at, position)
        self.travelled.measure(self.now, self.speed, self.at, unit, span, unforeseen)
        if self.travelled.odd:
            position = tuple([self.travelled.agreed[j] for j in range(self.n)])
        return self.travelled.ticks, self.travelled.tick, position

    def odds_against_repeating(self, unit: cython.double) -> float:
        """
        Return log odds against all encoders reading the same again after a time [s].

        Of a joint that goes on by a part u of a step that is - log(1 - u), nearly u + u^2; which
        is finite beyond a step, too, as it should: how far joints go is not known exactly.
        """
        j: cython.Py_ssize_t
        odds: cython.double = 0.0
        for j in range(self.n):
            step: cython.double = max(self.position.signal(j).step_of_encoder(), FINEST)
            steps: cython.double = fabs(self.now[1, j]) * unit / step
            odds += steps * (1.0 + steps)
        return odds

    # ---- what others ask

    def odd(self) -> list[int]:
        """Return by joint how many samples before the latest one that shows to be odd."""
        j: cython.Py_ssize_t
        odd = []
        for j in range(self.n):
            odd.append(self.position.signal(j).odd)
        return odd

    def state(self) -> list[float]:
        """Return the weighted state after the latest sample, in a row."""
        return in_a_row(self.now, 0, 4)

    def velocity_facts(self) -> list[tuple[float, bool, float, float, float]]:
        """
        Return what is known of each joint's velocity.

        Samples that were not zero; whether it is merely differenced; lag [s]; share by which it
        is too large; its weight in the latest output.
        """
        return [(trust.alive, trust.differenced(), trust.lag, trust.scale, trust.share)
                for trust in self.trust]


def in_a_row(t: cython.double[:, ::1], first: cython.Py_ssize_t, end: cython.Py_ssize_t) -> list:
    """Return the numbers of some rows of a table."""
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    k: cython.Py_ssize_t = 0
    n: cython.Py_ssize_t = t.shape[1]
    numbers: list = [0.0] * ((end - first) * n)
    for i in range(first, end):
        for j in range(n):
            numbers[k] = t[i, j]
            k += 1
    return numbers
