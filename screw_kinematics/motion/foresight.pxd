# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from ..core.bank cimport Bank

cdef double LONG, NEXT
cdef long FAR, FEW_TICKS


@cython.final
@cython.freelist(4)
cdef class Foreseen:
    cdef public double ticks, deviation, surprise, length, usual
    cdef public object agreed
    cdef public bint told
    cdef public long near

    cdef bint far(self, double age) noexcept
    cdef bint contradicts(self, long d) noexcept
    cdef double nearer(self, long d, double span, double unit) noexcept
    cdef object agreed_on(self, object position, long d)
    cpdef bint goes_on(self, object position, double unit, Bank bank) except -1


@cython.final
cdef class Foresight:
    cdef public object usual

    @cython.locals(span=double, foreseen=Foreseen)
    cpdef Foreseen foresee(self, object position, long near, double unit, Bank bank)
    @cython.locals(usual=double, off=double)
    cpdef learn(self, Foreseen foreseen, long d)
