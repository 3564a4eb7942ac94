# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""From the uncertainty of the joints to that of the end effector."""
from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from math import isfinite

import numpy as np

from ..core.covariance import ThroughJacobian
from ..screws.se3 import Array


def through_jacobian(jacobian: Sequence[float] | Array, variances: Sequence[float],
                     together: Sequence[Sequence[float]] = (), made: Sequence[float] = (),
                     ) -> list[float]:
    """
    Return the covariance of a vector, of joints that err independently but for a part.

    ``J (diag(variances - t^2) + t t^T) J^T`` for each t together, for a twist from the variances
    of joint velocities, and to leading order for an acceleration from those of joint
    accelerations: what the errors of position and velocity add is smaller by the time the motion
    takes to change. The exception is an instant that is not known: it changes J as much as the
    rates.

    Numbers are row by row, angular rows first: the Jacobian d twist / d qd or any rows of it, and
    the covariance, all zero, which means "not known" in ROS messages, if a variance is NaN, not
    known. Together: deviations, part of these variances, that all joints have at once, by how
    much their rates change where the instant is later, or the clock faster, by its standard
    deviation. Made: what the first of these makes of the vector, where J changes too; default: J
    times it.

    Examples
    --------
    >>> through_jacobian([0, 0, 1, 0, 2, 0], [0.25])[28:30]    # of v_y: with itself, with v_z
    [1.0, 0.0]
    >>> through_jacobian([0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0], [1.0, 1.0], [[1.0, -1.0]])[21]
    0.0

    """
    numbers = jacobian.ravel().tolist() if isinstance(jacobian, np.ndarray) else jacobian
    n = len(variances)
    found = _of_shape(len(numbers) // n, n).covariance(numbers, variances, together, made)
    # The sum is finite if all of them are.
    return found if isfinite(sum(found)) else [0.0] * len(found)


@cache
def _of_shape(rows: int, n: int) -> ThroughJacobian:
    return ThroughJacobian(rows, n)
