# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython


cdef double TIME_UNIT, LEAST


@cython.final
cdef class Gains:
    cdef readonly Py_ssize_t m
    cdef double[::1] power      # process density of each filter, but for the period
    cdef double[::1] four       # 1 for filters of order 4
    cdef double[:, ::1] noise   # coefficients of the process noise: order 3, order 4
    cdef double[:, ::1] p       # covariances, (10, M)
    cdef double[:, ::1] ahead   # the same before the latest sample
    cdef double[:, ::1] gain    # (4, M)
    cdef double[:, ::1] before  # those of the sample before
    cdef double[::1] s          # variance of the innovation,
    cdef double[::1] precision  # one over it,
    cdef double[::1] logs       # and its logarithm
    cdef double step, period    # what `follow` found gains for,
    cdef double change          # and how they changed

    cdef void start(self, double[::1] variances) noexcept
    cdef bint follow(self, double dt, double period) noexcept
    cdef void predict(self, double dt, double period) noexcept
    cdef double update(self) noexcept
