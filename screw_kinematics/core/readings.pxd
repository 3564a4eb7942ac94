# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cdef void fill(double[::1] row, object values) except *
cdef long long round_to(double value) noexcept


cdef class Readings:
    cdef Py_ssize_t n, size, count
    cdef double[::1] tick, deviation, stamp
    cdef double[::1] time               # device time at which the filters took it
    cdef double[:, ::1] q
    cdef double[::1] latest
    cdef double[::1] base, product      # what `regress` works on

    cpdef void drop(self, Py_ssize_t first) noexcept
