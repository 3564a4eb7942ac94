# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: initializedcheck=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a device's clock is found from: loops over stamps and positions.

A *reading* is a position that was read at a tick of the device; its *deviation* is how much later
than the tick its stamp is, in the device's time.
"""

from __future__ import annotations

from array import array
from typing import Any

try:
    import cython
except ImportError:
    from . import uncompiled as cython
if cython.compiled:
    from cython.cimports.libc.math import fabs, log, sqrt
else:
    from math import fabs, log, sqrt

WHOLE = cython.declare(cython.double, 6755399441055744.0)     # adding it rounds
LEAST = cython.declare(cython.double, 1e-26)
FIRST = cython.declare(cython.int, 12)        # readings that a search needs
FINER = cython.declare(cython.double, 0.3)    # deviation of stamps, in periods, of a finer clock
GUESSES = cython.declare(cython.int, 3)       # periods that a search tries
SLOPE = (86.0, -142.0, -193.0, -126.0, 0.0, 126.0, 193.0, 142.0, -86.0)
"""Slope of a cubic fitted to nine points, times 1188."""


def table(rows: int, columns: int) -> Any:
    """Return a table of zeros."""
    return memoryview(array('d', bytes(8 * rows * columns))).cast('B').cast('d', (rows, columns))


def row(count: int) -> Any:
    """Return zeros in a row."""
    return memoryview(array('d', bytes(8 * count)))


@cython.cfunc
@cython.exceptval(check=False)
def kth(values: cython.double[::1], count: cython.Py_ssize_t,
        k: cython.Py_ssize_t) -> cython.double:
    """Return the k-th smallest of some numbers, which are reordered (Hoare)."""
    low: cython.Py_ssize_t = 0
    high: cython.Py_ssize_t = count - 1
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    while low < high:
        pivot: cython.double = values[k]
        i, j = low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while pivot < values[j]:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i += 1
                j -= 1
        if j < k:
            low = i
        if k < i:
            high = j
    return values[k]


@cython.cfunc
@cython.exceptval(check=False)
def median(values: cython.double[::1], count: cython.Py_ssize_t) -> cython.double:
    """Return the median of some numbers, which are reordered."""
    upper: cython.double = kth(values, count, count // 2)
    if count % 2 == 1:
        return upper
    return 0.5 * (upper + kth(values, count, count // 2 - 1))


@cython.cfunc
@cython.exceptval(check=False)
def fit_line(k: cython.double[::1], t: cython.double[::1], count: cython.Py_ssize_t,
             weight: cython.double[::1], rest: cython.double[::1],
             out: cython.double[::1]) -> cython.void:
    """Fit t = out[0] + out[1] k, outliers counting less (Huber); out[2] is the mean deviation."""
    i: cython.Py_ssize_t
    turn: cython.Py_ssize_t
    slope: cython.double = 0.0
    mk: cython.double = 0.0
    mt: cython.double = 0.0
    mean: cython.double = 0.0
    for i in range(count):
        weight[i] = 1.0
    for turn in range(4):
        total: cython.double = 0.0
        mk = mt = 0.0
        for i in range(count):
            total += weight[i]
            mk += weight[i] * k[i]
            mt += weight[i] * t[i]
        mk /= total
        mt /= total
        both: cython.double = 0.0
        square: cython.double = 0.0
        for i in range(count):
            both += weight[i] * (k[i] - mk) * (t[i] - mt)
            square += weight[i] * (k[i] - mk) * (k[i] - mk)
        slope = both / square
        mean = 0.0
        for i in range(count):
            rest[i] = fabs(t[i] - mt - slope * (k[i] - mk))
            weight[i] = rest[i]
            mean += rest[i]
        allowed: cython.double = 1.5 * median(rest, count) + 1e-9
        for i in range(count):
            weight[i] = 1.0 if weight[i] <= allowed else allowed / weight[i]
    out[0], out[1], out[2] = mt - slope * mk, slope, mean / count


@cython.cclass
class Line:
    """The latest pairs of tick and stamp, and the line through them."""

    size: cython.Py_ssize_t
    count: cython.Py_ssize_t
    k: cython.double[::1]
    t: cython.double[::1]
    weight: cython.double[::1]
    rest: cython.double[::1]
    out: cython.double[::1]

    def __init__(self, size: int) -> None:
        self.size, self.count = size, 0
        self.k, self.t, self.out = row(size), row(size), row(3)
        self.weight, self.rest = row(size), row(size)

    def add(self, tick: cython.double, stamp: cython.double) -> None:
        """Add a pair; the oldest quarter is forgotten where there is no room."""
        if self.count == self.size:
            self.keep(self.size - self.size // 4)
        self.k[self.count], self.t[self.count] = tick, stamp
        self.count += 1

    def keep(self, last: cython.Py_ssize_t) -> None:
        """Forget all but the latest pairs."""
        i: cython.Py_ssize_t
        if last >= self.count:
            return
        for i in range(last):
            self.k[i], self.t[i] = self.k[self.count - last + i], self.t[self.count - last + i]
        self.count = last

    def thin(self) -> None:
        """Forget every second pair."""
        i: cython.Py_ssize_t
        for i in range(self.count // 2):
            self.k[i], self.t[i] = self.k[2 * i + 1], self.t[2 * i + 1]
        self.count //= 2

    def rescale(self, origin: cython.double, factor: cython.double) -> None:
        """Count ticks from another origin, and by another length."""
        i: cython.Py_ssize_t
        for i in range(self.count):
            self.k[i] = (self.k[i] - origin) / factor

    def full(self) -> bool:
        """Whether the next pair takes the place of old ones."""
        return self.count == self.size

    def ticks(self) -> float:
        """Return the ticks from the first pair to the last."""
        return self.k[self.count - 1] - self.k[0] if self.count else 0.0

    def pairs(self) -> int:
        """Return their number."""
        return self.count

    def fit(self, tick: cython.double) -> tuple[float, float, float]:
        """Return the line's stamp at a tick, its slope, and the mean deviation."""
        i: cython.Py_ssize_t
        start: cython.double = self.t[self.count - 1]
        for i in range(self.count):
            self.k[i] -= tick
            self.t[i] -= start
        fit_line(self.k, self.t, self.count, self.weight, self.rest, self.out)
        for i in range(self.count):
            self.k[i] += tick
            self.t[i] += start
        return self.out[0] + start, self.out[1], self.out[2]


@cython.cclass
class Readings:
    """
    The latest readings, each at another tick than the one before.

    Parameters
    ----------
    n:
        Number of joints.
    size:
        How many are kept.

    """

    n: cython.Py_ssize_t
    size: cython.Py_ssize_t
    count: cython.Py_ssize_t
    tick: cython.double[::1]
    deviation: cython.double[::1]
    stamp: cython.double[::1]
    time: cython.double[::1]          # device time at which the filters took it
    q: cython.double[:, ::1]
    slope_q: cython.double[:, ::1]
    slope_t: cython.double[::1]
    base: cython.double[::1]
    gone: cython.double[::1]          # ticks, or time, travelled between readings
    speed: cython.double[::1]
    one: cython.double[::1]
    two: cython.double[::1]
    options: cython.double[:, ::1]
    score: cython.double[::1]
    out: cython.double[::1]
    grid: cython.double[::1]
    weights: cython.double[::1]

    def __init__(self, n: int, size: int) -> None:
        self.n, self.size, self.count = n, size, 0
        self.tick, self.deviation, self.stamp = row(size), row(size), row(size)
        self.time, self.base, self.gone, self.speed = row(size), row(size), row(size), row(size)
        self.one, self.two, self.slope_t = row(size), row(size), row(size)
        self.q, self.slope_q = table(size, n), table(size, n)
        self.options, self.score, self.out = table(GUESSES + 1, size), row(GUESSES + 1), row(3)
        self.grid, self.weights = row(8192), row(9)
        for i in range(9):
            self.weights[i] = SLOPE[i] / 1188.0

    def clear(self) -> None:
        """Forget all."""
        self.count = 0

    def number(self) -> int:
        """Return how many there are."""
        return self.count

    def add(self, tick: cython.double, deviation: cython.double, stamp: cython.double,
            time: cython.double, position: cython.double[::1]) -> None:
        """Add a reading; the oldest one is forgotten where there is no room."""
        if self.count == self.size:
            self.drop(1)
        j: cython.Py_ssize_t
        i: cython.Py_ssize_t = self.count
        self.tick[i], self.deviation[i], self.stamp[i], self.time[i] = (
            tick, deviation, stamp, time)
        for j in range(self.n):
            self.q[i, j] = position[j]
        self.count += 1

    def drop(self, first: cython.Py_ssize_t) -> None:
        """Forget the oldest ones."""
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        for i in range(self.count - first):
            self.tick[i], self.deviation[i] = self.tick[i + first], self.deviation[i + first]
            self.stamp[i], self.time[i] = self.stamp[i + first], self.time[i + first]
            for j in range(self.n):
                self.q[i, j] = self.q[i + first, j]
        self.count -= first

    def at(self, i: int) -> tuple[float, float, float, float]:
        """Return tick, deviation, stamp and time of reading i; -1: the latest."""
        k = self.count + i if i < 0 else i
        return self.tick[k], self.deviation[k], self.stamp[k], self.time[k]

    def position(self, i: int) -> Any:
        """Return the positions of reading i."""
        return array('d', [self.q[i, j] for j in range(self.n)])

    def place(self, i: int, tick: float, deviation: float, time: float) -> None:
        """Put reading i at another tick."""
        self.tick[i], self.deviation[i], self.time[i] = tick, deviation, time

    def rescale(self, origin: cython.double, factor: cython.double) -> None:
        """Count ticks from another origin, and by another length."""
        i: cython.Py_ssize_t
        for i in range(self.count):
            self.tick[i] = (self.tick[i] - origin) / factor

    def divisor(self, last: cython.Py_ssize_t) -> int:
        """Return the common divisor of the steps, in ticks, of the latest readings."""
        i: cython.Py_ssize_t
        common: cython.longlong = 0
        a: cython.longlong
        b: cython.longlong
        for i in range(self.count - last + 1, self.count):
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

        Only joints that go on one way count: noise at rest says nothing.

        Returns
        -------
        Sums of the products, of the squares of the second, of the squares of the first; all 0
        where no joint goes on.

        """
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        k: cython.Py_ssize_t
        b: cython.Py_ssize_t
        f: cython.Py_ssize_t = self.count - last
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
                v: cython.double = ((self.q[f + i + 1, j] - self.q[f + i - 1, j])
                                    / (self.base[i + 1] - self.base[i - 1]))
                self.one[i] = v * (self.deviation[f + i] - self.deviation[f])
                if i == 1:
                    self.one[0] = 0.0
                if i == last - 2:
                    self.one[i + 1] = v * (self.deviation[f + i + 1] - self.deviation[f])
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
                    de += c * self.one[i + k]
                cross += dq * de / norm
                of_stamps += de * de / norm
                of_all += dq * dq / norm
        return cross, of_stamps, of_all

    # ---- the search for a period

    @cython.cfunc
    @cython.exceptval(check=False)
    def _slopes(self, base: cython.double[::1]) -> cython.void:
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

    @cython.cfunc
    @cython.exceptval(check=False)
    def _travelled(self, base: cython.double[::1]) -> cython.void:
        """Write the time, in the unit of rough times, in which the joints make each step."""
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        self._slopes(base)
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

    @cython.cfunc
    @cython.exceptval(check=False)
    def _recount(self, option: cython.Py_ssize_t, period: cython.double) -> cython.void:
        """Count ticks of a period from the rough times in `base`, twice."""
        i: cython.Py_ssize_t
        turn: cython.Py_ssize_t
        for turn in range(2):
            self._travelled(self.base)
            self.base[0] = 0.0
            ticks: cython.double = 0.0
            for i in range(self.count - 1):
                d: cython.double = (self.gone[i] / period + WHOLE) - WHOLE
                ticks += d if d > 1.0 else 1.0
                self.base[i + 1] = ticks * period
        for i in range(self.count):
            self.options[option, i] = (self.base[i] / period + WHOLE) - WHOLE

    @cython.cfunc
    @cython.exceptval(check=False)
    def _roughness(self, times: cython.double[::1]) -> cython.double:
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
        """Forget readings before the joints moved; return how many are left."""
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        n: cython.Py_ssize_t = self.count
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

        Parameters
        ----------
        late:
            What the stamps' mean deviation from a line through them may be, beside a quarter of
            the period [s].
        period:
            The present one [s].

        Returns
        -------
        By how much the logarithm of the likelihood rises over the times that the filters took the
        readings at; the ticks; of the line through the stamps: the stamp at tick 0, the period,
        the mean deviation. None if there is no other counting.

        """
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        o: cython.Py_ssize_t
        n: cython.Py_ssize_t = self.count
        if n < FIRST:
            return None
        for i in range(1, n):
            if not self.time[i] > self.time[i - 1]:
                return None
        for i in range(n):
            self.base[i] = i
        self._recount(0, 1.0)
        count: cython.Py_ssize_t = 1
        self._travelled(self.time)
        for i in range(n - 1):
            self.two[i] = self.speed[i]
        least: cython.double = 0.3 * median(self.two, n - 1)
        good: cython.Py_ssize_t = 0
        first: cython.Py_ssize_t = 4 if n >= 24 else 0
        for i in range(first, n - 1 - first):
            if self.speed[i] > least and self.gone[i] > 0.0:
                self.one[good] = self.gone[i]
                good += 1
        if good >= 8:
            count = 1 + self._guess(good)
        for i in range(n):
            self.two[i] = self.time[i] - self.time[0]
        now: cython.double = self._roughness(self.two)
        if not now > 0.0:
            return None
        best: cython.Py_ssize_t = -1
        most: cython.double = 0.0
        fits = []
        for o in range(count):
            fits.append((0.0, 0.0, 0.0))
            if not self._normalise(o):
                continue
            known: cython.bint = False
            for k in range(o):
                same: cython.bint = True
                for i in range(n):
                    same = same and self.options[k, i] == self.options[o, i]
                known = known or same
            if known:
                continue
            for i in range(n):
                self.base[i] = self.options[o, i]
                self.gone[i] = self.stamp[i] - self.stamp[0]
            fit_line(self.base, self.gone, n, self.one, self.two, self.out)
            fits[o] = (self.out[0] + self.stamp[0], self.out[1], self.out[2])
            # The stamps must bear it, too; and show ticks that are finer than the messages'.
            if (self.out[2] > 1.5 * (late + 0.25 * self.out[1])
                    or self.out[1] < 0.7 * period and self.out[2] > FINER * self.out[1]):
                continue
            for i in range(n):
                self.two[i] = self.options[o, i] * self.out[1]
            gain: cython.double = (0.5 * (n - 4) * log(
                (now + LEAST) / (self._roughness(self.two) + LEAST)) - self._price(o))
            if best < 0 or gain > most:
                best, most = o, gain
        if best < 0:
            return None
        return (most, [self.options[best, i] for i in range(n)], *fits[best])

    @cython.cfunc
    @cython.exceptval(check=False)
    def _guess(self, good: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Count by the periods of which the times in `one` are nearly multiples."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        top: cython.double = 0.0
        for i in range(good):
            top = self.one[i] if self.one[i] > top else top
            self.two[i] = self.one[i]
        middle: cython.double = median(self.two, good)
        f0: cython.double = 0.8 / top
        step: cython.double = 0.08 / top
        size: cython.Py_ssize_t = 0
        while size < 8192 and f0 + size * step < 12.5 / middle:
            f: cython.double = f0 + size * step
            total: cython.double = 0.0
            for i in range(good):
                part: cython.double = f * self.one[i]
                part -= (part + WHOLE) - WHOLE
                part *= part
                total += part if part < 0.09 else 0.09
            self.grid[size] = total
            size += 1
        found: cython.Py_ssize_t
        last: cython.Py_ssize_t = -1
        for found in range(GUESSES):
            k = -1                      # the lowest of the minima after the last one
            for i in range(1, size - 1):
                value: cython.double = self.grid[i]
                if not (value <= self.grid[i - 1] and value <= self.grid[i + 1]):
                    continue
                if last >= 0 and not (value > self.grid[last]
                                      or value == self.grid[last] and i > last):
                    continue
                if k < 0 or value < self.grid[k]:
                    k = i
            if k < 0:
                return found
            last = k
            guess: cython.double = 1.0 / (f0 + k * step)
            both: cython.double = 0.0
            square: cython.double = 0.0
            for i in range(good):
                d: cython.double = (self.one[i] / guess + WHOLE) - WHOLE
                d = d if d > 1.0 else 1.0
                both += self.one[i] * d
                square += d * d
            for i in range(self.count):
                self.base[i] = self.time[i] - self.time[0]
            self._recount(1 + found, both / square)
        return GUESSES

    @cython.cfunc
    @cython.exceptval(check=False)
    def _normalise(self, option: cython.Py_ssize_t) -> cython.bint:
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

    @cython.cfunc
    @cython.exceptval(check=False)
    def _price(self, option: cython.Py_ssize_t) -> cython.double:
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


@cython.cfunc
@cython.exceptval(check=False)
def round_to(value: cython.double) -> cython.longlong:
    """Return the nearest integer."""
    if cython.compiled:
        return cython.cast(cython.longlong, value + 0.5 if value > 0.0 else value - 0.5)
    else:
        return int(value + 0.5) if value > 0.0 else -int(0.5 - value)
