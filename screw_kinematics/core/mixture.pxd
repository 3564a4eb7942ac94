# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from .channel cimport Channel
from .gains cimport Gains
from .steps cimport Steps

cdef double TIME_UNIT


@cython.final
cdef class Mixture:
    cdef Py_ssize_t m
    cdef bint delayed
    cdef int what
    cdef Gains gains
    cdef Steps steps
    cdef Channel channel
    cdef double[:, ::1] states      # of the filters, or of one signal's, (4, M)
    cdef double[:, ::1] p           # covariances: after the latest step, or smoothed
    # What `look` has found: how far the instant is beyond the states, in TIME_UNIT; the column of
    # the signal's first one; the first of the rows of their covariances.
    cdef double r
    cdef Py_ssize_t first
    cdef Py_ssize_t top
    # What `mix` has found.
    cdef double[::1] mean           # state, scaled
    cdef double variance            # of the acceleration
    cdef double wider               # how far wider filters are from it

    cdef void look(self, Py_ssize_t j, long long i, double at, double time,
                   bint whole) noexcept
    cdef void mix(self, Py_ssize_t j, double period) noexcept
