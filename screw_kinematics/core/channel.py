# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: initializedcheck=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The filters of signals that are sampled together, weighed by likelihood.

Lane = joint * M + filter; tables have one row for each quantity and one column for each lane.
"""
from __future__ import annotations

from array import array

try:
    import cython
except ImportError:
    from . import uncompiled as cython
from .gains import Gains
from .tables import EVIDENCE, LEAST, NOTHING, table, zeros
if cython.compiled:
    from cython.cimports.libc.math import exp, fabs, floor, isfinite, log, sqrt
else:
    from math import exp, fabs, floor, isfinite, log, sqrt

HOLD = cython.declare(cython.double, 6.0)
"""Deviation, in deviations foreseen, beyond which a sample waits for the next one."""

LONGEST_WAIT = cython.declare(cython.int, 3)
"""Samples that may wait."""

CONFIRMED = cython.declare(cython.double, 0.75)
"""Share of what the velocity tells up to which it and the position may have come apart for both to
say that the joint was pushed."""

FRESH = cython.declare(cython.double, 2.0)
ANEW = cython.declare(cython.double, 0.5)
WILD = cython.declare(cython.double, 20.0)
"""Samples that scores are worth when the motion has jumped, and how many more with each one since:
those before tell of another motion. Jumps so many times larger than a joint makes are none."""

HALVES = cython.declare(cython.double, 2.0**29 + 1.0)
"""Factor that splits a number into halves, the upper one of single precision."""

EXACT = cython.declare(cython.double, 0.7)
"""Share of changes that are multiples of a step from which on it is an encoder's."""


class Signal:
    """What is known of one signal's samples."""

    def __init__(self) -> None:
        self.last = self.quantum = self.vague = self.fit = self.changes = self.noise = 0.0
        self.limit = self.step = self.s0 = self.s1 = self.s2 = self.s3 = self.least = 0.0
        self.taken = self.scores = False
        self.start(0.0)

    def start(self, z: cython.double) -> None:
        """Begin a run with a sample."""
        self.last = z
        self.pending = self.envelope = self.parted = self.since = 0.0
        self.waiting = self.odd = 0
        self.fresh = 1e6

    def step_of_encoder(self) -> cython.double:
        """Return the encoder's step; 0 if there seems to be none."""
        return self.quantum if self.fit > EXACT else 0.0

    def rounding(self) -> cython.double:
        """Return the variance of what the encoder's steps round off."""
        step: cython.double = self.step_of_encoder()
        return step * step / 12.0

    def follow_quantum(self, z: cython.double) -> None:
        """Follow the step of which all changes are multiples, by Euclid's algorithm."""
        d: cython.double = fabs(z - self.last)
        # Positions that went through single precision are no exact multiples. Where they have no
        # more digits yet (their upper half is all of them: Dekker 1971), nor has the step.
        rounding: cython.double = 6e-8 * (fabs(z) + fabs(self.last))
        upper: cython.double = HALVES * z - (HALVES * z - z)
        vague: cython.double = rounding if upper == z else 0.0
        self.last = z
        if d < 1e-12:
            return
        q: cython.double = self.quantum
        self.changes += 1.0
        if q == 0.0:
            self.quantum, self.vague = d, vague
            self.changes = 1.0
            if self.fit == 0.0:
                self.fit = 1.0
            return
        times: cython.double = floor(d / q + 0.5)
        rest: cython.double = fabs(d - q * times)
        self.fit += 0.05 * ((1.0 if rest < 0.1 * q else 0.0) - self.fit)
        sure: cython.bint = times * self.vague < 0.1 * q
        off: cython.double = rounding + (times * self.vague if sure else 0.1 * q)
        if rest > (1e-6 * q if 1e-6 * q > off else off):
            self.quantum, self.vague = rest, off if vague > 0.0 else 0.0
        elif self.fit < 0.3 and self.changes > 60.0:
            self.quantum = 0.0
        elif sure and rounding < times * self.vague:
            self.quantum, self.vague = d / times, rounding / times


class Channel:
    """
    What a bank keeps of n positions, or of n velocities.

    ``price`` becomes each filter's handicap, a factor of its mean squares; ``delayed`` is whether
    the latest steps are remembered.
    """

    def __init__(self, n: int, gains: Gains, price: cython.double[::1], delayed: bool) -> None:
        m = gains.m
        self.n, self.m, self.gains, self.price, self.delayed = n, m, gains, price, delayed
        self.signals = [Signal() for _ in range(n)]
        self.x = table(4, n * m)
        self.mean, self.before, self.weight = zeros(n * m), zeros(n * m), zeros(n * m)
        self.low, self.high = memoryview(array('q', [0] * n)), memoryview(array('q', [m] * n))
        self.error = zeros(m)
        self.states, self.errors = table(1, 1), table(1, 1)
        self.excess, self.tail, self.told = table(3, n * m), table(3, n), 0.0
        self.shaken, self.paused, self.lately = False, 0.0, 1.0

    def signal(self, j: cython.Py_ssize_t) -> Signal:
        """Return what is known of a signal."""
        return self.signals[j]

    def start(self, z: cython.double[::1]) -> None:
        """Begin a run with a sample."""
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        k: cython.Py_ssize_t
        self.told = 0.0
        for j in range(self.n):
            self.signal(j).start(z[j])
            self.low[j], self.high[j] = 0, self.m
            for i in range(3):
                self.tail[i, j] = 0.0
            for k in range(j * self.m, (j + 1) * self.m):
                self.x[0, k] = z[j]
                for i in range(1, 4):
                    self.x[i, k] = self.excess[i - 1, k] = 0.0
                self.mean[k] = self.before[k] = 0.0
                self.weight[k] = 1.0 / self.m

    def advance(self, z: cython.double[::1], instead: cython.double[::1]) -> None:
        """Take a sample of all signals; `instead` stands in for what is NaN."""
        j: cython.Py_ssize_t
        self.predict()
        for j in range(self.n):
            self.judge(self.signal(j), j, z[j], instead[j])
            if self.delayed:
                self.remember(j)
            self.update(self.signal(j), j)
            self.weigh(self.signal(j), j)

    def predict(self) -> None:
        """Predict the states at the sample."""
        k: cython.Py_ssize_t
        r: cython.double = self.r
        r2: cython.double = r * r
        r3: cython.double = r2 * r
        for k in range(self.n * self.m):
            x3: cython.double = self.x[3, k]
            x2: cython.double = self.x[2, k]
            x1: cython.double = self.x[1, k]
            self.x[0, k] = self.x[0, k] + r * x1 + r2 * x2 + r3 * x3
            self.x[1, k] = x1 + 2.0 * r * x2 + 3.0 * r2 * x3
            self.x[2, k] = x2 + 3.0 * r * x3

    def judge(self, u: Signal, j: cython.Py_ssize_t, at: cython.double,
              instead: cython.double) -> None:
        """Decide what the sample of a signal is worth; find the innovations of its filters."""
        k: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        first: cython.Py_ssize_t = j * m
        known: cython.bint = isfinite(at)
        same: cython.bint = at == u.last
        if known:
            u.follow_quantum(at)
        # Noise is never below that of rounding: silence between two steps proves nothing.
        least: cython.double = u.rounding()
        foreseen: cython.double = 0.0
        noise: cython.double = 0.0
        variance: cython.double = 0.0
        for k in range(self.low[j], self.high[j]):
            foreseen += self.weight[first + k] * self.x[0, first + k]
        for k in range(self.low[j], self.high[j]):
            w: cython.double = self.weight[first + k]
            apart: cython.double = self.x[0, first + k] - foreseen
            own: cython.double = self.mean[first + k]
            own = own if own > least else least
            noise += w * own
            variance += w * (self.gains.s[k] * own + apart * apart)
        u.noise, u.least, u.odd = noise, least, 0
        counts: cython.bint = known
        if known and not self.settling:
            if u.waiting > 0:
                counts = self.decide(u, first, at)
            else:
                counts = self.admit(u, first, at - foreseen,
                                    HOLD * (sqrt(variance) + u.envelope), same)
                if u.waiting > 0:
                    u.s0 = foreseen
        u.scores = counts and self.determined
        if not counts:
            at = foreseen if known else instead
        for k in range(m):
            self.error[k] = at - self.x[0, first + k]

    def remember(self, j: cython.Py_ssize_t) -> None:
        """Remember predicted states and innovations of a signal."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        first: cython.Py_ssize_t = j * self.m
        lanes: cython.Py_ssize_t = self.n * self.m
        for i in range(4):
            for k in range(first, first + self.m):
                self.states[self.slot, i * lanes + k] = self.x[i, k]
        for k in range(self.m):
            self.errors[self.slot, first + k] = self.error[k]

    def update(self, u: Signal, j: cython.Py_ssize_t) -> None:
        """Let the innovations change the states of a signal; follow their mean squares."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        share: cython.double = self.share if u.scores else 0.0
        for k in range(self.m):
            i = j * self.m + k
            error: cython.double = self.error[k]
            self.x[0, i] += self.gains.gain[0, k] * error
            self.x[1, i] += self.gains.gain[1, k] * error
            self.x[2, i] += self.gains.gain[2, k] * error
            self.x[3, i] += self.gains.gain[3, k] * error
            self.mean[i] += share * (error * error * self.gains.precision[k] - self.mean[i])

    def admit(self, u: Signal, first: cython.Py_ssize_t, deviation: cython.double,
              limit: cython.double, same: cython.bint) -> cython.bint:
        """Return whether a sample counts now; one that is improbable waits for the next."""
        k: cython.Py_ssize_t
        w: cython.double[::1] = self.weight
        x: cython.double[:, ::1] = self.x
        if fabs(deviation) <= limit:
            u.envelope += 0.2 * (fabs(deviation) - u.envelope)
            return True
        u.waiting = 1
        u.pending = deviation
        u.limit, u.step = limit, self.r
        u.since = u.parted
        u.taken = self.confirmed(u, deviation) or fabs(deviation) < self.plausible and not same
        s1: cython.double = 0.0
        s2: cython.double = 0.0
        s3: cython.double = 0.0
        for k in range(first, first + self.m):
            s1 += w[k] * x[1, k]
            s2 += w[k] * x[2, k]
            s3 += w[k] * x[3, k]
            self.before[k] = self.mean[k]
        u.s1, u.s2, u.s3 = s1, s2, s3
        return u.taken

    def confirmed(self, u: Signal, deviation: cython.double) -> cython.bint:
        """Whether position and velocity agree on a deviation, since the first that waits."""
        told: cython.double = self.half * deviation if self.half > 0.0 else u.since + deviation
        return fabs(u.since) < CONFIRMED * fabs(told)

    def decide(self, u: Signal, first: cython.Py_ssize_t, at: cython.double) -> cython.bint:
        """
        Decide, by the sample after it, about the sample that waits; return whether that counts.

        Its own deviation p, the next one's d0 from where the joint would be without it: back
        within the limit, it was odd and is forgotten; confirmed, or as many times p as if velocity
        or acceleration had jumped, it was real, and what it says is added now. Else the next one
        waits too.
        """
        k: cython.Py_ssize_t
        r: cython.double = self.r
        r2: cython.double = r * r
        r3: cython.double = r2 * r
        s3: cython.double = u.s3
        s2: cython.double = u.s2 + 3.0 * r * s3
        s1: cython.double = u.s1 + 2.0 * r * u.s2 + 3.0 * r2 * s3
        s0: cython.double = u.s0 + r * u.s1 + r2 * u.s2 + r3 * s3
        deviation: cython.double = at - s0
        ratio: cython.double = deviation / u.pending
        # With a delay it is enough that the joint has gone on from where it seemed to be.
        u.since = u.parted if self.delayed else u.since + u.parted
        # Of equal steps 2, 4, 8 for a jump of velocity, acceleration, jerk; less after a pause.
        onward: cython.double = r / u.step if r < u.step else 1.0
        least: cython.double = exp(0.58 * log(1.0 + onward))
        most: cython.double = exp(3.17 * log(1.0 + onward))
        if fabs(deviation) <= u.limit and ratio < 0.5:      # it was odd
            u.odd = u.waiting
            if u.taken:
                self.correct(first, -u.pending, u.waiting)
                for k in range(first, first + self.m):
                    self.mean[k] = self.before[k]
        elif (not u.taken and (ratio < least or ratio > most) and u.waiting < LONGEST_WAIT
                and not self.confirmed(u, deviation)):
            u.waiting += 1
            u.s0, u.s1, u.s2 = s0, s1, s2
            if ratio <= 0.5 or ratio > most:
                u.pending = deviation
            return False
        elif not u.taken:                                   # it was real
            self.correct(first, u.pending, u.waiting)
            if self.plausible == 0.0 and fabs(u.pending) < WILD * self.possible:
                u.fresh = FRESH
        u.waiting = 0
        size: cython.double = fabs(deviation)
        size = size if size < 3.0 * u.limit else 3.0 * u.limit
        u.envelope += 0.2 * (size - u.envelope)
        return True

    def correct(self, first: cython.Py_ssize_t, change: cython.double,
                waiting: cython.int) -> None:
        """Let the sample that waited, so many ago, have been another, by what it would change."""
        k: cython.Py_ssize_t
        r: cython.double = self.r
        r2: cython.double = r * r
        r3: cython.double = r2 * r
        x: cython.double[:, ::1] = self.x
        h: cython.double[:, ::1] = self.gains.before
        size: cython.Py_ssize_t = self.errors.shape[0]
        for k in range(self.m):
            x[0, first + k] += change * (h[0, k] + r * h[1, k] + r2 * h[2, k] + r3 * h[3, k])
            x[1, first + k] += change * (h[1, k] + 2.0 * r * h[2, k] + 3.0 * r2 * h[3, k])
            x[2, first + k] += change * (h[2, k] + 3.0 * r * h[3, k])
            x[3, first + k] += change * h[3, k]
            if self.delayed:
                self.errors[(self.slot - waiting + size) % size, first + k] += change

    def weigh(self, u: Signal, j: cython.Py_ssize_t) -> None:
        """Turn the likelihoods of a signal's filters into weights, if its sample tells of them."""
        k: cython.Py_ssize_t
        first: cython.Py_ssize_t = j * self.m
        low: cython.Py_ssize_t = 0
        high: cython.Py_ssize_t = 0
        best: cython.double = 1e300
        total: cython.double = 0.0
        if not u.scores:
            return
        for k in range(self.m):
            own: cython.double = self.mean[first + k]
            own = ((own if own > u.least else u.least) + LEAST) * self.price[k]
            self.weight[first + k] = own
            best = own if own < best else best
        evidence: cython.double = self.evidence
        worst: cython.double = best * self.reach
        fresh: cython.double = -0.5 * EVIDENCE * u.fresh
        u.fresh += ANEW
        if fresh > evidence:
            evidence = fresh
            worst = best * exp(NOTHING / fresh)
        for k in range(self.m):
            own = self.weight[first + k]
            if own > best:      # else it is 1
                own = exp(evidence * log(own / best)) if own < worst else 0.0
            else:
                own = 1.0
            self.weight[first + k] = own
            if own > 0.0:
                low = k if high == 0 else low
                high = k + 1
                total += own
        total = 1.0 / total
        self.low[j], self.high[j] = low, high
        for k in range(first + low, first + high):
            self.weight[k] *= total

    def average(self, scale: cython.double[::1], out: cython.double[:, ::1]) -> None:
        """Find the weighted states."""
        j: cython.Py_ssize_t
        k: cython.Py_ssize_t
        for j in range(self.n):
            m0: cython.double = 0.0
            m1: cython.double = 0.0
            m2: cython.double = 0.0
            m3: cython.double = 0.0
            for k in range(j * self.m + self.low[j], j * self.m + self.high[j]):
                w: cython.double = self.weight[k]
                m0 += w * self.x[0, k]
                m1 += w * self.x[1, k]
                m2 += w * self.x[2, k]
                m3 += w * self.x[3, k]
            out[0, j], out[1, j] = m0, m1 / scale[1]
            out[2, j], out[3, j] = m2 / scale[2], m3 / scale[3]
