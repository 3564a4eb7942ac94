# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Estimators by name, as a parameter file selects them."""

from __future__ import annotations

from typing import Any

from .baselines import FiniteDifferences, FixedKalmanFilter, SavitzkyGolay
from .estimator import MotionEstimator
from .joint_estimator import JointEstimator
from ..errors import UnknownNameError

ESTIMATORS: dict[str, type[JointEstimator]] = {
    'bank': MotionEstimator,
    'kalman': FixedKalmanFilter,
    'savitzky_golay': SavitzkyGolay,
    'finite_difference': FiniteDifferences,
}


def make_estimator(kind: str, n_joints: int, **settings: Any) -> JointEstimator:
    """
    Return a new estimator.

    Parameters
    ----------
    kind : str
        ``'bank'`` (`MotionEstimator`), ``'kalman'`` (`FixedKalmanFilter`), ``'savitzky_golay'``
        or ``'finite_difference'``.
    n_joints : int
        Number of joints.
    **settings : Any
        Keyword arguments of that class.

    Returns
    -------
    JointEstimator
        Of that class.

    Raises
    ------
    UnknownNameError
        If there is no such kind.

    Examples
    --------
    >>> make_estimator('bank', 7, delay=0.02).delay
    0.02

    """
    try:
        estimator = ESTIMATORS[kind]
    except KeyError:
        raise UnknownNameError('estimator', kind, ESTIMATORS) from None
    return estimator(n_joints, **settings)
