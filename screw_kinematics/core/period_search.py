# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: initializedcheck=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The search for the period of a device, from how far the joints went between readings."""
from __future__ import annotations

try:
    import cython
except ImportError:
    from . import uncompiled as cython
from .readings import Readings
from .tables import LEAST, table, zeros
if cython.compiled:
    from cython.cimports.libc.math import log, sqrt
else:
    from math import log, sqrt
    from .readings import round_to
    from .robust_line import fit_line, median

WHOLE = cython.declare(cython.double, 6755399441055744.0)     # adding it rounds
FIRST = cython.declare(cython.int, 12)        # readings that a search needs
FINER = cython.declare(cython.double, 0.3)    # deviation of stamps, in periods, of a finer clock
GUESSES = cython.declare(cython.int, 3)       # periods that a search tries
GRID = cython.declare(cython.int, 8192)
SLOPE = (86.0, -142.0, -193.0, -126.0, 0.0, 126.0, 193.0, 142.0, -86.0)
"""Slope of a cubic fitted to nine points, times 1188."""


class PeriodSearch:
    """Searches the latest readings, those now and later."""

    def __init__(self, readings: Readings) -> None:
        size = readings.size
        self.readings, self.n, self.count = readings, readings.n, 0
        self.stamp, self.time, self.q = readings.stamp, readings.time, readings.q
        self.base, self.gone, self.speed = zeros(size), zeros(size), zeros(size)
        self.one, self.two, self.slope_t = zeros(size), zeros(size), zeros(size)
        self.slope_q, self.options = table(size, readings.n), table(GUESSES + 1, size)
        self.out, self.grid, self.weights = zeros(3), zeros(GRID), zeros(9)
        for i in range(9):
            self.weights[i] = SLOPE[i] / 1188.0

    def slopes(self, base: cython.double[::1]) -> None:
        """Write the slopes, by number, of times and positions: cubics, straight on at the ends."""
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        k: cython.Py_ssize_t
        n: cython.Py_ssize_t = self.count
        s: cython.double
        up: cython.double
        down: cython.double
        for i in range(4, n - 4):
            s = 0.0
            for k in range(9):
                s += self.weights[k] * base[i - 4 + k]
            self.slope_t[i] = s
            for j in range(self.n):
                s = 0.0
                for k in range(9):
                    s += self.weights[k] * (self.q[i - 4 + k, j] - self.q[0, j])
                self.slope_q[i, j] = s
        more: cython.bint = n > 9
        up = self.slope_t[5] - self.slope_t[4] if more else 0.0
        down = self.slope_t[n - 5] - self.slope_t[n - 6] if more else 0.0
        for k in range(1, 5):
            self.slope_t[4 - k] = self.slope_t[4] - k * up
            self.slope_t[n - 5 + k] = self.slope_t[n - 5] + k * down
        for j in range(self.n):
            up = self.slope_q[5, j] - self.slope_q[4, j] if more else 0.0
            down = self.slope_q[n - 5, j] - self.slope_q[n - 6, j] if more else 0.0
            for k in range(1, 5):
                self.slope_q[4 - k, j] = self.slope_q[4, j] - k * up
                self.slope_q[n - 5 + k, j] = self.slope_q[n - 5, j] + k * down

    def travelled(self, base: cython.double[::1]) -> None:
        """Write the time, in the unit of rough times, in which the joints make each step."""
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        self.slopes(base)
        for i in range(self.count - 1):
            along: cython.double = 0.0
            square: cython.double = 0.0
            a: cython.double = self.slope_t[i] if self.slope_t[i] > 1e-12 else 1e-12
            b: cython.double = self.slope_t[i + 1] if self.slope_t[i + 1] > 1e-12 else 1e-12
            for j in range(self.n):
                v: cython.double = 0.5 * (self.slope_q[i, j] / a + self.slope_q[i + 1, j] / b)
                along += v * (self.q[i + 1, j] - self.q[i, j])
                square += v * v
            self.gone[i] = along / (square if square > 1e-30 else 1e-30)
            self.speed[i] = sqrt(square)

    def recount(self, option: cython.Py_ssize_t, period: cython.double) -> None:
        """Count ticks of a period from the rough times in `base`, twice."""
        i: cython.Py_ssize_t
        turn: cython.Py_ssize_t
        for turn in range(2):
            self.travelled(self.base)
            self.base[0] = 0.0
            ticks: cython.double = 0.0
            for i in range(self.count - 1):
                d: cython.double = (self.gone[i] / period + WHOLE) - WHOLE
                ticks += d if d > 1.0 else 1.0
                self.base[i + 1] = ticks * period
        for i in range(self.count):
            self.options[option, i] = (self.base[i] / period + WHOLE) - WHOLE

    def roughness(self, times: cython.double[::1]) -> cython.double:
        """Return the sum of squares of the positions' normalised fourth divided differences."""
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        k: cython.Py_ssize_t
        b: cython.Py_ssize_t
        total: cython.double = 0.0
        for i in range(self.count - 4):
            norm: cython.double = 0.0
            for k in range(5):
                c: cython.double = 1.0
                for b in range(5):
                    if b != k:
                        c *= times[i + k] - times[i + b]
                self.speed[k] = 1.0 / c
                norm += self.speed[k] * self.speed[k]
            for j in range(self.n):
                d: cython.double = 0.0
                for k in range(5):
                    d += self.speed[k] * (self.q[i + k, j] - self.q[0, j])
                total += d * d / norm
        return total / (self.count - 4)

    def since_moving(self) -> int:
        """Return how many of the readings are since the joints moved."""
        self.readings.move_to_front()
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        n: cython.Py_ssize_t = self.readings.count
        if n < 2:
            return n
        for i in range(n - 1):
            square: cython.double = 0.0
            for j in range(self.n):
                d: cython.double = self.q[i + 1, j] - self.q[i, j]
                square += d * d
            self.gone[i] = sqrt(square)
        last: cython.Py_ssize_t = n - 1 if n - 1 < 8 else 8
        for i in range(last):
            self.one[i] = self.gone[n - 1 - last + i]
        least: cython.double = 0.2 * median(self.one, last)
        slow: cython.Py_ssize_t = 0
        for i in range(n - 1):
            if self.gone[i] < least:
                slow = i + 1
        return n - slow

    def search(self, late: cython.double, period: cython.double,
               ) -> tuple[float, list[float], float, float, float] | None:
        """
        Try other countings of the readings; they have to be at least `FIRST`.

        Times travelled by the joints between readings, from local slopes, are near multiples of
        the device's period. Of the countings found so the one is best that makes the positions
        smoothest, less what it costs to tell these ticks.

        ``late`` is what the stamps' mean deviation from a line through them may be, beside a
        quarter of ``period``, the present one [both s].

        Return by how much the logarithm of the likelihood rises over the times that the filters
        took the readings at; the ticks; of the line through the stamps: the stamp at tick 0, the
        period, the mean deviation [s]. None if there is no other counting.
        """
        i: cython.Py_ssize_t
        o: cython.Py_ssize_t
        n: cython.Py_ssize_t = self.readings.count
        self.readings.move_to_front()
        self.count = n
        if n < FIRST:
            return None
        for i in range(1, n):
            if not self.time[i] > self.time[i - 1]:
                return None
        count: cython.Py_ssize_t = self.try_countings()
        for i in range(n):
            self.two[i] = self.time[i] - self.time[0]
        now: cython.double = self.roughness(self.two)
        if not now > 0.0:
            return None
        best = None
        most: cython.double = 0.0
        for o in range(count):
            if not self.normalise(o) or self.is_known(o):
                continue
            self.fit(o)
            # The stamps must bear it, too; and show ticks that are finer than the messages'.
            if (self.out[2] > 1.5 * (late + 0.25 * self.out[1])
                    or self.out[1] < 0.7 * period and self.out[2] > FINER * self.out[1]):
                continue
            for i in range(n):
                self.two[i] = self.options[o, i] * self.out[1]
            gain: cython.double = (0.5 * (n - 4) * log(
                (now + LEAST) / (self.roughness(self.two) + LEAST)) - self.price(o))
            if best is None or gain > most:
                most = gain
                best = (gain, [self.options[o, i] for i in range(n)],
                        self.out[0] + self.stamp[0], self.out[1], self.out[2])
        return best

    def try_countings(self) -> cython.Py_ssize_t:
        """Write the countings to choose from, the first by the messages; return how many."""
        i: cython.Py_ssize_t
        n: cython.Py_ssize_t = self.count
        for i in range(n):
            self.base[i] = i
        self.recount(0, 1.0)
        self.travelled(self.time)
        for i in range(n - 1):
            self.two[i] = self.speed[i]
        least: cython.double = 0.3 * median(self.two, n - 1)
        good: cython.Py_ssize_t = 0
        first: cython.Py_ssize_t = 4 if n >= 24 else 0
        for i in range(first, n - 1 - first):
            if self.speed[i] > least and self.gone[i] > 0.0:
                self.one[good] = self.gone[i]
                good += 1
        return 1 + self.guess(good) if good >= 8 else 1

    def guess(self, good: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Count by the periods of which the times in `one` are nearly multiples."""
        i: cython.Py_ssize_t
        top: cython.double = 0.0
        for i in range(good):
            top = self.one[i] if self.one[i] > top else top
            self.two[i] = self.one[i]
        middle: cython.double = median(self.two, good)
        f0: cython.double = 0.8 / top
        step: cython.double = 0.08 / top
        size: cython.Py_ssize_t = 0
        while size < GRID and f0 + size * step < 12.5 / middle:
            self.grid[size] = self.apart(f0 + size * step, good)
            size += 1
        found: cython.Py_ssize_t
        last: cython.Py_ssize_t = -1
        for found in range(GUESSES):
            last = self.next_minimum(last, size)
            if last < 0:
                return found
            for i in range(self.count):
                self.base[i] = self.time[i] - self.time[0]
            self.recount(1 + found, self.refined(1.0 / (f0 + last * step), good))
        return GUESSES

    def apart(self, frequency: cython.double, good: cython.Py_ssize_t) -> cython.double:
        """Return how far the times in `one` are from whole periods, squared, summed, capped."""
        i: cython.Py_ssize_t
        total: cython.double = 0.0
        for i in range(good):
            part: cython.double = frequency * self.one[i]
            part -= (part + WHOLE) - WHOLE
            part *= part
            total += part if part < 0.09 else 0.09
        return total

    def next_minimum(self, last: cython.Py_ssize_t, size: cython.Py_ssize_t,
                     ) -> cython.Py_ssize_t:
        """Return where in `grid` the lowest of the minima after the last one is; -1: no more."""
        i: cython.Py_ssize_t
        lowest: cython.Py_ssize_t = -1
        for i in range(1, size - 1):
            value: cython.double = self.grid[i]
            if not (value <= self.grid[i - 1] and value <= self.grid[i + 1]):
                continue
            if last >= 0 and not (value > self.grid[last]
                                  or value == self.grid[last] and i > last):
                continue
            if lowest < 0 or value < self.grid[lowest]:
                lowest = i
        return lowest

    def refined(self, period: cython.double, good: cython.Py_ssize_t) -> cython.double:
        """Return the period that fits the times in `one` best, by their multiples of this one."""
        i: cython.Py_ssize_t
        both: cython.double = 0.0
        square: cython.double = 0.0
        for i in range(good):
            d: cython.double = (self.one[i] / period + WHOLE) - WHOLE
            d = d if d > 1.0 else 1.0
            both += self.one[i] * d
            square += d * d
        return both / square

    def is_known(self, option: cython.Py_ssize_t) -> cython.bint:
        """Return whether a counting is the same as one before it."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        for k in range(option):
            same: cython.bint = True
            for i in range(self.count):
                same = same and self.options[k, i] == self.options[option, i]
            if same:
                return True
        return False

    def fit(self, option: cython.Py_ssize_t) -> None:
        """Fit a line through the stamps, less the first, of a counting; it is in `out`."""
        i: cython.Py_ssize_t
        for i in range(self.count):
            self.base[i] = self.options[option, i]
            self.gone[i] = self.stamp[i] - self.stamp[0]
        fit_line(self.base, self.gone, self.count, self.one, self.two, self.out)

    def normalise(self, option: cython.Py_ssize_t) -> cython.bint:
        """Count from 0, in the longest ticks; return whether the ticks increase."""
        i: cython.Py_ssize_t
        common: cython.longlong = 0
        a: cython.longlong
        b: cython.longlong
        for i in range(1, self.count):
            a = round_to(self.options[option, i] - self.options[option, i - 1])
            if a < 1:
                return False
            b = common
            while b:
                a, b = b, a % b
            common = a
        start: cython.double = self.options[option, 0]
        for i in range(self.count):
            self.options[option, i] = (self.options[option, i] - start) / common
        return True

    def price(self, option: cython.Py_ssize_t) -> cython.double:
        """Return what it costs to tell a counting: steps times their entropy."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        total: cython.double = 0.0
        steps: cython.Py_ssize_t = self.count - 1
        for i in range(steps):
            d: cython.double = self.options[option, i + 1] - self.options[option, i]
            equal: cython.double = 0.0
            for k in range(steps):
                if self.options[option, k + 1] - self.options[option, k] == d:
                    equal += 1.0
            total -= log(equal / steps)
        return total
