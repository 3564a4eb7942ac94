# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython


@cython.final
cdef class ClockError:
    cdef readonly double time, rate

    @cython.locals(rate=double, by=double)
    cpdef tuple deviations(self, long order, object own, object onward)
    @cython.locals(late=double, fast=double)
    cpdef double variance(self, long order, double own, double onward)
