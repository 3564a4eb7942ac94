# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: initializedcheck=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Covariances and gains of integrated-Wiener Kalman filters of many bandwidths.

Covariances are in units of the unknown variance of the noise, so that they depend on the times
alone and are shared by all signals that are sampled together. One column for each filter, so that
inner loops run through memory in order; symmetric matrices are their upper triangles, 10 rows.
"""
from __future__ import annotations

from collections.abc import Sequence

try:
    import cython
except ImportError:
    from . import uncompiled as cython
from .tables import LEAST, row, SCALE, table, TIME_UNIT, TRIANGLE, zeros
if cython.compiled:
    from cython.cimports.libc.math import fabs, log
else:
    from math import fabs, log

STEADY = cython.declare(cython.double, 1e-7)
SAME = cython.declare(cython.double, 1e-12)
"""Relative changes below which gains are steady; and stay, if their period does."""

DRIFT = cython.declare(cython.double, 0.01)
"""Share by which the period may be another one than that which process densities are of."""

FACTORIAL = (1.0, 1.0, 2.0, 6.0)


class Gains:
    """
    The filters' gains, one sample after the other.

    ``bandwidths`` are, of each filter, the order of its model and its bandwidth [Hz].
    """

    def __init__(self, bandwidths: Sequence) -> None:
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        k: cython.Py_ssize_t
        order: cython.Py_ssize_t
        m = self.m = len(bandwidths)
        self.power = row([(2 * 3.141592653589793 * f) ** (2 * order) for order, f in bandwidths])
        self.four = row([1.0 if order == 4 else 0.0 for order, _ in bandwidths])
        self.noise = table(2, 10)
        for order in (3, 4):
            for k, (i, j) in enumerate(TRIANGLE):
                if j < order:
                    self.noise[order - 3, k] = SCALE[i] * SCALE[j] / (
                        (2 * order - 1 - i - j) * FACTORIAL[order - 1 - i]
                        * FACTORIAL[order - 1 - j])
        self.p, self.ahead = table(10, m), table(10, m)
        self.gain, self.before = table(4, m), table(4, m)
        self.s, self.precision, self.logs = zeros(m), zeros(m), zeros(m)
        self.step = self.period = self.change = 0.0

    def start(self, variances: cython.double[::1]) -> None:
        """Begin with these variances of the state's components, scaled."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        self.step = self.period = 0.0
        for k in range(self.m):
            for i in range(10):
                self.p[i, k] = 0.0
            self.p[0, k], self.p[4, k] = variances[0], variances[1]
            self.p[7, k], self.p[9, k] = variances[2], variances[3] * self.four[k]
            for i in range(4):
                self.gain[i, k] = 0.0
            self.s[k] = self.precision[k] = 1.0

    def follow(self, dt: cython.double, period: cython.double) -> cython.bint:
        """Take a step and a sample, if that changes gains; return whether they are steady."""
        k: cython.Py_ssize_t
        again: cython.bint = dt == self.step
        other: cython.bint = fabs(period - self.period) > DRIFT * period
        if other:
            self.period = period
        if other or not again or self.change > SAME:
            self.predict(dt, self.period)
            self.change = self.update()
            self.step = dt
            for k in range(self.m):
                self.logs[k] = log(self.s[k])
        return again and self.change < STEADY

    def predict(self, dt: cython.double, period: cython.double) -> None:
        """Predict the covariances a step later, F P F' + Q; process densities are of a period."""
        k: cython.Py_ssize_t
        r: cython.double = dt / TIME_UNIT
        r2: cython.double = r * r
        r3: cython.double = r2 * r
        d1: cython.double = dt
        d2: cython.double = d1 * d1
        d3: cython.double = d2 * d1
        d4: cython.double = d2 * d2
        d5: cython.double = d4 * d1
        d6: cython.double = d3 * d3
        d7: cython.double = d6 * d1
        # Beyond these densities a filter is dead-beat.
        cap3: cython.double = 2e9 / d5
        cap4: cython.double = 2.5e10 / d7
        p: cython.double[:, ::1] = self.p
        c: cython.double[:, ::1] = self.noise
        for k in range(self.m):
            a00: cython.double = p[0, k] + r * p[1, k] + r2 * p[2, k] + r3 * p[3, k]
            a01: cython.double = p[1, k] + r * p[4, k] + r2 * p[5, k] + r3 * p[6, k]
            a02: cython.double = p[2, k] + r * p[5, k] + r2 * p[7, k] + r3 * p[8, k]
            a03: cython.double = p[3, k] + r * p[6, k] + r2 * p[8, k] + r3 * p[9, k]
            a11: cython.double = p[4, k] + 2.0 * r * p[5, k] + 3.0 * r2 * p[6, k]
            a12: cython.double = p[5, k] + 2.0 * r * p[7, k] + 3.0 * r2 * p[8, k]
            a13: cython.double = p[6, k] + 2.0 * r * p[8, k] + 3.0 * r2 * p[9, k]
            a22: cython.double = p[7, k] + 3.0 * r * p[8, k]
            a23: cython.double = p[8, k] + 3.0 * r * p[9, k]
            is4: cython.double = self.four[k]
            density: cython.double = self.power[k] * period
            cap: cython.double = cap4 if is4 > 0.5 else cap3
            density = density if density < cap else cap
            f: cython.double = density * is4
            t: cython.double = density - f
            p[0, k] = (a00 + r * a01 + r2 * a02 + r3 * a03
                       + f * c[1, 0] * d7 + t * c[0, 0] * d5)
            p[1, k] = a01 + 2.0 * r * a02 + 3.0 * r2 * a03 + f * c[1, 1] * d6 + t * c[0, 1] * d4
            p[2, k] = a02 + 3.0 * r * a03 + f * c[1, 2] * d5 + t * c[0, 2] * d3
            p[3, k] = a03 + f * c[1, 3] * d4
            p[4, k] = a11 + 2.0 * r * a12 + 3.0 * r2 * a13 + f * c[1, 4] * d5 + t * c[0, 4] * d3
            p[5, k] = a12 + 3.0 * r * a13 + f * c[1, 5] * d4 + t * c[0, 5] * d2
            p[6, k] = a13 + f * c[1, 6] * d3
            p[7, k] = a22 + 3.0 * r * a23 + f * c[1, 7] * d3 + t * c[0, 7] * d1
            p[8, k] = a23 + f * c[1, 8] * d2
            p[9, k] = p[9, k] + f * c[1, 9] * d1

    def update(self) -> cython.double:
        """Update covariances and gains with one sample; return the gains' relative change."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        p: cython.double[:, ::1] = self.p
        g: cython.double[:, ::1] = self.gain
        change: cython.double = 0.0
        for i in range(10):
            for k in range(self.m):
                self.ahead[i, k] = p[i, k]
        for k in range(self.m):
            s: cython.double = p[0, k] + 1.0
            g0: cython.double = p[0, k] / s
            g1: cython.double = p[1, k] / s
            g2: cython.double = p[2, k] / s
            g3: cython.double = p[3, k] / s
            p[4, k] -= g1 * p[1, k]
            p[5, k] -= g1 * p[2, k]
            p[6, k] -= g1 * p[3, k]
            p[7, k] -= g2 * p[2, k]
            p[8, k] -= g2 * p[3, k]
            p[9, k] -= g3 * p[3, k]
            # Exact for a noise of variance 1, and better conditioned.
            p[0, k], p[1, k], p[2, k], p[3, k] = g0, g1, g2, g3
            off: cython.double = fabs(g[0, k] - g0) - change * g0
            if off > 0.0:
                change = fabs(g[0, k] - g0) / g0
            off = fabs(g[2, k] - g2) - change * fabs(g2)
            if off > 0.0:
                change = fabs(g[2, k] - g2) / (fabs(g2) + LEAST)
            for i in range(4):
                self.before[i, k] = g[i, k]
            g[0, k], g[1, k], g[2, k], g[3, k] = g0, g1, g2, g3
            self.s[k], self.precision[k] = s, 1.0 / s
        return change
