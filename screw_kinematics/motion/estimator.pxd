# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from .admission cimport Admission
from .device_clock cimport DeviceClock, Placed
from .joint_estimator cimport JointEstimator
from .joint_motion cimport JointMotion
from ..core.bank cimport Bank

cdef double LONGEST_AGE, PERIODS, ONWARD, SHORTEST, PAUSE, JUMPS, RECENT
cdef long SETTLED, MOST_AT_ONCE


cdef class MotionEstimator(JointEstimator):
    cdef public object velocity
    cdef public bint covariance_wanted
    cdef public long runs
    cdef public DeviceClock _clock
    cdef public Bank _bank
    cdef bint _trusted, _regularise
    cdef double _settled, _shift, _back, _jumps

    @cython.locals(own=double, last=double, bank=Bank, period=double, before=double,
                   passed=double, ticks=double)
    cdef double _unset(self, double stamp, object position) except? -1e300
    @cython.locals(admission=Admission, clock=DeviceClock, bank=Bank, placed=Placed, own=double)
    cpdef object place(self, double stamp, object position, object velocity=*, object known=*)
    @cython.locals(bank=Bank, wanted=bint, early=bint, placed=Placed, beyond=double)
    cpdef object _take(self, double stamp, object position, object velocity)
