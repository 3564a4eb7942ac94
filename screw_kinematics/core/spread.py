# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: initializedcheck=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
How far a mixture of filters may be from the truth: the covariance that is told of it.

A filter errs by the noise that it lets pass, which its covariance tells, and by the motion that it
does not follow, which shows in how far the next wider filter of its order is from it: more than
noise would make of that.
"""
from __future__ import annotations

try:
    import cython
except ImportError:
    from . import uncompiled as cython
from .channel import Channel
from .gains import Gains
from .mixture import Mixture
from .steps import Steps
from .tables import FINEST, LEAST, row, SCALE, table, TIME_UNIT, zeros
if cython.compiled:
    from cython.cimports.libc.math import exp, log, sqrt
else:
    from math import exp, log, sqrt

MEMORY = cython.declare(cython.double, 0.3)
"""Of the squares of differences, s."""

NOISE = cython.declare(cython.double, 0.7)
"""Variance of the difference of neighbours that is noise, over that of the wider one."""

IN_POSITION = cython.declare(cython.double, 0.98)
IN_VELOCITY = cython.declare(cython.double, 0.7)
IN_ACCELERATION = cython.declare(cython.double, 0.48)
"""Share of filters' variances that is noise: of smoothers' 7/8, 5/8 and 3/8. The rest is motion
as their model expects it, but that differs."""

AMPLE = cython.declare(cython.double, 3.0)
FADING = cython.declare(cython.double, 0.02)
"""Factor of what is not known in a pause, and how fast that fades after it, s."""

CLEAR = cython.declare(cython.double, 16.0)
STUDENT = cython.declare(cython.double, 15.0)
SLOWLY = cython.declare(cython.double, 0.3)
BRIEFLY = cython.declare(cython.double, 0.015)
"""By how much a signal's square has to be more than its variance to be clear of error, and by how
much more if one sample tells it (Student's distribution). An acceleration that takes so long [s]
to make the velocity is as clear as that; one that makes no step of the encoder so soon is none."""


class Spread:
    """
    Tells the covariance of one signal's mixture after the other.

    ``delayed`` is whether instants are before the latest step; ``known_noise`` is the variance of
    the noise, whose filters are then the truth; 0: it is estimated.
    """

    def __init__(self, n: int, gains: Gains, steps: Steps, delayed: bool,
                 known_noise: float) -> None:
        self.gains, self.steps, self.m = gains, steps, gains.m
        self.delayed, self.known_noise = delayed, known_noise
        self.work, self.second, self.apart = table(10, 1), table(14, n), table(2, n)
        self.n, self.scale, self.told = n, row(SCALE), zeros(n)

    def start(self) -> None:
        """Begin a run, of which nothing was told."""
        j: cython.Py_ssize_t
        for j in range(self.n):
            self.told[j] = 0.0

    def tell(self, found: Mixture, c: Channel, j: cython.Py_ssize_t, dt: cython.double,
             out: cython.double[:, ::1]) -> None:
        """
        Write the covariance of signal j, whose mixture was looked at last, from row 4 on, in SI.

        `dt`: how long after the latest sample that was told of [s]; 0 if this is it.
        """
        if dt > 0.0:
            self.compare(found, c, j)
        self.mix(found, c, j)
        if c.shaken and self.known_noise == 0.0:
            # At a step, but for rounding, that is the next one.
            self.pause(c, j, dt,
                       self.steps.latest - found.top // 10 + (1 if found.r > -1e-6 else 0))
        self.carry(found.r, j, out)

    def begin(self, c: Channel, dt: cython.double) -> None:
        """Begin to tell of a channel's signals, so long after the time before [s]."""
        c.told += 1.0
        c.lately = 1.0 - exp(-dt / MEMORY)
        c.lately = c.lately if c.lately * c.told > 1.0 else 1.0 / c.told

    def compare(self, found: Mixture, c: Channel, j: cython.Py_ssize_t) -> None:
        """Follow by how much each filter differs from the next wider one beyond noise."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        first: cython.Py_ssize_t = j * self.m
        share: cython.double = c.lately
        x: cython.double[:, ::1] = found.states
        p: cython.double[:, ::1] = found.p
        four: cython.double[::1] = self.gains.four
        excess: cython.double[:, ::1] = c.excess
        for i in range(3):
            top: cython.Py_ssize_t = found.top + 3 * i + (1 if i > 0 else 0)
            for k in range(self.m - 1):
                if four[k] != four[k + 1]:
                    continue
                d: cython.double = x[i, found.first + k] - x[i, found.first + k + 1]
                d = d * d
                if c.shaken and d > excess[i, first + k]:
                    excess[i, first + k] = d
                else:
                    d -= NOISE * c.mean[first + k + 1] * p[top, k + 1]
                    excess[i, first + k] += share * (d - excess[i, first + k])

    def mix(self, found: Mixture, c: Channel, j: cython.Py_ssize_t) -> None:
        """Find the covariance at the step, scaled: within and between the filters."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        first: cython.Py_ssize_t = j * self.m
        x: cython.double[:, ::1] = found.states
        p: cython.double[:, ::1] = found.p
        top: cython.Py_ssize_t = found.top
        w: cython.double[::1] = c.weight
        mean: cython.double[::1] = c.mean
        excess: cython.double[:, ::1] = c.excess
        e: cython.double[:, ::1] = self.work
        # Noise is never below that of rounding, however well some samples lie on a line; nor is it
        # nothing, as a covariance of zeros would mean that it is unknown.
        least: cython.double = c.signal(j).rounding() + LEAST
        for i in range(10):
            e[i, 0] = 0.0
        # The mean at the instant, carried back to the step.
        r: cython.double = found.r
        m3: cython.double = found.mean[3]
        m2: cython.double = found.mean[2] - 3.0 * r * m3
        m1: cython.double = found.mean[1] - r * (2.0 * m2 + 3.0 * r * m3)
        m0: cython.double = found.mean[0] - r * (m1 + r * (m2 + r * m3))
        n0: cython.double = 0.0         # what noise adds to position, velocity and acceleration,
        n1: cython.double = 0.0
        n2: cython.double = 0.0
        b0: cython.double = 0.0         # and how far motion leaves the mixture behind
        b1: cython.double = 0.0
        b2: cython.double = 0.0
        for k in range(self.m):
            v: cython.double = w[first + k]
            if v == 0.0:
                continue
            noise: cython.double = mean[first + k] if mean[first + k] > least else least
            s: cython.double = v * (self.known_noise if self.known_noise > 0.0 else noise)
            d0: cython.double = x[0, found.first + k] - m0
            d1: cython.double = x[1, found.first + k] - m1
            d2: cython.double = x[2, found.first + k] - m2
            d3: cython.double = x[3, found.first + k] - m3
            e[0, 0] += s * p[top, k] + v * d0 * d0
            e[1, 0] += s * p[top + 1, k] + v * d0 * d1
            e[2, 0] += s * p[top + 2, k] + v * d0 * d2
            e[3, 0] += s * p[top + 3, k] + v * d0 * d3
            e[4, 0] += s * p[top + 4, k] + v * d1 * d1
            e[5, 0] += s * p[top + 5, k] + v * d1 * d2
            e[6, 0] += s * p[top + 6, k] + v * d1 * d3
            e[7, 0] += s * p[top + 7, k] + v * d2 * d2
            e[8, 0] += s * p[top + 8, k] + v * d2 * d3
            e[9, 0] += s * p[top + 9, k] + v * d3 * d3
            n0 += s * p[top, k]
            n1 += s * p[top + 4, k]
            n2 += s * p[top + 7, k]
            if excess[0, first + k] > 0.0:
                b0 += v * sqrt(excess[0, first + k])
            if excess[1, first + k] > 0.0:
                b1 += v * sqrt(excess[1, first + k])
            if excess[2, first + k] > 0.0:
                b2 += v * sqrt(excess[2, first + k])
        if self.known_noise > 0.0:
            return
        self.add(0, (IN_POSITION - 1.0) * n0 + b0 * b0)
        self.add(1, (IN_VELOCITY - 1.0) * n1 + b1 * b1)
        self.add(2, (IN_ACCELERATION - 1.0) * n2 + b2 * b2)

    def pause(self, c: Channel, j: cython.Py_ssize_t, dt: cython.double,
              after: cython.longlong) -> None:
        """
        Add what is not known in a pause, and less and less after it.

        That is what filters of all bandwidths expect across it, their geometric mean: those that
        have weight say only what the motion was like before. `after`: the step after the instant.
        """
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        at: cython.Py_ssize_t
        slot: cython.Py_ssize_t = 0
        step: cython.double = c.r * TIME_UNIT
        if self.delayed:
            slot = after % self.steps.size
            step = 0.0
            if after <= self.steps.latest:
                step = (self.steps.times[slot, 0]
                        - self.steps.times[(after - 1) % self.steps.size, 0])
        faded: cython.double = exp(-dt / FADING)
        for i in range(3):
            c.tail[i, j] *= faded
            if step >= c.paused and step > 0.0:
                at = 3 * i + (1 if i > 0 else 0)
                total: cython.double = 0.0
                count: cython.double = 0.0
                for k in range(m):
                    v: cython.double = c.mean[j * m + k]
                    v *= self.steps.covariances[slot, at * m + k] if self.delayed else \
                        self.gains.ahead[at, k]
                    if v > 0.0:
                        total += log(v)
                        count += 1.0
                if count > 0.0:
                    total = AMPLE * exp(total / count)
                    c.tail[i, j] = total if total > c.tail[i, j] else c.tail[i, j]
            self.add(i, c.tail[i, j])

    def add(self, i: cython.Py_ssize_t, variance: cython.double) -> None:
        """Add to the variance of component i, 0 to 2; its correlations stay."""
        e: cython.double[:, ::1] = self.work
        own: cython.double = e[3 * i + (1 if i > 0 else 0), 0]
        grow(e, 0, i, own, own + variance)

    def carry(self, r: cython.double, j: cython.Py_ssize_t,
              out: cython.double[:, ::1]) -> None:
        """Write the covariance that was found, carried on by r."""
        e: cython.double[:, ::1] = self.work
        r2: cython.double = r * r
        r3: cython.double = r2 * r
        a00: cython.double = e[0, 0] + r * e[1, 0] + r2 * e[2, 0] + r3 * e[3, 0]
        a01: cython.double = e[1, 0] + r * e[4, 0] + r2 * e[5, 0] + r3 * e[6, 0]
        a02: cython.double = e[2, 0] + r * e[5, 0] + r2 * e[7, 0] + r3 * e[8, 0]
        a03: cython.double = e[3, 0] + r * e[6, 0] + r2 * e[8, 0] + r3 * e[9, 0]
        a11: cython.double = e[4, 0] + 2.0 * r * e[5, 0] + 3.0 * r2 * e[6, 0]
        a12: cython.double = e[5, 0] + 2.0 * r * e[7, 0] + 3.0 * r2 * e[8, 0]
        a13: cython.double = e[6, 0] + 2.0 * r * e[8, 0] + 3.0 * r2 * e[9, 0]
        a22: cython.double = e[7, 0] + 3.0 * r * e[8, 0]
        a23: cython.double = e[8, 0] + 3.0 * r * e[9, 0]
        t: cython.double[::1] = self.scale
        out[4, j] = a00 + r * a01 + r2 * a02 + r3 * a03
        out[5, j] = (a01 + 2.0 * r * a02 + 3.0 * r2 * a03) / t[1]
        out[6, j] = (a02 + 3.0 * r * a03) / t[2]
        out[7, j] = a03 / t[3]
        out[8, j] = (a11 + 2.0 * r * a12 + 3.0 * r2 * a13) / (t[1] * t[1])
        out[9, j] = (a12 + 3.0 * r * a13) / (t[1] * t[2])
        out[10, j] = a13 / (t[1] * t[3])
        out[11, j] = (a22 + 3.0 * r * a23) / (t[2] * t[2])
        out[12, j] = a23 / (t[2] * t[3])
        out[13, j] = e[9, 0] / (t[3] * t[3])

    def fuse(self, found: Mixture, c: Channel, j: cython.Py_ssize_t, dt: cython.double,
             w: cython.double, scale: cython.double, dv: cython.double, da: cython.double,
             doubt: cython.double, out: cython.double[:, ::1]) -> None:
        """
        Let velocities, whose mixture was looked at last, into a covariance by their weight w.

        They are too large by `scale`; their velocity and acceleration are `dv` and `da` from what
        positions tell. Where that is more than both can err by, it is the velocities that err.
        `doubt`: variance of what was made good of their lag and scale.
        """
        s: cython.double[:, ::1] = self.second
        a: cython.double[:, ::1] = self.apart
        self.tell(found, c, j, dt, s)
        if dt > 0.0:
            a[0, j] += c.lately * (dv * dv - a[0, j])
            a[1, j] += c.lately * (da * da - a[1, j])
        v1: cython.double = s[4, j] / (scale * scale) + doubt
        v2: cython.double = s[8, j] / (scale * scale)
        o1: cython.double = out[8, j]
        o2: cython.double = out[11, j]
        v1 = v1 if v1 > a[0, j] - o1 else a[0, j] - o1
        v2 = v2 if v2 > a[1, j] - o2 else a[1, j] - o2
        u: cython.double = (1.0 - w) * (1.0 - w)
        grow(out, j, 1, o1, u * o1 + w * w * v1)
        grow(out, j, 2, o2, u * o2 + w * w * v2)

    def clear(self, c: Channel, samples: cython.longlong, out: cython.double[:, ::1]) -> bool:
        """Whether accelerations are clear of error, as some samples tell it, or it is little."""
        j: cython.Py_ssize_t
        clear: cython.double = CLEAR * (1.0 + STUDENT / max(samples, 1))
        for j in range(self.n):
            little: cython.double = max(c.signal(j).step_of_encoder(), FINEST)
            little /= BRIEFLY * BRIEFLY
            little = max(little * little, self.told[j])
            if out[11, j] > little and clear * out[11, j] > signal(out, j):
                return False
        for j in range(self.n):
            if signal(out, j) > self.told[j] and clear * out[11, j] <= signal(out, j):
                self.told[j] = signal(out, j)
        return True


def signal(out: cython.double[:, ::1], j: cython.Py_ssize_t) -> cython.double:
    """Return the square of a joint's acceleration, and of what its velocity is worth."""
    slow: cython.double = out[1, j] / SLOWLY
    return out[2, j] * out[2, j] + slow * slow


def grow(t: cython.double[:, ::1], j: cython.Py_ssize_t, i: cython.Py_ssize_t,
         old: cython.double, new: cython.double) -> cython.void:
    """Change a variance of a matrix whose triangle ends column j of a table: row and column i."""
    a: cython.Py_ssize_t
    first: cython.Py_ssize_t = t.shape[0] - 10
    if not (old > 0.0 and new > 0.0):
        return
    by: cython.double = sqrt(new / old)
    for a in range(4):
        low: cython.Py_ssize_t = a if a < i else i
        high: cython.Py_ssize_t = i if a < i else a
        k: cython.Py_ssize_t = first + 3 * low - low * (low - 1) // 2 + high
        t[k, j] *= by * by if a == i else by
