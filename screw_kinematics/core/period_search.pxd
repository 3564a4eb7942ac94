# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
from .readings cimport Readings, round_to
from .robust_line cimport fit_line, median

cdef double LEAST


cdef class PeriodSearch:
    cdef Readings readings
    cdef Py_ssize_t n, count
    cdef double[::1] stamp, time        # of the readings
    cdef double[:, ::1] q
    cdef double[:, ::1] slope_q
    cdef double[::1] slope_t, base, speed
    cdef double[::1] gone               # ticks, or time, travelled between readings
    cdef double[::1] one, two, out, grid, weights
    cdef double[:, ::1] options

    cdef void slopes(self, double[::1] base) noexcept
    cdef void travelled(self, double[::1] base) noexcept
    cdef void recount(self, Py_ssize_t option, double period) noexcept
    cdef double roughness(self, double[::1] times) noexcept
    cdef Py_ssize_t try_countings(self) noexcept
    cdef Py_ssize_t guess(self, Py_ssize_t good) noexcept
    cdef double apart(self, double frequency, Py_ssize_t good) noexcept
    cdef Py_ssize_t next_minimum(self, Py_ssize_t last, Py_ssize_t size) noexcept
    cdef double refined(self, double period, Py_ssize_t good) noexcept
    cdef bint is_known(self, Py_ssize_t option) noexcept
    cdef void fit(self, Py_ssize_t option) noexcept
    cdef bint normalise(self, Py_ssize_t option) noexcept
    cdef double price(self, Py_ssize_t option) noexcept
