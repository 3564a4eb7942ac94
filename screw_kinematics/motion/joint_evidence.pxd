# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from ..core.period_search cimport PeriodSearch
from ..core.readings cimport Readings

cdef double ADOPT, STEPS
cdef long WINDOW, LONG_WINDOW


@cython.final
cdef class JointEvidence:
    cdef Readings _readings
    cdef PeriodSearch _search
    cdef object _share
    cdef double _tick, _deviation, _wait, _patience
    cdef long _new, _rest

    cpdef start(self, JointEvidence known=*)
    cpdef pause(self)
    cpdef advance(self, double d, double step)
    cpdef add(self, double stamp, double time, object position)
    cpdef bint due(self) except -1
