# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from .gains cimport Gains

cdef double EVIDENCE, LEAST, NOTHING


@cython.final
cdef class Signal:
    cdef double last            # latest sample
    cdef double quantum         # the encoder's step, and how far that may be off; share of
    cdef double vague           # changes that are multiples of it, and their number
    cdef double fit
    cdef double changes
    cdef double parted          # way of the velocity less step of the position; the same since the
    cdef double since           # first of those that wait
    cdef double pending         # deviation of the sample that waits
    cdef int waiting            # samples that wait
    cdef int odd                # those before the latest that it has shown to be odd
    cdef double envelope        # usual deviation
    cdef double noise
    cdef double least           # what mean squares count at least: noise of the encoder's steps
    cdef bint scores            # whether the latest sample tells of the filters
    cdef double fresh           # samples that scores are worth at most since the motion jumped
    cdef double limit           # when the first of those that wait came: the limit, whether it was
    cdef bint taken             # taken, the step to it; the state without it
    cdef double step
    cdef double s0, s1, s2, s3

    cdef void start(self, double z) noexcept
    cdef void follow_quantum(self, double z) noexcept
    cdef double step_of_encoder(self) noexcept
    cdef double rounding(self) noexcept


@cython.final
cdef class Channel:
    cdef Py_ssize_t n, m
    cdef bint delayed
    cdef Gains gains
    cdef readonly list signals
    cdef double[::1] price      # by how much each filter's mean squares count more
    cdef double[:, ::1] x       # scaled states, (4, n M)
    cdef double[::1] mean       # forgetful mean squares of the innovations over variances
    cdef double[::1] before     # the same before the sample that waits
    cdef double[::1] weight
    cdef Py_ssize_t[::1] low    # of each signal the first filter that has weight,
    cdef Py_ssize_t[::1] high   # and the one after the last
    cdef double[::1] error      # innovations of the latest sample of one signal
    cdef double[:, ::1] excess  # what wider filters show of errors, (3, n M)
    cdef double told            # how often,
    cdef double lately          # and what the latest time counts
    cdef double[:, ::1] tail    # what a pause has left unknown, (3, n)
    cdef bint shaken            # whether there was a pause just now,
    cdef double paused          # a step from which on it is one [s]
    cdef double[:, ::1] states  # predicted states of the latest steps, (steps, 4 n M)
    cdef double[:, ::1] errors  # innovations of the latest steps, (steps, n M)
    # The sample at hand.
    cdef double r               # step since the one before, in TIME_UNIT
    cdef double share           # what it counts in forgetful means,
    cdef double evidence        # the power of mean squares that is their likelihood,
    cdef double reach           # and by how much they are larger where that is nothing
    cdef double possible        # a deviation that a joint can make,
    cdef double plausible       # and that need not wait, where samples are far apart
    cdef double half            # half the step if these are velocities, else 0 [s]
    cdef bint settling          # whether none waits yet
    cdef bint determined        # whether it tells of the filters, not of the state alone
    cdef Py_ssize_t slot        # where it is remembered

    cdef Signal signal(self, Py_ssize_t j)
    cdef void start(self, double[::1] z) noexcept
    cdef void advance(self, double[::1] z, double[::1] instead) noexcept
    cdef void predict(self) noexcept
    cdef void judge(self, Signal u, Py_ssize_t j, double at, double instead) noexcept
    cdef void remember(self, Py_ssize_t j) noexcept
    cdef void update(self, Signal u, Py_ssize_t j) noexcept
    cdef bint admit(self, Signal u, Py_ssize_t first, double deviation, double limit,
                    bint same) noexcept
    cdef bint confirmed(self, Signal u, double deviation) noexcept
    cdef bint decide(self, Signal u, Py_ssize_t first, double at) noexcept
    cdef void correct(self, Py_ssize_t first, double change, int waiting) noexcept
    cdef void weigh(self, Signal u, Py_ssize_t j) noexcept
    cdef void average(self, double[::1] scale, double[:, ::1] out) noexcept
