# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython


@cython.final
cdef class JointGroup:
    cdef readonly object columns
    cdef readonly bint complete
    cdef public long messages
    cdef long _messages_before
    cdef double _last, _silence


@cython.final
cdef class NameLayout:
    cdef readonly JointGroup group
    cdef readonly Py_ssize_t length
    cdef object _entries
    cdef bint _as_it_is

    cdef object select(self, object values)


@cython.final
cdef class Reading:
    cdef public JointGroup group
    cdef public object stamp_ns, position, velocity


@cython.final
cdef class JointGroups:
    cdef dict __dict__
    cdef readonly dict _layouts

    @cython.locals(layout=NameLayout)
    cpdef object read(self, object sample)
