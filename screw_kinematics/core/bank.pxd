# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from .channel cimport Channel
from .gains cimport Gains
from .mixture cimport Mixture
from .readings cimport fill
from .spread cimport Spread
from .steps cimport Pace, Steps
from .travel cimport Travel
from .velocity_trust cimport Fading, VelocityTrust

cdef double DENSEST, FINEST, EVIDENCE, NOTHING, SPARSE, TIME_UNIT, WINDOW

cdef list in_a_row(double[:, ::1] t, Py_ssize_t first, Py_ssize_t end)


@cython.final
cdef class Bank:
    cdef Py_ssize_t n, m
    cdef double wide, delay
    cdef bint delayed
    cdef Gains gains
    cdef Channel position, velocity
    cdef list trust                 # of each joint's velocity
    cdef Fading keep
    cdef Steps steps
    cdef Pace pace
    cdef Mixture of_position, of_velocity
    cdef Spread spread
    cdef Travel travelled
    cdef double[::1] prior, scale
    cdef double[::1] lsum           # forgetful means of what filters pay for their variances,
    cdef double[::1] price          # and that as a factor
    cdef double[:, ::1] now         # weighted state after the latest sample, (4, n), SI
    cdef double[:, ::1] out         # what was read: 4 rows of state, 10 of covariance, SI
    cdef double[::1] at, speed      # of the sample at hand
    cdef double[::1] instead        # velocities for those that are not measured
    # The run.
    cdef readonly long long count   # samples after the first
    cdef double time, dt, rate
    cdef long long steady           # steps since the gains changed
    cdef double span                # samples in the means of innovations
    cdef double evidence, reach     # see `Channel`
    cdef readonly bint with_velocity    # whether velocities come with the positions
    cdef int missing

    cpdef void measure(self, double time, object position, object velocity, bint measured,
                       double rate) except *
    cpdef int read(self, double at, bint fresh, double rate, bint spread) noexcept
    cpdef list values(self)
    cpdef list variances(self)
    cdef VelocityTrust trust_in(self, Py_ssize_t j)
    cdef void handicap(self, double share) noexcept
    cdef void prepare(self, Channel c, double share, double possible, double half,
                      Py_ssize_t slot) noexcept
    cdef void fuse(self, VelocityTrust trust, Py_ssize_t j, double at, bint fresh,
                   bint spread) noexcept
