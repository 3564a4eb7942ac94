# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from .group_motion cimport Motion
from .kinematics cimport State
from ..messages.stamped cimport StampedEncoder
from ..motion.clock_error cimport ClockError


@cython.final
cdef class JointColumns:
    cdef readonly bint all
    cdef bint _moving_base
    cdef object _columns
    cdef Py_ssize_t _count

    @cython.locals(start=Py_ssize_t, column=Py_ssize_t)
    cpdef object select(self, object row, long derivative)
    @cython.locals(motion=Motion, error=ClockError, rate=double)
    cpdef list covariance(self, State state, long derivative, object jacobian,
                          object rates=*)


@cython.final
cdef class TwistRate:
    cdef object _twist, _accel
    cdef double _swept

    cpdef list of(self, object values)


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
cdef class CovarianceWriter:
    cdef StampedEncoder _encoder
    cdef object _at, _jacobian
    cdef Py_ssize_t _order
    cdef JointColumns _joints
    cdef TwistRate _rate

    cpdef bytes encode(self, State state)


@cython.final
cdef class JointWriter:
    cdef StampedEncoder _encoder
    cdef object _moving, _joints
    cdef long _arrays
    cdef bint _plain

    cpdef bytes encode(self, State state)
