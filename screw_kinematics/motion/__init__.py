# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joint samples in, joint motion out: position, velocity, acceleration, jerk."""

from screw_kinematics.motion.estimator import FixedKalmanFilter, MotionEstimator
from screw_kinematics.motion.factory import ESTIMATORS, make_estimator
from screw_kinematics.motion.finite_differences import FiniteDifferences
from screw_kinematics.motion.guarded_estimator import GuardedEstimator
from screw_kinematics.motion.joint_motion import JointMotion, RateEstimator
from screw_kinematics.motion.savitzky_golay import SavitzkyGolay
from screw_kinematics.motion.smoother import smooth, SmoothedMotion

__all__ = [
    'ESTIMATORS', 'FiniteDifferences', 'FixedKalmanFilter', 'GuardedEstimator', 'JointMotion',
    'MotionEstimator', 'RateEstimator', 'SavitzkyGolay', 'SmoothedMotion',
    'make_estimator', 'smooth',
]
