# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython


@cython.final
cdef class Travel:
    cdef Py_ssize_t n
    cdef double[::1] move       # of each joint, foreseen for one tick
    cdef double[::1] gone       # how far it went
    cdef double[::1] each       # ticks that this makes, in order,
    cdef double[::1] size       # and their weights
    cdef double[::1] agreed     # positions that all agree on, where one is odd
    cdef double ticks, tick
    cdef bint odd

    cdef void measure(self, double[:, ::1] now, double[::1] speed, double[::1] position,
                      double unit, double span, double unforeseen) noexcept
    cdef double median(self) noexcept
