# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""From the uncertainty of the joints to that of the end effector."""
from __future__ import annotations

from collections.abc import Sequence

import numpy as np

__all__ = ['through_jacobian']


def through_jacobian(jacobian: Sequence[float], variances: Sequence[float]) -> list[float]:
    """
    Return the covariance of a six-vector, of joints that err independently.

    ``J diag(variances) J^T``, for a twist from the variances of joint velocities, and to
    leading order for an acceleration from those of joint accelerations: what the errors of
    position and velocity add is smaller by the time the motion takes to change.

    Parameters
    ----------
    jacobian : sequence of 6 * n float
        d twist / d qd, row by row, angular rows first.
    variances : sequence of n float
        Variances of the joints' rates or accelerations; NaN where not known.

    Returns
    -------
    list of 36 float
        Row by row, angular first. All zero, which means "not known" in ROS messages, if the
        variance of a joint is not known.

    Examples
    --------
    >>> through_jacobian([0, 0, 1, 0, 2, 0], [0.25])[28:30]    # of v_y: with itself, with v_z
    [1.0, 0.0]

    """
    values = np.array(variances)
    J = np.array(jacobian).reshape(6, -1)    # noqa: N806
    covariance = (J * values).dot(J.T)
    if not np.all(np.isfinite(covariance)):
        return [0.0] * 36
    out: list[float] = covariance.ravel().tolist()
    return out
