# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: initializedcheck=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Steps of a bank: their pace, the latest ones, the fixed-lag smoother that reads them."""
from __future__ import annotations

from typing import Any

try:
    import cython
except ImportError:
    from . import uncompiled as cython
from .gains import Gains
from .tables import table, TIME_UNIT
if cython.compiled:
    from cython.cimports.libc.math import fabs
else:
    from math import fabs

LARGEST_RING = cython.declare(cython.Py_ssize_t, 4096)

PAUSE = cython.declare(cython.double, 3.5)
FELT = cython.declare(cython.double, 0.3)
"""Steps longer than so many usual ones are a pause, which filters feel for a while [s]."""


class Pace:
    """How far samples are apart, as a rule."""

    def __init__(self) -> None:
        self.start(0.0)

    def start(self, time: cython.double) -> None:
        """Begin a run."""
        self.period = self.usual = self.reference = self.pause = 0.0
        self.unusual, self.until = 0, time + FELT

    def follow(self, k: cython.longlong, time: cython.double,
               dt: cython.double) -> cython.double:
        """Take the k-th step; return the one that gains are found for: the usual if near it."""
        share: cython.double = 0.01 if k > 100 else 1.0 / k
        if k == 1:
            self.period = self.usual = dt
            self.pause = PAUSE * dt
            return dt
        if dt > self.pause:
            self.until = time + FELT
        limited: cython.double = 3.0 * self.period
        self.period += share * ((dt if dt < limited else limited) - self.period)
        if fabs(dt - self.usual) < 0.3 * self.usual:
            self.usual += share * (dt - self.usual)
            self.unusual = 0
        else:
            self.unusual += 1
            if self.unusual > 8:
                self.usual = dt
                self.unusual = 0
        self.pause = PAUSE * self.usual
        if k >= 16 and not 0.985 * self.usual < self.reference < 1.015 * self.usual:
            self.reference = self.usual
        near: cython.bint = 0.85 * self.reference < dt < 1.15 * self.reference
        return self.reference if near else dt

    def felt(self, time: cython.double) -> cython.bint:
        """Whether a pause, or the beginning of the run, may still be felt."""
        return time < self.until


class Steps:
    """
    Times, covariances and gains of the latest steps, in a ring.

    Step k of a run, from 1 on, is in row k % size. ``gains`` are those of the step at hand.
    """

    def __init__(self, gains: Gains) -> None:
        self.now, self.m = gains, gains.m
        self.size, self.work = 0, table(16, gains.m)
        self.times = self.ratios = self.covariances = self.gains = self.spreads = table(1, 1)
        self.taps = self.smoothed = table(1, 1)
        self.clear()

    def clear(self) -> None:
        """Forget all."""
        self.oldest, self.latest, self.tap_step = 1, 0, 0.0

    def make_room(self, size: int) -> None:
        """Make room for so many steps; those that are remembered stay."""
        m: cython.Py_ssize_t = self.m
        self.times = self.moved(self.times, size, 1)
        self.ratios = self.moved(self.ratios, size, 1)
        self.covariances = self.moved(self.covariances, size, 10 * m)
        self.gains = self.moved(self.gains, size, 4 * m)
        self.spreads = self.moved(self.spreads, size, m)
        self.taps, self.smoothed = table(4 * size, m), table(10 * size, m)
        self.size, self.tap_step = size, 0.0

    def moved(self, old: Any, size: int, columns: int) -> Any:
        """Return a ring of another size with the steps of one."""
        new = table(size, columns)
        for step in range(self.oldest, self.latest + 1):
            for k in range(columns):
                new[step % size, k] = old[step % self.size, k]
        return new

    def crowded(self, since: cython.double) -> cython.bint:
        """Whether the next step would take the place of one after an instant [s]."""
        step: cython.longlong = self.latest + 1
        return (step > self.size and self.size < LARGEST_RING
                and self.times[step % self.size, 0] > since)

    def remember(self, time: cython.double, step: cython.double) -> cython.Py_ssize_t:
        """Remember a step, as long as gains were found for; return where."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        self.latest += 1
        slot: cython.Py_ssize_t = self.latest % self.size
        if self.latest - self.oldest >= self.size:
            self.oldest += 1
        if self.latest > 1:
            self.ratios[(self.latest - 1) % self.size, 0] = step / TIME_UNIT
        self.times[slot, 0] = time
        for i in range(10):
            for k in range(m):
                self.covariances[slot, i * m + k] = self.now.ahead[i, k]
        for i in range(4):
            for k in range(m):
                self.gains[slot, i * m + k] = self.now.gain[i, k]
        for k in range(m):
            self.spreads[slot, k] = self.now.s[k]
        return slot

    def nearest(self, at: cython.double) -> cython.longlong:
        """Return the step nearest to an instant; 0: that is before all, -1: forgotten."""
        k: cython.longlong = self.latest
        while (k > self.oldest and self.times[k % self.size, 0]
               + self.times[(k - 1) % self.size, 0] > 2.0 * at):
            k -= 1
        if k > self.oldest or self.times[k % self.size, 0] <= at + 1e-9:
            return k
        return 0 if self.oldest == 1 else -1

    def make_taps(self, i: cython.longlong, used: cython.double,
                  steady: cython.longlong) -> None:
        """
        Find what the innovations since step i say of the predicted state there.

        For as many steps as are remembered, and once only, while the gains stay as they are.
        """
        if self.tap_step == used and steady > self.size:
            return
        self.tap_step = 0.0
        if steady > self.size:
            i = self.latest - self.size + 1
            self.tap_step = used
        k: cython.Py_ssize_t
        a: cython.Py_ssize_t
        b: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        slot: cython.Py_ssize_t = i % self.size
        since: cython.Py_ssize_t
        top: cython.Py_ssize_t = 0
        to: cython.Py_ssize_t
        c: cython.double[:, ::1] = self.work
        t: cython.double[:, ::1] = self.taps
        out: cython.double[:, ::1] = self.smoothed
        s: cython.double[:, ::1] = self.spreads
        g: cython.double[:, ::1] = self.gains
        for a in range(4):
            for b in range(4):
                to = 3 * a - a * (a - 1) // 2 + b if a <= b else 3 * b - b * (b - 1) // 2 + a
                for k in range(m):
                    c[4 * a + b, k] = self.covariances[slot, to * m + k]
                    out[to, k] = c[4 * a + b, k]
        for since in range(self.latest - i + 1):
            slot = (i + since) % self.size
            r: cython.double = self.ratios[slot, 0]
            r2: cython.double = r * r
            r3: cython.double = r2 * r
            for a in range(4):
                for k in range(m):
                    t[4 * since + a, k] = c[4 * a, k] / s[slot, k]
            to = 10 * since
            for a in range(4):
                for b in range(a, 4):
                    for k in range(m):
                        out[to, k] = out[top, k] - t[4 * since + a, k] * c[4 * b, k]
                    to += 1
                    top += 1
            top = 10 * since
            for a in range(4):
                b = 4 * a
                for k in range(m):
                    c0: cython.double = c[b, k]
                    x0: cython.double = c0 - c0 * g[slot, k]
                    x1: cython.double = c[b + 1, k] - c0 * g[slot, m + k]
                    x2: cython.double = c[b + 2, k] - c0 * g[slot, 2 * m + k]
                    x3: cython.double = c[b + 3, k] - c0 * g[slot, 3 * m + k]
                    c[b, k] = x0 + r * x1 + r2 * x2 + r3 * x3
                    c[b + 1, k] = x1 + 2.0 * r * x2 + 3.0 * r2 * x3
                    c[b + 2, k] = x2 + 3.0 * r * x3
                    c[b + 3, k] = x3
