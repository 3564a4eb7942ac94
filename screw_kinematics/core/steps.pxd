# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from .gains cimport Gains

cdef double TIME_UNIT


@cython.final
cdef class Pace:
    cdef double period              # mean step [s]
    cdef double usual               # mean of steps near the usual one
    cdef int unusual
    cdef double reference           # step that gains are found for while steps are near it
    cdef double pause               # a step from which on it is a pause
    cdef double until               # when that is no longer felt

    cdef void start(self, double time) noexcept
    cdef double follow(self, long long k, double time, double dt) noexcept
    cdef bint felt(self, double time) noexcept


@cython.final
cdef class Steps:
    cdef Py_ssize_t m, size
    cdef Gains now
    cdef long long oldest, latest
    cdef double[:, ::1] times
    cdef double[:, ::1] ratios          # step to the next one, in TIME_UNIT
    cdef double[:, ::1] covariances
    cdef double[:, ::1] gains
    cdef double[:, ::1] spreads         # variances of the innovations
    cdef double[:, ::1] taps            # weights of innovations since an instant, (4 steps, M)
    cdef double[:, ::1] smoothed        # covariance there with so many steps, (10 steps, M)
    cdef double[:, ::1] work            # (16, M)
    cdef double tap_step                # step that the taps are for, once gains are steady

    cdef void clear(self) noexcept
    cdef bint crowded(self, double since) noexcept
    cdef Py_ssize_t remember(self, double time, double step) noexcept
    cdef long long nearest(self, double at) noexcept
    cdef void make_taps(self, long long i, double used, long long steady) noexcept
