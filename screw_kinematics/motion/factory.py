# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Estimators by name, as a parameter file selects them."""

from __future__ import annotations

from typing import Any

from .estimator import FixedKalmanFilter, MotionEstimator
from .finite_differences import FiniteDifferences
from .guarded_estimator import GuardedEstimator
from .savitzky_golay import SavitzkyGolay
from ..errors import UnknownNameError

ESTIMATORS: dict[str, type[GuardedEstimator]] = {
    'bank': MotionEstimator,
    'kalman': FixedKalmanFilter,
    'savitzky_golay': SavitzkyGolay,
    'finite_difference': FiniteDifferences,
}


def make_estimator(kind: str, n_joints: int, **settings: Any) -> GuardedEstimator:
    """
    Return a new estimator.

    Parameters
    ----------
    kind:
        ``'bank'`` (`MotionEstimator`), ``'kalman'`` (`FixedKalmanFilter`), ``'savitzky_golay'``
        or ``'finite_difference'``.
    n_joints:
        Number of joints.
    **settings:
        Keyword arguments of that class.

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
