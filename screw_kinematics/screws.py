# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Unit screws from axis, point and pitch.

References
----------
The paper, section 2.2.

"""
from __future__ import annotations

from typing import Any

import numpy as np

from .se3 import Array, cross


def unit_screw(axis: Array, point: Array, pitch: Any = 0) -> Array:
    """
    Return the unit screw ``(s ; p x s + h s)`` of zero or finite pitch.

    Parameters
    ----------
    axis : array, shape (..., 3)
        Unit direction s of the screw axis.
    point : array, shape (..., 3)
        Vector p from the pole to any point of the axis [m].
    pitch : array, shape (...)
        Pitch h [m/rad]; 0 for a revolute joint.

    Returns
    -------
    array, shape (..., 6)

    References
    ----------
    The paper, section 2.2.

    Examples
    --------
    >>> unit_screw(np.array([0, 0, 1]), np.array([1, 0, 0]))
    array([ 0,  0,  1,  0, -1,  0])

    """
    axis, point = np.asarray(axis), np.asarray(point)
    moment = cross(point, axis) + np.asarray(pitch)[..., None] * axis
    return np.concatenate(np.broadcast_arrays(axis, moment), axis=-1)


def prismatic_screw(axis: Array) -> Array:
    """
    Return the unit screw ``(0 ; s)`` of infinite pitch.

    Parameters
    ----------
    axis : array, shape (..., 3)
        Unit direction s.

    Returns
    -------
    array, shape (..., 6)

    Examples
    --------
    >>> prismatic_screw(np.array([0, 1, 0]))
    array([0, 0, 0, 0, 1, 0])

    """
    axis = np.asarray(axis)
    return np.concatenate([0 * axis, axis], axis=-1)
