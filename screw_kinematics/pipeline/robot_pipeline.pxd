# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from .group_motion cimport Motion
from .joint_groups cimport JointGroups, Reading
from .kinematics cimport Kinematics, State


@cython.final
cdef class RobotPipeline:
    cdef dict __dict__
    cdef public object account
    cdef object _offset_ns, _synchronizer, _watches
    cdef dict _motions
    cdef JointGroups _groups
    cdef Kinematics _kinematics

    @cython.locals(kinematics=Kinematics)
    cpdef object take(self, object sample)
