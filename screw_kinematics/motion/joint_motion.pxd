# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython


@cython.final
cdef class JointMotion:
    cdef readonly double stamp
    cdef public object stamp_ns
    cdef public object clock_error
    cdef readonly object values
    cdef object _covariance, _state
