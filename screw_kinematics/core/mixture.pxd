# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
from .channel cimport Channel
from .gains cimport Gains
from .steps cimport Steps

cdef double TIME_UNIT


cdef class Mixture:
    cdef Py_ssize_t m
    cdef bint delayed
    cdef double known_noise
    cdef Gains gains
    cdef Steps steps
    cdef double[:, ::1] states      # of one signal's filters, (4, M)
    cdef double[:, ::1] work        # (10, 1)
    cdef double[::1] scale
    # What `look` has found: how far the instant is beyond the states, in TIME_UNIT; the first of
    # the rows of their covariances.
    cdef double r
    cdef Py_ssize_t top
    # What `mix` has found.
    cdef double[::1] mean           # state, scaled
    cdef double variance            # of the component asked for
    cdef double level               # of component 0

    cdef void look(self, Channel c, Py_ssize_t j, long long i, double at, double time) noexcept
    cdef void mix(self, Channel c, Py_ssize_t j, int what, double period) noexcept
    cdef void spread(self, Channel c, Py_ssize_t j, double[:, ::1] out) noexcept
