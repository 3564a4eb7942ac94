# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from .readings cimport fill


@cython.final
cdef class ThroughJacobian:
    cdef Py_ssize_t rows, n
    cdef double[::1] jacobian, variance, common, made, out

    cpdef list covariance(self, object jacobian, object variances, object together,
                          object made=*)
    cdef void add(self) noexcept
    cdef void carry(self) noexcept
    cdef void add_common(self) noexcept
