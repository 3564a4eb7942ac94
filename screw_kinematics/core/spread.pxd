# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from .channel cimport Channel
from .gains cimport Gains
from .mixture cimport Mixture
from .steps cimport Steps

cdef double FINEST, LEAST, TIME_UNIT

cdef void grow(double[:, ::1] t, Py_ssize_t j, Py_ssize_t i, double old, double new) noexcept
cdef double signal(double[:, ::1] out, Py_ssize_t j) noexcept


@cython.final
cdef class Spread:
    cdef Py_ssize_t n, m
    cdef bint delayed
    cdef double known_noise
    cdef Gains gains
    cdef Steps steps
    cdef double[:, ::1] work        # covariance at the latest step before the instant, (10, 1)
    cdef double[:, ::1] second      # what velocities tell, in rows as those that are read
    cdef double[:, ::1] apart       # forgetful mean squares of how far these are from positions'
    cdef double[::1] scale
    cdef double[::1] told           # squares of the largest signals that were clear of error

    cdef void start(self) noexcept
    cdef void tell(self, Mixture found, Channel c, Py_ssize_t j, double dt,
                   double[:, ::1] out) noexcept
    cdef void begin(self, Channel c, double dt) noexcept
    cdef void compare(self, Mixture found, Channel c, Py_ssize_t j) noexcept
    cdef void mix(self, Mixture found, Channel c, Py_ssize_t j) noexcept
    cdef void pause(self, Channel c, Py_ssize_t j, double dt, long long after) noexcept
    cdef void add(self, Py_ssize_t i, double variance) noexcept
    cdef void carry(self, double r, Py_ssize_t j, double[:, ::1] out) noexcept
    cdef void fuse(self, Mixture found, Channel c, Py_ssize_t j, double dt, double w, double scale,
                   double dv, double da, double doubt, double[:, ::1] out) noexcept
    cdef bint clear(self, Channel c, long long samples, double[:, ::1] out) noexcept
