# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from .group_motion cimport Motion
from .joint_groups cimport JointGroup, JointGroups, Reading
from .kinematics cimport Kinematics, State
from .stream_watch cimport StreamWatch


@cython.final
cdef class RobotPipeline:
    cdef dict __dict__
    cdef public object account
    cdef object _offset_ns, _synchronizer
    cdef dict _motions, _watches
    cdef JointGroups _groups
    cdef Kinematics _kinematics

    @cython.locals(reading=Reading, group=JointGroup, watch=StreamWatch, kinematics=Kinematics)
    cpdef object take(self, object sample)
