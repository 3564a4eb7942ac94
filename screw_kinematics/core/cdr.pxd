# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cdef unsigned int _count(bytes data, Py_ssize_t at) noexcept
cdef tuple _reals(bytes data, Py_ssize_t at, Py_ssize_t count)


cdef class JointStateLayout:
    cdef bytes example, mask
    cdef Py_ssize_t size, end, position_at, positions, velocity_at, velocities
    cdef Py_ssize_t velocity_count_at, effort_count_at

    cpdef tuple read(self, bytes data)
    cdef bint fits(self, bytes data) noexcept


cdef class StampedMessage:
    cdef bytes example
    cdef Py_ssize_t[::1] places, order
    cdef Py_ssize_t count, needed

    cpdef bytes write(self, long long stamp_ns, object values)
