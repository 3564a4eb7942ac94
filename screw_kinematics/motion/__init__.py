# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joint samples in, joint motion out: position, velocity, acceleration, jerk."""

from .baselines import FiniteDifferences, FixedKalmanFilter, SavitzkyGolay
from .estimator import MotionEstimator
from .factory import ESTIMATORS, make_estimator
from .joint_estimator import JointEstimator
from .joint_motion import JointMotion
from .smoother import smooth, SmoothedMotion

__all__ = [
    'ESTIMATORS', 'FiniteDifferences', 'FixedKalmanFilter', 'JointEstimator', 'JointMotion',
    'MotionEstimator', 'SavitzkyGolay', 'SmoothedMotion', 'make_estimator', 'smooth',
]
