# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: initializedcheck=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How many ticks of a device have passed, by how far the joints have travelled."""
from __future__ import annotations

try:
    import cython
except ImportError:
    from . import uncompiled as cython
from .tables import zeros
if cython.compiled:
    from cython.cimports.libc.math import fabs, sqrt
else:
    from math import fabs, sqrt

AT_ODDS = cython.declare(cython.double, 0.3)
"""Ticks by which a joint may be at odds with all others together."""

MOST_TICKS = cython.declare(cython.double, 40.0)


class Travel:
    """
    How far n joints have travelled along the move that is foreseen for one tick.

    No joint alone counts ticks: one that is at odds with the weighted median of what all have
    travelled is thought to be where that says.
    """

    def __init__(self, n: int) -> None:
        self.n = n
        self.move, self.gone, self.each, self.size = zeros(n), zeros(n), zeros(n), zeros(n)
        # Positions that all agree on, if one joint is odd; ticks travelled; length of the move in
        # one tick [rad]; whether there is a joint at odds with all others.
        self.agreed, self.ticks, self.tick, self.odd = zeros(n), 0.0, 0.0, False

    def measure(self, now: cython.double[:, ::1], speed: cython.double[::1],
                position: cython.double[::1], unit: cython.double, span: cython.double,
                unforeseen: cython.double) -> None:
        """
        Measure a reading, whose position is new.

        ``now`` is the state of the joints at the reading before, (4, n), ``speed`` their
        velocities then, as known best [rad/s]. ``unit`` is the length of a tick, ``span`` the time
        that has passed as far as is known [both s]. ``unforeseen`` is the acceleration of all
        joints together that nobody foresaw [rad/s2].
        """
        j: cython.Py_ssize_t
        move: cython.double[::1] = self.move
        gone: cython.double[::1] = self.gone
        half: cython.double = 0.5 * span
        third: cython.double = span * span / 6.0
        square: cython.double = 1e-300
        along: cython.double = 0.0
        for j in range(self.n):
            move[j] = unit * (speed[j] + half * now[2, j] + third * now[3, j])
            gone[j] = position[j] - now[0, j]
            square += move[j] * move[j]
            along += move[j] * gone[j]
        self.tick, self.ticks = sqrt(square), along / square
        most: cython.double = 0.25 * unforeseen * span * span * self.tick
        most = most if most > AT_ODDS * square else AT_ODDS * square
        self.odd = False
        for j in range(self.n):
            self.odd = self.odd or fabs(move[j] * (gone[j] - self.ticks * move[j])) >= most
        if not self.odd:
            return
        median: cython.double = self.median()
        total: cython.double = 0.0
        at_odds: cython.double = 0.0
        for j in range(self.n):
            total += fabs(move[j]) + 1e-15
            if fabs(move[j]) * fabs(gone[j] - median * move[j]) > most:
                at_odds += fabs(move[j])
        self.odd = at_odds < 0.5 * total
        if not self.odd:
            return
        along = 0.0
        for j in range(self.n):
            self.agreed[j] = position[j]
            if fabs(move[j]) * fabs(gone[j] - median * move[j]) > most:
                self.agreed[j] = now[0, j] + median * move[j]
            along += move[j] * (self.agreed[j] - now[0, j])
        self.ticks = along / square

    def median(self) -> cython.double:
        """Return the median of what all have travelled, weighed by their moves: by insertion."""
        i: cython.Py_ssize_t = 0
        j: cython.Py_ssize_t
        k: cython.Py_ssize_t
        each: cython.double[::1] = self.each
        size: cython.double[::1] = self.size
        total: cython.double = 0.0
        passed: cython.double = 0.0
        for j in range(self.n):
            weight: cython.double = fabs(self.move[j]) + 1e-15
            ticks: cython.double = self.gone[j] / weight
            ticks = ticks if self.move[j] > 0.0 else -ticks if self.move[j] < 0.0 else 0.0
            total += weight
            k = j
            while k > 0 and each[k - 1] > ticks:
                each[k], size[k] = each[k - 1], size[k - 1]
                k -= 1
            each[k], size[k] = ticks, weight
        while i < self.n - 1 and passed + size[i] < 0.5 * total:
            passed += size[i]
            i += 1
        ticks = each[i] if each[i] > 0.0 else 0.0
        return ticks if ticks < MOST_TICKS else MOST_TICKS
