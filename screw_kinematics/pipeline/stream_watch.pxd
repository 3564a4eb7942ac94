# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from .joint_groups cimport Reading

cdef double FORGET
cdef long EVERY, PERIODS
cdef long long PAUSE, JUMPED


@cython.final
cdef class StreamWatch:
    cdef dict __dict__
    cdef public long lost
    cdef long _count
    cdef long long _stamp, _period, _pause
    cdef list _last, _there_and_back

    @cython.locals(passed=cython.longlong)
    cpdef object update(self, Reading reading)
    @cython.locals(hits=list, k=cython.Py_ssize_t, a=double, b=double, c=double)
    cdef _look(self, Reading reading)
