# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from .joint_groups cimport Reading
from ..motion.joint_estimator cimport JointEstimator
from ..motion.joint_motion cimport JointMotion


@cython.final
cdef class Motion:
    cdef public object stamp_ns, values, variances, clock_error, estimate


cdef class EstimatedMotion:
    cdef public JointEstimator estimator
    cdef long _order
    cdef bint _covariance

    cpdef object update(self, Reading reading)
    @cython.locals(estimate=JointMotion)
    cdef object _estimate(self, Reading reading, object velocity)


@cython.final
cdef class PositionOnlyMotion(EstimatedMotion):
    pass


@cython.final
cdef class MeasuredVelocityMotion(EstimatedMotion):
    pass
