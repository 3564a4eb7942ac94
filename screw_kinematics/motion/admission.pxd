# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

cdef double LARGEST, TURN, AT_ONCE
cdef long BORNE, WAITED, BEGUN


@cython.final
cdef class Admission:
    cdef dict __dict__
    cdef public long n_joints, patience, back_patience, at_once
    cdef public double max_gap, max_back, max_jump, longest_gap, stamp, period
    cdef public list max_velocity
    cdef public object wraps, refusals, restarts, position
    cdef double _slowest, _shortest
    cdef long _backward, _implausible, _borne, _apart

    @cython.locals(dt=double, shortest=double, passed=double)
    cpdef object admit(self, double stamp, object position)
    cpdef object refuse(self, object reason)
    cdef bint _had_waited(self, double dt)
