# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cdef double kth(double[::1] values, Py_ssize_t count, Py_ssize_t k) noexcept
cdef double median(double[::1] values, Py_ssize_t count) noexcept
cdef void fit_line(double[::1] k, double[::1] t, Py_ssize_t count, double[::1] weight,
                   double[::1] rest, double[::1] out) noexcept
cdef double mean_error(double[::1] k, double[::1] t, Py_ssize_t count, double[::1] weight,
                       double[::1] line) noexcept


cdef class Line:
    cdef Py_ssize_t size, count, gathered
    cdef readonly Py_ssize_t stride
    cdef double sum_k, sum_t
    cdef readonly double error      # of the mean of its deviations; 0: not known
    cdef double[::1] k, t, weight, rest, out

    cpdef void add(self, double tick, double stamp) noexcept
    cpdef void keep(self, Py_ssize_t last) noexcept
    cpdef bint full(self) noexcept
