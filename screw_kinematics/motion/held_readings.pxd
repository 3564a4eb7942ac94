# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from ..core.bank cimport Bank

cdef double HELD_MOST, UNLIKELY, HARDEST


@cython.final
cdef class HeldReadings:
    cdef public double hold, quantum
    cdef public bint standing
    cdef long _same, _ticks, _ticks_before
    cdef double _came, _ran
    cdef object _position, _one_ago, _two_ago, _before

    cpdef bint repeats(self, double stamp, double age, double foreseen, double unit,
                       Bank bank) except -1
    cpdef moved(self, double stamp, object position, long ticks, bint learn)
