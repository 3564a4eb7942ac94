# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Orientations as people and messages write them."""
from __future__ import annotations

import numpy as np

from .se3 import Array


def rotation_from_quaternion(quaternion: Array) -> Array:
    """
    Return the rotation matrix of a unit quaternion.

    Parameters
    ----------
    quaternion : array, shape (..., 4)
        x, y, z, w, as in messages.

    Returns
    -------
    array, shape (..., 3, 3)

    Examples
    --------
    >>> rotation_from_quaternion(np.array([0, 0, 1, 0])).tolist()
    [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]

    """
    x, y, z, w = np.moveaxis(np.asarray(quaternion), -1, 0)
    return np.stack([
        np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], -1),
        np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], -1),
        np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], -1),
    ], axis=-2)


def roll_pitch_yaw(rotation: Array) -> Array:
    """
    Return the angles about the fixed axes x, y, z, as URDF has them.

    Parameters
    ----------
    rotation : array, shape (..., 3, 3)
        Rotation matrices.

    Returns
    -------
    array, shape (..., 3)
        In rad; roll and yaw are not unique where the pitch is a quarter turn.

    Examples
    --------
    >>> float(roll_pitch_yaw(np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]))[2].round(4))
    1.5708

    """
    r = np.asarray(rotation)
    return np.stack([
        np.arctan2(r[..., 2, 1], r[..., 2, 2]),
        np.arctan2(-r[..., 2, 0], np.hypot(r[..., 0, 0], r[..., 1, 0])),
        np.arctan2(r[..., 1, 0], r[..., 0, 0])], axis=-1)
