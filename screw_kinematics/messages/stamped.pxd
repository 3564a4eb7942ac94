# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
from ..core.cdr cimport StampedMessage


cdef class StampedEncoder:
    cdef StampedMessage _message
