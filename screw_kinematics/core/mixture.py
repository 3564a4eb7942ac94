# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: initializedcheck=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What the filters of a signal say together, weighed: means at an instant."""
from __future__ import annotations

try:
    import cython
except ImportError:
    from . import uncompiled as cython
from .channel import Channel
from .gains import Gains
from .steps import Steps
from .tables import table, TIME_UNIT, zeros
if cython.compiled:
    from cython.cimports.libc.math import fabs
else:
    from math import fabs


class Mixture:
    """
    Looks at one signal of a channel after the other.

    ``delayed`` is whether instants are before the latest step; ``what`` is the component of the
    state that is the acceleration: 2 of positions, 1 of velocities.
    """

    def __init__(self, channel: Channel, gains: Gains, steps: Steps, delayed: bool,
                 what: int) -> None:
        self.channel, self.gains, self.steps, self.m = channel, gains, steps, gains.m
        self.what, self.delayed, self.states = what, delayed, (
            table(4, gains.m) if delayed else channel.x)
        self.mean, self.p = zeros(4), gains.p
        self.r, self.first, self.top, self.variance, self.wider = 0.0, 0, 0, 0.0, 0.0

    def look(self, j: cython.Py_ssize_t, i: cython.longlong, at: cython.double,
             time: cython.double, whole: cython.bint) -> None:
        """
        Look at the states of a signal's filters at step i, to be carried on to an instant [s].

        With a delay these are smoothed: the predicted state, and the innovations since then by
        their taps; unless `whole` only of filters that have weight, of velocities the next wider
        ones, too. Without, i is the latest step, and `time` when that was.
        """
        k: cython.Py_ssize_t
        since: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        first: cython.Py_ssize_t = j * m
        if not self.delayed:
            self.r, self.first = (at - time) / TIME_UNIT, first
            return
        c: Channel = self.channel
        lanes: cython.Py_ssize_t = c.n * m
        slot: cython.Py_ssize_t = i % self.steps.size
        b: cython.double[:, ::1] = self.states
        taps: cython.double[:, ::1] = self.steps.taps
        errors: cython.double[:, ::1] = c.errors
        narrower: cython.double = 0.0
        for k in range(m):
            w: cython.double = c.weight[first + k]
            passed: cython.bint = w == 0.0 and (self.what == 2 or narrower == 0.0)
            narrower = w
            if passed and not whole:
                continue
            # Sums of their own, and no remainder for each step: a third of the time.
            x0: cython.double = c.states[slot, first + k]
            x1: cython.double = c.states[slot, lanes + first + k]
            x2: cython.double = c.states[slot, 2 * lanes + first + k]
            x3: cython.double = c.states[slot, 3 * lanes + first + k]
            row: cython.Py_ssize_t = slot
            for since in range(self.steps.latest - i + 1):
                e: cython.double = errors[row, first + k]
                x0 += taps[4 * since, k] * e
                x1 += taps[4 * since + 1, k] * e
                x2 += taps[4 * since + 2, k] * e
                x3 += taps[4 * since + 3, k] * e
                row = row + 1 if row + 1 < self.steps.size else 0
            b[0, k], b[1, k], b[2, k], b[3, k] = x0, x1, x2, x3
        self.r = (at - self.steps.times[slot, 0]) / TIME_UNIT
        self.top = 10 * (self.steps.latest - i)

    def mix(self, j: cython.Py_ssize_t, period: cython.double) -> None:
        """
        Mix a signal's filters.

        Finds the mean state, and what variance of the acceleration the filters claim; of
        velocities, with a delay, how far the next wider filter of each is from it. Densities of
        the processes are of a period.
        """
        k: cython.Py_ssize_t
        c: Channel = self.channel
        first: cython.Py_ssize_t = j * self.m
        s: cython.Py_ssize_t
        r: cython.double = self.r
        r2: cython.double = r * r
        r3: cython.double = r2 * r
        h: cython.double = fabs(r) * TIME_UNIT
        h3: cython.double = h * h * h
        top: cython.Py_ssize_t = self.top
        m0: cython.double = 0.0
        m1: cython.double = 0.0
        m2: cython.double = 0.0
        m3: cython.double = 0.0
        total: cython.double = 0.0
        square: cython.double = 0.0
        inner: cython.double = 0.0
        wider: cython.double = 0.0
        v: cython.double
        for k in range(c.low[j], c.high[j]):
            w: cython.double = c.weight[first + k]
            s = self.first + k
            total += w
            x1: cython.double = self.states[1, s]
            x2: cython.double = self.states[2, s]
            b3: cython.double = self.states[3, s]
            b2: cython.double = x2 + 3.0 * r * b3
            b1: cython.double = x1 + 2.0 * r * x2 + 3.0 * r2 * b3
            b0: cython.double = self.states[0, s] + r * x1 + r2 * x2 + r3 * b3
            m0 += w * b0
            m1 += w * b1
            m2 += w * b2
            m3 += w * b3
            if self.what == 2:
                square += w * b2 * b2
                v = (self.p[top + 7, k] + 6.0 * r * self.p[top + 8, k]
                     + 9.0 * r2 * self.p[top + 9, k])
            else:
                square += w * b1 * b1
                if self.delayed and k + 1 < self.m:
                    wider += w * (self.states[1, s + 1] - x1)
                v = (self.p[top + 4, k] + 4.0 * r2 * self.p[top + 7, k]
                     + 9.0 * r2 * r2 * self.p[top + 9, k] + 4.0 * r * self.p[top + 5, k]
                     + 6.0 * r2 * self.p[top + 6, k] + 12.0 * r3 * self.p[top + 8, k])
                if h > 1e-3:        # what the process adds on the way
                    density: cython.double = self.gains.power[k] * period
                    if self.gains.four[k] > 0.5:
                        v += density * self.gains.noise[1, 4] * h3 * h * h
                    else:
                        v += density * self.gains.noise[0, 4] * h3
            inner += w * c.mean[first + k] * v
        total = 1.0 / total
        self.wider = wider * total
        m1 *= total
        m2 *= total
        self.mean[0], self.mean[1], self.mean[2], self.mean[3] = m0 * total, m1, m2, m3 * total
        square = square * total - (m2 * m2 if self.what == 2 else m1 * m1)
        self.variance = (square if square > 0.0 else 0.0) + inner * total
