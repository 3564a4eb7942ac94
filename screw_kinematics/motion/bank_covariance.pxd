# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from .clock_error cimport ClockError


@cython.final
cdef class BankCovariance:
    cdef object _triangles, _values
    cdef ClockError _error

    @cython.locals(error=ClockError, triangles=list, values=list, n=Py_ssize_t, k=Py_ssize_t,
                   order=Py_ssize_t, row=Py_ssize_t, onward=double)
    cpdef list variances(self)
