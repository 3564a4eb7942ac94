# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from ..core.cdr cimport JointStateLayout


@cython.final
cdef class JointStateDecoder:
    cdef object _foreign, _foreign_names
    cdef readonly list _layouts

    @cython.locals(layout=_Layout)
    cpdef object decode(self, bytes data)


@cython.final
cdef class _Layout:
    cdef readonly tuple names
    cdef JointStateLayout _numbers

    cdef object read(self, bytes data)
