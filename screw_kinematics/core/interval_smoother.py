# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: initializedcheck=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Fixed-interval smoothing by integrated-Wiener filters, weighed by leaving each sample out.

How well a filter predicts says little of how well it smooths: of a motion that is slower than its
bandwidth by a factor it misses the 4th power of that ahead, and the 8th with both sides in view.
As in the bank, the unit of covariances is the unknown variance of the noise, so that they depend
on the times alone: they are found once (`plan`), and serve all signals (`smooth`).

References
----------
G. J. Bierman, "Fixed interval smoothing with discrete measurements", Int. J. Control 18 (1973)
65-75. P. De Jong, "A cross-validation filter for time series models", Biometrika 75 (1988)
594-600.

"""

from __future__ import annotations

from collections.abc import Sequence

try:
    import cython
except ImportError:
    from . import uncompiled as cython
from .gains import Gains
from .tables import DENSEST, LEAST, row, SCALE, SPARSE, table, TIME_UNIT, zeros
if cython.compiled:
    from cython.cimports.libc.math import exp, log, sqrt
else:
    from math import exp, log, sqrt

AROUND = cython.declare(cython.double, 0.2)
"""How far to either side filters are weighed by what they tell, s: that fades by e over it."""

COLOURED = cython.declare(cython.double, 0.35)
"""Fall of the logarithm of the noise from a filter to the next from which on it is coloured."""

SLOWEST = cython.declare(cython.double, 1.2)
"""Most that each such step counts: less than motion falls where velocities jump, which is 1.5."""

FAST = cython.declare(cython.double, 3.0)
"""Fall that no noise has: the handicap goes to nothing on the way of 1 to it."""

WORTH = cython.declare(cython.double, 0.4)
"""What a score is worth as evidence: neighbours' errors are alike, and none of the bandwidths may
be the right one, so that a mean of two is."""

PRIOR = (100.0, 2e7, 1.5e8, 3e9)
"""Deviations of the state before the first sample, in units of the noise, per s ..."""

CARRIED = 2e5
"""Most that one may grow to from a sample to the next; more cancels to nothing."""


class IntervalSmoother:
    """
    Smooth signals that were sampled at the same times.

    ``bandwidths`` are of the filters, all of order 4 [Hz]. Wide filters have a handicap: what the
    logarithm of the innovation's variance counts beside (``wide``), and where noise is coloured
    its square (``steep``), that by how dense samples are.
    """

    def __init__(self, bandwidths: Sequence, wide: float, steep: float) -> None:
        self.gains = Gains([(4, f) for f in bandwidths])
        self.m, self.wide, self.steep, self.n = self.gains.m, wide, steep, 0
        self.longest = self.signals = 0
        self.scale, self.weight, self.work = row(SCALE), zeros(self.m), table(10, self.m)
        self.level, self.step = zeros(self.m), zeros(self.m)

    def plan(self, times: cython.double[::1]) -> None:
        """Find covariances and gains for these times, which increase."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        n: cython.Py_ssize_t = times.shape[0]
        m: cython.Py_ssize_t = self.m
        self.n = n
        self.times = row([times[i] for i in range(n)])
        if n > self.longest:
            self.p, self.gain, self.s = table(n, 10 * m), table(n, 4 * m), table(n, m)
            self.alone, self.spread, self.logs = table(n, m), table(n, 4 * m), table(n, m)
            self.span, self.keep = table(n, 1), zeros(n)
            self.longest, self.signals = n, 0
        period: cython.double = (times[n - 1] - times[0]) / (n - 1)
        dense: cython.double = SPARSE / period
        dense = dense if dense < DENSEST else DENSEST
        steep: cython.double = self.steep * dense
        far: cython.double = 1.0
        for i in range(1, n):
            far = max(far, (times[i] - times[i - 1]) / TIME_UNIT)
        self.gains.start(row([min(deviation * SCALE[a], CARRIED / far ** a) ** 2
                              for a, deviation in enumerate(PRIOR)]))
        for i in range(n):
            if i:
                self.keep[i] = exp(-(times[i] - times[i - 1]) / AROUND)
                self.gains.predict(times[i] - times[i - 1], period)
            self.gains.update()
            self.remember(i)
            self.span[i, 0] = 1.0
        self.backward()
        handicap: cython.double = 0.0
        for k in range(m):
            settled: cython.double = 0.0
            for i in range(n):
                own: cython.double = log(self.s[i, k])
                self.logs[i, k] = own * self.wide - log(self.alone[i, k])
                settled += own if 2 * i + 1 >= n else 0.0
            settled /= n - n // 2
            square: cython.double = steep * settled * settled
            self.step[k] = min(square - handicap, SLOWEST)
            handicap = square
        self.around(self.logs)
        self.around(self.span)

    def remember(self, i: cython.Py_ssize_t) -> None:
        """Remember gains, and the covariances that they are of."""
        k: cython.Py_ssize_t
        a: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        for k in range(m):
            for a in range(10):
                self.p[i, a * m + k] = self.gains.ahead[a, k]
            for a in range(4):
                self.gain[i, a * m + k] = self.gains.gain[a, k]
            self.s[i, k] = self.gains.s[k]

    def around(self, of: cython.double[:, ::1]) -> None:
        """Replace rows by their sums over time, fading to either side."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        m: cython.Py_ssize_t = of.shape[1]
        w: cython.double[:, ::1] = self.work
        before: cython.double[:, ::1] = table(self.n, m)
        for k in range(m):
            w[0, k] = 0.0
        for i in range(self.n):
            for k in range(m):
                w[0, k] *= self.keep[i]
                before[i, k] = w[0, k]
                w[0, k] += of[i, k]
        for k in range(m):
            w[0, k] = 0.0
        for i in range(self.n - 1, -1, -1):
            for k in range(m):
                own: cython.double = of[i, k]
                of[i, k] += before[i, k] + w[0, k]
                w[0, k] = self.keep[i] * (w[0, k] + own)

    def backward(self) -> None:
        """Find smoothed variances, and what the other samples know about each."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        f: cython.double[:, ::1] = self.work        # information, upper triangle
        p: cython.double[:, ::1] = self.p
        for k in range(m):
            for i in range(10):
                f[i, k] = 0.0
        for i in range(self.n - 1, -1, -1):
            r: cython.double = 0.0
            if i + 1 < self.n:
                r = (self.times[i + 1] - self.times[i]) / TIME_UNIT
            r2: cython.double = r * r
            r3: cython.double = r2 * r
            for k in range(m):
                # F' f F, from f a step later
                a01: cython.double = r * f[0, k] + f[1, k]
                a02: cython.double = r2 * f[0, k] + 2.0 * r * f[1, k] + f[2, k]
                a03: cython.double = (r3 * f[0, k] + 3.0 * r2 * f[1, k] + 3.0 * r * f[2, k]
                                      + f[3, k])
                a11: cython.double = r * f[1, k] + f[4, k]
                a12: cython.double = r2 * f[1, k] + 2.0 * r * f[4, k] + f[5, k]
                a13: cython.double = (r3 * f[1, k] + 3.0 * r2 * f[4, k] + 3.0 * r * f[5, k]
                                      + f[6, k])
                a22: cython.double = r2 * f[2, k] + 2.0 * r * f[5, k] + f[7, k]
                a23: cython.double = (r3 * f[2, k] + 3.0 * r2 * f[5, k] + 3.0 * r * f[7, k]
                                      + f[8, k])
                a33: cython.double = (r3 * f[3, k] + 3.0 * r2 * f[6, k] + 3.0 * r * f[8, k]
                                      + f[9, k])
                f00: cython.double = f[0, k]
                f11: cython.double = r * a01 + a11
                f12: cython.double = r * a02 + a12
                f13: cython.double = r * a03 + a13
                f22: cython.double = r2 * a02 + 2.0 * r * a12 + a22
                f23: cython.double = r2 * a03 + 2.0 * r * a13 + a23
                f33: cython.double = r3 * a03 + 3.0 * r2 * a13 + 3.0 * r * a23 + a33
                # with this sample: (I - K H)' f (I - K H) + H' H / s
                g0: cython.double = self.gain[i, k]
                g1: cython.double = self.gain[i, m + k]
                g2: cython.double = self.gain[i, 2 * m + k]
                g3: cython.double = self.gain[i, 3 * m + k]
                b0: cython.double = g0 * f00 + g1 * a01 + g2 * a02 + g3 * a03
                b1: cython.double = g0 * a01 + g1 * f11 + g2 * f12 + g3 * f13
                b2: cython.double = g0 * a02 + g1 * f12 + g2 * f22 + g3 * f23
                b3: cython.double = g0 * a03 + g1 * f13 + g2 * f23 + g3 * f33
                both: cython.double = g0 * b0 + g1 * b1 + g2 * b2 + g3 * b3
                # After a long pause rounding is all that is left of `both`.
                self.alone[i, k] = 1.0 / self.s[i, k] + (both if both > 0.0 else 0.0)
                f[0, k] = f00 - 2.0 * b0 + both + 1.0 / self.s[i, k]
                f[1, k] = a01 - b1
                f[2, k] = a02 - b2
                f[3, k] = a03 - b3
                f[4, k], f[5, k], f[6, k] = f11, f12, f13
                f[7, k], f[8, k], f[9, k] = f22, f23, f33
                self.spread_of(i, k, p, f)

    def spread_of(self, i: cython.Py_ssize_t, k: cython.Py_ssize_t, p: cython.double[:, ::1],
                  f: cython.double[:, ::1]) -> None:
        """Write the smoothed variances P - P f P of a filter."""
        a: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        for a in range(4):
            # Row a of the symmetric matrix.
            c0: cython.double = p[i, a * m + k]
            c1: cython.double = p[i, (1 if a == 0 else 3 + a) * m + k]
            c2: cython.double = p[i, (2 if a == 0 else 5 if a == 1 else 5 + a) * m + k]
            c3: cython.double = p[i, (3 if a == 0 else 6 if a == 1 else 8 if a == 2 else 9)
                                  * m + k]
            own: cython.double = c0 if a == 0 else c1 if a == 1 else c2 if a == 2 else c3
            square: cython.double = (
                c0 * c0 * f[0, k] + c1 * c1 * f[4, k] + c2 * c2 * f[7, k] + c3 * c3 * f[9, k]
                + 2.0 * (c0 * (c1 * f[1, k] + c2 * f[2, k] + c3 * f[3, k])
                         + c1 * (c2 * f[5, k] + c3 * f[6, k]) + c2 * c3 * f[8, k]))
            left: cython.double = own - square
            self.spread[i, a * m + k] = left if left > 1e-12 * own else 1e-12 * own

    def smooth(self, values: cython.double[:, ::1], floors: cython.double[::1],
               state: cython.double[:, ::1], variance: cython.double[:, ::1],
               rest: cython.double[:, ::1]) -> None:
        """
        Smooth J signals; ``values`` are their samples, shape (J, N), finite.

        ``floors`` are the least variances of their noise. Rows 4 j to 4 j + 3 of ``state`` and
        ``variance``, shape (4 J, N), get the smoothed signal j and its derivatives, per s ..., and
        their variances; rows 2 j and 2 j + 1 of ``rest``, shape (2 J, N), what each sample differs
        from what all the others say, and the deviation of that.

        Covariances and gains are more than the processor's caches hold: all signals take them
        where they are read.
        """
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        signals: cython.Py_ssize_t = values.shape[0]
        if signals > self.signals:
            self.x = table(self.longest, 4 * self.m * signals)
            self.error, self.mean = (table(self.longest, self.m * signals) for _ in range(2))
            self.carried, self.signals = table(5 * signals, self.m), signals
        self.begin()
        for i in range(self.n):
            for j in range(signals):
                self.follow(i, j, values[j, i] - values[j, 0])
        self.begin()
        for i in range(self.n - 1, -1, -1):
            for j in range(signals):
                self.look_back(i, j)
        self.begin()
        for i in range(self.n):
            for j in range(signals):
                self.mix(i, j, floors[j], state, variance, rest)
                state[4 * j, i] += values[j, 0]

    def begin(self) -> None:
        """Begin a pass over the samples, in which nothing is known yet."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        for i in range(5 * self.signals):
            for k in range(self.m):
                self.carried[i, k] = 0.0

    def follow(self, i: cython.Py_ssize_t, j: cython.Py_ssize_t, z: cython.double) -> None:
        """Predict sample i of signal j, z from its first; see how far off that is."""
        k: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        x: cython.double[:, ::1] = self.x
        g: cython.double[:, ::1] = self.gain
        w: cython.double[:, ::1] = self.carried
        f: cython.Py_ssize_t = 5 * j
        at: cython.Py_ssize_t = 4 * j * m
        r: cython.double = (self.times[i] - self.times[i - 1]) / TIME_UNIT if i else 0.0
        r2: cython.double = r * r
        r3: cython.double = r2 * r
        for k in range(m):
            x3: cython.double = w[f + 3, k]
            x2: cython.double = w[f + 2, k] + 3.0 * r * x3
            x1: cython.double = w[f + 1, k] + 2.0 * r * w[f + 2, k] + 3.0 * r2 * x3
            x0: cython.double = w[f, k] + r * w[f + 1, k] + r2 * w[f + 2, k] + r3 * x3
            e: cython.double = z - x0
            x[i, at + k], x[i, at + m + k] = x0, x1
            x[i, at + 2 * m + k], x[i, at + 3 * m + k] = x2, x3
            self.error[i, j * m + k] = e
            w[f, k] = x0 + g[i, k] * e
            w[f + 1, k] = x1 + g[i, m + k] * e
            w[f + 2, k] = x2 + g[i, 2 * m + k] * e
            w[f + 3, k] = x3 + g[i, 3 * m + k] * e

    def look_back(self, i: cython.Py_ssize_t, j: cython.Py_ssize_t) -> None:
        """Let the samples from i on tell the state there, and how well others tell this one."""
        k: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        x: cython.double[:, ::1] = self.x
        p: cython.double[:, ::1] = self.p
        g: cython.double[:, ::1] = self.gain
        w: cython.double[:, ::1] = self.carried     # the adjoint, and squares of later errors
        error: cython.double[:, ::1] = self.error
        f: cython.Py_ssize_t = 5 * j
        at: cython.Py_ssize_t = 4 * j * m
        own: cython.Py_ssize_t = j * m
        keep: cython.double = self.keep[i]
        r: cython.double = 0.0
        if i + 1 < self.n:
            r = (self.times[i + 1] - self.times[i]) / TIME_UNIT
        r2: cython.double = r * r
        r3: cython.double = r2 * r
        for k in range(m):
            # F' of the adjoint a step later, and what this sample says.
            l0: cython.double = w[f, k]
            l1: cython.double = r * w[f, k] + w[f + 1, k]
            l2: cython.double = r2 * w[f, k] + 2.0 * r * w[f + 1, k] + w[f + 2, k]
            l3: cython.double = (r3 * w[f, k] + 3.0 * r2 * w[f + 1, k] + 3.0 * r * w[f + 2, k]
                                 + w[f + 3, k])
            says: cython.double = error[i, own + k] / self.s[i, k] - (
                g[i, k] * l0 + g[i, m + k] * l1 + g[i, 2 * m + k] * l2 + g[i, 3 * m + k] * l3)
            e: cython.double = says / self.alone[i, k]
            error[i, own + k] = e
            square: cython.double = w[f + 4, k] + says * e
            self.mean[i, own + k] = square
            w[f + 4, k] = keep * square
            l0 += says
            w[f, k], w[f + 1, k], w[f + 2, k], w[f + 3, k] = l0, l1, l2, l3
            x[i, at + k] += (p[i, k] * l0 + p[i, m + k] * l1 + p[i, 2 * m + k] * l2
                             + p[i, 3 * m + k] * l3)
            x[i, at + m + k] += (p[i, m + k] * l0 + p[i, 4 * m + k] * l1 + p[i, 5 * m + k] * l2
                                 + p[i, 6 * m + k] * l3)
            x[i, at + 2 * m + k] += (p[i, 2 * m + k] * l0 + p[i, 5 * m + k] * l1
                                     + p[i, 7 * m + k] * l2 + p[i, 8 * m + k] * l3)
            x[i, at + 3 * m + k] += (p[i, 3 * m + k] * l0 + p[i, 6 * m + k] * l1
                                     + p[i, 8 * m + k] * l2 + p[i, 9 * m + k] * l3)

    def mix(self, i: cython.Py_ssize_t, j: cython.Py_ssize_t, floor: cython.double,
            state: cython.double[:, ::1], variance: cython.double[:, ::1],
            rest: cython.double[:, ::1]) -> None:
        """
        Weigh the filters by how well they tell each sample around one from all others.

        From white noise all filters that follow the motion find the same noise in their misses.
        If that goes on to fall from a filter to wider ones, it is coloured, and the filter is
        told to do better the wider it is; but motion falls faster.
        """
        k: cython.Py_ssize_t
        a: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        w: cython.double[::1] = self.weight
        level: cython.double[::1] = self.level
        noise: cython.double[:, ::1] = self.mean
        error: cython.double[:, ::1] = self.error
        before: cython.double[:, ::1] = self.carried
        own: cython.Py_ssize_t = j * m
        f: cython.Py_ssize_t = 5 * j
        best: cython.double = 1e300
        total: cython.double = 0.0
        span: cython.double = self.span[i, 0]
        keep: cython.double = self.keep[i]
        for k in range(m):
            before[f, k] *= keep
            square: cython.double = (noise[i, own + k] + before[f, k]) / span
            before[f, k] += error[i, own + k] * error[i, own + k] * self.alone[i, k]
            noise[i, own + k] = square if square > floor else floor
            level[k] = log(noise[i, own + k] + LEAST)
        handicap: cython.double = 0.0
        for k in range(m):
            onward: cython.double = level[k] - level[k + 1] if k + 1 < m else COLOURED
            if onward > 0.0:
                handicap += self.step[k] * min(onward / COLOURED, 1.0, max(FAST - onward, 0.0))
            w[k] = level[k] + handicap + self.logs[i, k] / span
            best = w[k] if w[k] < best else best
        for k in range(m):
            w[k] = exp(-0.5 * WORTH * span * (w[k] - best))
            total += w[k]
        off: cython.double = 0.0
        expected: cython.double = 0.0
        for k in range(m):
            w[k] /= total
            off += w[k] * error[i, own + k]
            expected += w[k] * (noise[i, own + k] / self.alone[i, k])
        rest[2 * j, i], rest[2 * j + 1, i] = off, sqrt(expected + LEAST)
        for a in range(4):
            at: cython.Py_ssize_t = (4 * j + a) * m
            mean: cython.double = 0.0
            square = 0.0
            for k in range(m):
                mean += w[k] * self.x[i, at + k]
            for k in range(m):
                apart: cython.double = self.x[i, at + k] - mean
                square += w[k] * (apart * apart + noise[i, own + k] * self.spread[i, a * m + k])
            state[4 * j + a, i] = mean / self.scale[a]
            variance[4 * j + a, i] = square / (self.scale[a] * self.scale[a])
