# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from .kinematics cimport State
from ..messages.stamped cimport StampedEncoder


@cython.final
cdef class SixVectorWriter:
    cdef StampedEncoder _encoder

    cpdef bytes encode(self, State state)


@cython.final
cdef class PoseWriter:
    cdef object _at
    cdef StampedEncoder _encoder

    cpdef bytes encode(self, State state)


@cython.final
cdef class JointWriter:
    cdef StampedEncoder _encoder
    cdef object _moving, _joints
    cdef long _arrays
    cdef bint _plain

    cpdef bytes encode(self, State state)
