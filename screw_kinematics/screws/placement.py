# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Poses from the numbers of a description: translation with roll, pitch and yaw, DH rows.

Quarter turns come out exact. A file's pi / 2 has a cosine of 6e-17 in floating point,
which is below the rounding of the angle itself; as an exact zero it lets the traced
program drop every product with it.
"""
from __future__ import annotations

import math
from typing import Any

import numpy as np

from .se3 import Array

_ROUNDING = 4 * np.finfo(float).eps


def pose(rotation: Any = None, translation: Any = (0.0, 0.0, 0.0)) -> Array:
    """
    Return the homogeneous matrix of a rotation and a translation.

    Parameters
    ----------
    rotation : array, shape (3, 3), optional
        Default: none.
    translation : array, shape (3,)
        [m]

    Returns
    -------
    array, shape (4, 4)

    Examples
    --------
    >>> pose(translation=(1, 2, 3))[:3, 3]
    array([1., 2., 3.])

    """
    T = np.eye(4)
    if rotation is not None:
        T[:3, :3] = rotation
    T[:3, 3] = translation
    return T


def turn(axis: str, angle: float) -> Array:
    """
    Return the rotation about a coordinate axis, exact for quarter turns.

    Parameters
    ----------
    axis : {'x', 'y', 'z'}
        Which one.
    angle : float
        [rad]

    Returns
    -------
    array, shape (3, 3)

    Examples
    --------
    >>> turn('z', math.pi / 2)
    array([[ 0., -1.,  0.],
           [ 1.,  0.,  0.],
           [ 0.,  0.,  1.]])

    """
    c, s = (0.0 if abs(x) < _ROUNDING else x for x in (math.cos(angle), math.sin(angle)))
    first, second = {'x': (1, 2), 'y': (2, 0), 'z': (0, 1)}[axis]
    R = np.eye(3)
    R[first, first] = R[second, second] = c
    R[second, first] = s
    R[first, second] = 0.0 - s      # no negative zero
    return R


def rotation_rpy(roll: float, pitch: float, yaw: float) -> Array:
    """
    Return the rotation of roll, pitch, yaw about the fixed axes x, y, z, in this order.

    Parameters
    ----------
    roll, pitch, yaw : float
        [rad]

    Returns
    -------
    array, shape (3, 3)

    References
    ----------
    URDF specification, element ``origin``.

    Examples
    --------
    >>> rotation_rpy(0.0, 0.0, math.pi)[0]
    array([-1.,  0.,  0.])

    """
    return turn('z', yaw) @ turn('y', pitch) @ turn('x', roll)
