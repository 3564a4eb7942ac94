# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joint samples in, joint motion out: position, velocity, acceleration, jerk."""

from .estimator import FixedKalmanFilter, MotionEstimator
from .factory import ESTIMATORS, make_estimator
from .finite_differences import FiniteDifferences
from .guarded_estimator import GuardedEstimator
from .joint_motion import JointMotion, RateEstimator
from .savitzky_golay import SavitzkyGolay
from .smoother import smooth, SmoothedMotion

__all__ = [
    'ESTIMATORS', 'FiniteDifferences', 'FixedKalmanFilter', 'GuardedEstimator', 'JointMotion',
    'MotionEstimator', 'RateEstimator', 'SavitzkyGolay', 'SmoothedMotion',
    'make_estimator', 'smooth',
]
