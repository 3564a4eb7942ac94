# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: initializedcheck=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The latest readings of a device.

A *reading* is a position that was read at a tick of the device; its *deviation* is how much later
than the tick its stamp is, in the device's time.
"""
from __future__ import annotations

from collections.abc import Sequence

try:
    import cython
except ImportError:
    from . import uncompiled as cython
from .tables import table, zeros
if cython.compiled:
    from cython.cimports.libc.math import fabs
else:
    from math import fabs


ALIKE = 0.02
"""Times that differ by no more than this share of how far they have to be apart are the same."""


class Readings:
    """
    The latest readings of n joints, each at another tick than the one before.

    ``size`` is how many are kept.
    """

    def __init__(self, n: int, size: int) -> None:
        self.n, self.size, self.start, self.count = n, size, 0, 0
        # Twice the room, so that seldom all of them are moved.
        self.tick, self.deviation, self.stamp = zeros(2 * size), zeros(2 * size), zeros(2 * size)
        self.time, self.q, self.latest = zeros(2 * size), table(2 * size, n), zeros(n)
        self.base, self.product = zeros(size), zeros(size)

    def clear(self) -> None:
        """Forget all."""
        self.start = self.count = 0

    def number(self) -> cython.Py_ssize_t:
        """Return how many there are."""
        return self.count

    def add(self, tick: cython.double, deviation: cython.double, stamp: cython.double,
            time: cython.double, position: Sequence[float]) -> None:
        """Add a reading; the oldest one is forgotten where there is no room."""
        if self.count == self.size:
            self.drop(1)
        if self.start >= self.size:
            self.move_to_front()
        j: cython.Py_ssize_t
        i: cython.Py_ssize_t = self.start + self.count
        fill(self.latest, position)
        self.tick[i], self.deviation[i], self.stamp[i], self.time[i] = (
            tick, deviation, stamp, time)
        for j in range(self.n):
            self.q[i, j] = self.latest[j]
        self.count += 1

    def drop(self, first: cython.Py_ssize_t) -> None:
        """Forget the oldest ones."""
        self.start += first
        self.count -= first

    def move_to_front(self) -> None:
        """Let the oldest one be in the first row."""
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        first: cython.Py_ssize_t = self.start
        for i in range(self.count):
            self.tick[i], self.deviation[i] = self.tick[i + first], self.deviation[i + first]
            self.stamp[i], self.time[i] = self.stamp[i + first], self.time[i + first]
            for j in range(self.n):
                self.q[i, j] = self.q[i + first, j]
        self.start = 0

    def at(self, i: cython.Py_ssize_t) -> tuple[float, float, float, float]:
        """Return tick, deviation, stamp and time of reading i; -1: the latest."""
        k: cython.Py_ssize_t = self.start + (self.count + i if i < 0 else i)
        return self.tick[k], self.deviation[k], self.stamp[k], self.time[k]

    def position(self, i: cython.Py_ssize_t) -> tuple[float, ...]:
        """Return the positions of reading i."""
        return tuple([self.q[self.start + i, j] for j in range(self.n)])

    def place(self, i: cython.Py_ssize_t, tick: cython.double, deviation: cython.double,
              time: cython.double) -> None:
        """Put reading i at another tick."""
        i += self.start
        self.tick[i], self.deviation[i], self.time[i] = tick, deviation, time

    def by_ticks(self, time: float, unit: float,
                 scale: float) -> list[tuple[float, tuple[float, ...]]] | None:
        """Return all, by ticks of a unit and a share of deviations from the latest at a time."""
        tick, deviation, *_ = self.at(-1)
        times = [time + (self.at(i)[0] - tick) * unit + (self.at(i)[1] - deviation) * scale
                 for i in range(self.count)]
        return self.at_times(times, 0.05 * unit)

    def by_stamps(self, time: float) -> list[tuple[float, tuple[float, ...]]] | None:
        """Return all, as far from the latest at a time as their stamps are."""
        stamp = self.at(-1)[2]
        return self.at_times([time + self.at(i)[2] - stamp for i in range(self.count)], 1e-5)

    def at_times(self, times: list[float],
                 apart: float) -> list[tuple[float, tuple[float, ...]]] | None:
        """Let all have other times, and return them; None if these are not other or too close."""
        if not all(b - a > apart for a, b in zip(times, times[1:])) or all(
                abs(time - self.at(i)[3]) < ALIKE * apart for i, time in enumerate(times)):
            return None
        for i, time in enumerate(times):
            self.time[self.start + i] = time
        return [(time, self.position(i)) for i, time in enumerate(times)]

    def rescale(self, origin: cython.double, factor: cython.double) -> None:
        """Count ticks from another origin, and by another length."""
        i: cython.Py_ssize_t
        for i in range(self.start, self.start + self.count):
            self.tick[i] = (self.tick[i] - origin) / factor

    def divisor(self, last: cython.Py_ssize_t) -> int:
        """Return the common divisor of the steps, in ticks, of the latest readings."""
        i: cython.Py_ssize_t
        common: cython.longlong = 0
        a: cython.longlong
        b: cython.longlong
        for i in range(self.start + self.count - last + 1, self.start + self.count):
            a = round_to(self.tick[i] - self.tick[i - 1])
            b = common
            while b:
                a, b = b, a % b
            common = a
        return common

    def regress(self, last: cython.Py_ssize_t,
                period: cython.double) -> tuple[float, float, float]:
        """
        Compare fourth differences of the latest positions with those of velocity times deviation.

        Only joints that go on one way count: noise at rest says nothing. Return sums of the
        products, of the squares of the second, of the squares of the first; all 0 where no joint
        goes on.
        """
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        k: cython.Py_ssize_t
        b: cython.Py_ssize_t
        f: cython.Py_ssize_t = self.start + self.count - last
        cross: cython.double = 0.0
        of_stamps: cython.double = 0.0
        of_all: cython.double = 0.0
        for i in range(last):
            self.base[i] = (self.tick[f + i] - self.tick[f]) * period
        for j in range(self.n):
            way: cython.double = 0.0
            for i in range(1, last):
                way += fabs(self.q[f + i, j] - self.q[f + i - 1, j])
            if not fabs(self.q[f + last - 1, j] - self.q[f, j]) > 0.9 * way:
                continue
            for i in range(1, last - 1):
                # By the stamps: by ticks, which those of an irregular device are far from, the
                # share would seem less than it is.
                span: cython.double = self.base[i + 1] - self.base[i - 1]
                least: cython.double = 0.5 * span
                span += self.deviation[f + i + 1] - self.deviation[f + i - 1]
                v: cython.double = ((self.q[f + i + 1, j] - self.q[f + i - 1, j])
                                    / (span if span > least else least))
                self.product[i] = v * (self.deviation[f + i] - self.deviation[f])
                if i == 1:
                    self.product[0] = 0.0
                if i == last - 2:
                    self.product[i + 1] = v * (self.deviation[f + i + 1] - self.deviation[f])
            for i in range(last - 4):
                norm: cython.double = 0.0
                dq: cython.double = 0.0
                de: cython.double = 0.0
                for k in range(5):
                    c: cython.double = 1.0
                    for b in range(5):
                        if b != k:
                            c *= self.base[i + k] - self.base[i + b]
                    c = 1.0 / c
                    norm += c * c
                    dq += c * (self.q[f + i + k, j] - self.q[f, j])
                    de += c * self.product[i + k]
                cross += dq * de / norm
                of_stamps += de * de / norm
                of_all += dq * dq / norm
        return cross, of_stamps, of_all


def fill(row: cython.double[::1], values: Sequence[float]) -> cython.void:
    """Let a row have these numbers; raise ValueError if there are fewer or more."""
    j: cython.Py_ssize_t
    if len(values) != row.shape[0]:
        raise ValueError(f'{len(values)} numbers where {row.shape[0]} belong')
    for j in range(row.shape[0]):
        row[j] = values[j]


def round_to(value: cython.double) -> cython.longlong:
    """Return the nearest integer."""
    if cython.compiled:
        return cython.cast(cython.longlong, value + 0.5 if value > 0.0 else value - 0.5)
    else:
        return int(value + 0.5) if value > 0.0 else -int(0.5 - value)
