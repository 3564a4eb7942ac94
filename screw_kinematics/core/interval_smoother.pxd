# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
from .gains cimport Gains

cdef double AROUND, COLOURED, DENSEST, FAST, LEAST, SLOWEST, SPARSE, TIME_UNIT, WORTH


cdef class IntervalSmoother:
    cdef Py_ssize_t m, n
    cdef Py_ssize_t longest, signals    # for which there is room
    cdef double wide, steep
    cdef Gains gains
    cdef double[::1] scale, times
    cdef double[:, ::1] p           # predicted covariances, (N, 10 M)
    cdef double[:, ::1] gain        # (N, 4 M)
    cdef double[:, ::1] s           # variances of the innovations, (N, M)
    cdef double[:, ::1] alone       # information of the others about a sample, (N, M)
    cdef double[:, ::1] spread      # smoothed variances, (N, 4 M)
    cdef double[:, ::1] logs        # what of a score the times tell, summed around each, (N, M)
    cdef double[:, ::1] span        # samples in the window around each, (N, 1)
    cdef double[::1] keep           # share of the window that is left from one to the next
    # Of J signals:
    cdef double[:, ::1] x           # states, (N, 4 J M)
    cdef double[:, ::1] error       # innovations, then what each is without itself, (N, J M)
    cdef double[:, ::1] mean        # sums of their squares from each on, then their means, (N, J M)
    cdef double[:, ::1] carried     # what a pass carries from sample to sample, (5 J, M)
    cdef double[::1] weight
    cdef double[::1] level          # logarithms of the noise that filters find
    cdef double[::1] step           # of the handicap where noise is coloured, to each filter
    cdef double[:, ::1] work

    cdef void remember(self, Py_ssize_t i) noexcept
    cdef void around(self, double[:, ::1] of) noexcept
    cdef void backward(self) noexcept
    cdef void spread_of(self, Py_ssize_t i, Py_ssize_t k, double[:, ::1] p,
                        double[:, ::1] f) noexcept
    cdef void begin(self) noexcept
    cdef void follow(self, Py_ssize_t i, Py_ssize_t j, double z) noexcept
    cdef void look_back(self, Py_ssize_t i, Py_ssize_t j) noexcept
    cdef void mix(self, Py_ssize_t i, Py_ssize_t j, double floor, double[:, ::1] state,
                  double[:, ::1] variance, double[:, ::1] rest) noexcept
