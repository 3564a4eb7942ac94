# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cdef void fill(double[::1] row, object values) except *
cdef long long round_to(double value) noexcept


cdef class Readings:
    cdef Py_ssize_t n, size
    cdef Py_ssize_t start, count        # row of the oldest, number of all
    cdef double[::1] tick, deviation, stamp
    cdef double[::1] time               # device time at which the filters took it
    cdef double[:, ::1] q
    cdef double[::1] latest
    cdef double[::1] base, product      # what `regress` works on

    cpdef void add(self, double tick, double deviation, double stamp, double time,
                   object position) except *
    cpdef void drop(self, Py_ssize_t first) noexcept
    cdef void move_to_front(self) noexcept
    cpdef Py_ssize_t number(self) noexcept
