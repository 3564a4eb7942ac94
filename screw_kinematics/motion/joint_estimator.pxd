# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
from .admission cimport Admission
from .joint_motion cimport JointMotion


cdef class JointEstimator:
    cdef dict __dict__
    cdef public long n_joints, min_samples
    cdef public double delay
    cdef public object reason
    cdef public Admission _admission
    cdef object _delay_ns, _epoch_ns

    cpdef object _measured(self, object velocity)
