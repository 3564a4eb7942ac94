# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from .group_motion cimport Motion


@cython.final
cdef class State:
    # In the order of the fields.
    cdef public object stamp_ns, values
    cdef public Motion motion
    cdef public long order
    cdef public object base
    cdef public bint without_base


@cython.final
cdef class Kinematics:
    cdef readonly object program
    cdef object _evaluate
    cdef readonly bint covariance, moving_base, standing_base
    cdef readonly long told, order
    cdef Py_ssize_t _dof, _inputs

    @cython.locals(order=Py_ssize_t, total=double, value=double)
    cpdef object evaluate(self, Motion motion, object base=*)
