# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from libc.math cimport lrint as round       # as Python does: halves to even

from ..core.robust_line cimport Line

cdef double SURPRISE, WRONG
cdef long LATE, FEWEST, MOST_TICKS


@cython.final
cdef class TickCounter:
    cdef dict __dict__
    cdef public double phase, period, tick, deviation, behind, early, lean, sets, shift, total
    cdef public double unseen
    cdef public long count
    cdef public Line line
    cdef public dict often
    cdef double _weight, _before, _known
    cdef long _due
    cdef object _recent

    @cython.locals(counter=TickCounter)
    cpdef TickCounter fresh(self, double stamp)
    cpdef (double, double) line_error(self)
    @cython.locals(error=double)
    cpdef (double, double) stated_error(self)
    @cython.locals(end=double, rate=double)
    cdef (double, double) _line_error(self, double mean)
    cpdef bint vague(self)
    cpdef bint usual(self)
    cpdef double surprise(self, long d) except? -1.0
    @cython.locals(lateness=double, behind=double, early=double, late=double, cost=double,
                   surprise=double,
                   best=double, off=double, d=long, near=long, by_joints=long, found=long,
                   lowest=long, highest=long)
    cpdef long number(self, double stamp, double x, double foreseen, double unforeseen,
                      double repeats) except -1
    cpdef note(self, long d)
    @cython.locals(period=double, late=double, held_up=bint, shift=double)
    cpdef double advance(self, long d, double stamp, bint sure) except? -1e300
    @cython.locals(new=TickCounter)
    cpdef TickCounter recounted(self, list numbers, list stamps, double at_zero, double period,
                                double deviation)
    @cython.locals(tolerance=double, least=double)
    cdef double _set_by(self, double late) except? -1e300
    @cython.locals(gain=double, most=double, wobble=double)
    cdef void _learn(self, double late) noexcept
    cdef bint _catching_up(self, double fallen, double messages) noexcept
