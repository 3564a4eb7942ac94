# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Rotations and poses in the forms that people, files and messages write them.

Axis and angle, rotation vectors, roll-pitch-yaw, unit quaternions (x, y, z, w, as in ROS).
A matrix maps the coordinates of a vector to those of the turned one; all may be batches, the
axes of their own last. What is no rotation within 1e-6 is an InvalidValueError.
Quarter turns from a description come out exact: a file's pi / 2 has
a cosine of 6e-17 in floating point, which is below the rounding of the angle itself; as an
exact zero it lets the traced program drop every product with it.
"""
from __future__ import annotations

from collections.abc import Sequence
import math
from typing import Any

import numpy as np

from .rigid import checked_rotation
from .vectors import Array, cos, sin, skew

_ROUNDING = 4 * np.finfo(float).eps
_IDENTITY = np.eye(3, dtype=int)


def rotation_about(axis: Array, angle: Any) -> Array:
    """
    Return the rotation matrix about a unit axis (Rodrigues), for any scalar type.

    Parameters
    ----------
    axis : array, shape (..., 3)
        Unit vector.
    angle : array, shape (...)
        Angle [rad].

    Returns
    -------
    array, shape (..., 3, 3)
        Maps coordinates to those of the turned vector.

    Examples
    --------
    >>> float(rotation_about(np.array([0, 0, 1]), np.pi / 2).round(12)[0, 1])
    -1.0

    """
    axis, angle = np.asarray(axis), np.asarray(angle)
    c, s = np.asarray(cos(angle))[..., None, None], np.asarray(sin(angle))[..., None, None]
    projector = axis[..., :, None] * axis[..., None, :]
    # Written so that constant axes leave no terms such as 1 - (1 - c) in symbolic results.
    return c * (_IDENTITY - projector) + s * skew(axis) + projector


def turn(axis: str, angle: float) -> Array:
    """
    Return the rotation matrix about an axis x, y or z by an angle [rad], exact for quarter turns.

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
    Return the matrix of turns [rad] about the fixed axes x, y, z, in this order, as in URDF.

    Examples
    --------
    >>> rotation_rpy(0.0, 0.0, math.pi)[0]
    array([-1.,  0.,  0.])

    """
    return turn('z', yaw) @ turn('y', pitch) @ turn('x', roll)


def roll_pitch_yaw(rotation: Array) -> Array:
    """
    Return the angles [rad] of matrices about the fixed axes x, y, z, as in URDF.

    Roll and yaw are not unique where the pitch is a quarter turn.

    Examples
    --------
    >>> float(roll_pitch_yaw(np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]))[2].round(4))
    1.5708

    """
    r = checked_rotation('rotation', rotation)
    return np.stack([
        np.arctan2(r[..., 2, 1], r[..., 2, 2]),
        np.arctan2(-r[..., 2, 0], np.hypot(r[..., 0, 0], r[..., 1, 0])),
        np.arctan2(r[..., 1, 0], r[..., 0, 0])], axis=-1)


def rotation_from_quaternion(quaternion: Array) -> Array:
    """
    Return the rotation matrices of quaternions of any length but 0.

    Exact for quarter turns about the coordinate axes.

    Examples
    --------
    >>> rotation_from_quaternion(np.array([0, 0, 1, 1]))
    array([[ 0., -1.,  0.],
           [ 1.,  0.,  0.],
           [ 0.,  0.,  1.]])

    """
    quaternion = np.asarray(quaternion, dtype=float)
    x, y, z, w = np.moveaxis(quaternion, -1, 0)
    # Homogeneous in the quaternion, so that quarter turns need no root of 1/2 and come out exact.
    xx, yy, zz, ww = x * x, y * y, z * z, w * w
    rows = [[ww + xx - yy - zz, 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), ww + yy - xx - zz, 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), ww + zz - xx - yy]]
    squared = np.asarray(xx + yy + zz + ww)[..., None, None]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2) / squared


def quaternion_from_rotation(rotation: Array) -> Array:
    """
    Return the unit quaternions of rotation matrices.

    Of the two that exist, the one with w >= 0.

    References
    ----------
    S. W. Shepperd, "Quaternion from rotation matrix", Journal of Guidance and Control 1(3),
    1978: divide by the largest component, which is at least 1/2.

    Examples
    --------
    >>> quaternion_from_rotation(np.diag([1.0, -1.0, -1.0])).tolist()
    [1.0, 0.0, 0.0, 0.0]

    """
    R = checked_rotation('rotation', rotation).astype(float)
    d = np.diagonal(R, axis1=-2, axis2=-1)
    trace = d.sum(axis=-1)
    # Each row is the quaternion times four times one of its components.
    rows = np.empty(R.shape[:-2] + (4, 4))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        rows[..., i, i] = 1 + 2 * d[..., i] - trace
        both, turned = R[..., i, j] + R[..., j, i], R[..., k, j] - R[..., j, k]
        rows[..., i, j] = rows[..., j, i] = both
        rows[..., i, 3] = rows[..., 3, i] = turned
    rows[..., 3, 3] = 1 + trace
    largest = np.argmax(np.diagonal(rows, axis1=-2, axis2=-1), axis=-1)
    quaternion = np.take_along_axis(rows, largest[..., None, None], axis=-2)[..., 0, :]
    quaternion = quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True)
    return np.where(quaternion[..., 3:] < 0, -quaternion, quaternion) + 0.0


def quaternion_from_row(rotation: Sequence[float]) -> tuple[float, float, float, float]:
    """
    Return the quaternion of one rotation matrix given as nine numbers, without arrays.

    The same as :func:`quaternion_from_rotation`, forty times as fast for a single sample.

    Examples
    --------
    >>> quaternion_from_row([1, 0, 0, 0, -1, 0, 0, 0, -1])
    (1.0, 0.0, 0.0, 0.0)

    """
    xx, xy, xz, yx, yy, yz, zx, zy, zz = rotation
    trace = xx + yy + zz
    if trace >= max(xx, yy, zz):
        x, y, z, w = zy - yz, xz - zx, yx - xy, 1.0 + trace
    elif xx >= yy and xx >= zz:
        x, y, z, w = 1.0 + xx - yy - zz, xy + yx, xz + zx, zy - yz
    elif yy >= zz:
        x, y, z, w = xy + yx, 1.0 - xx + yy - zz, yz + zy, xz - zx
    else:
        x, y, z, w = xz + zx, yz + zy, 1.0 - xx - yy + zz, yx - xy
    scale = 1.0 / math.sqrt(x * x + y * y + z * z + w * w)
    if w < 0.0:
        scale = -scale
    return x * scale, y * scale, z * scale, w * scale


def rotation_vector(rotation: Array) -> Array:
    """
    Return axis times angle, the angle in [0, pi]; accurate at 0, at pi and in between.

    Of ``R1.T @ R2``, its length is how far one orientation is from the other [rad].

    Examples
    --------
    >>> rotation_vector(turn('y', 0.3)).round(12)
    array([0. , 0.3, 0. ])

    """
    quaternion = quaternion_from_rotation(rotation)
    sine = np.linalg.norm(quaternion[..., :3], axis=-1)
    cosine = quaternion[..., 3]
    tiny = sine < 1e-150
    ratio = np.where(tiny, 2, 2 * np.arctan2(sine, cosine) / np.where(tiny, 1, sine))
    return ratio[..., None] * quaternion[..., :3]


def pose(rotation: Any = None, translation: Any = (0.0, 0.0, 0.0)) -> Array:
    """
    Return the homogeneous matrices of rotations (default: none) and translations [m].

    Examples
    --------
    >>> pose(translation=(1, 2, 3))[:3, 3]
    array([1., 2., 3.])

    """
    rotation = np.eye(3) if rotation is None else checked_rotation('rotation', rotation)
    translation = np.asarray(translation)
    batch = np.broadcast_shapes(rotation.shape[:-2], translation.shape[:-1])
    T = np.zeros(batch + (4, 4), dtype=np.result_type(rotation, translation, float))
    T[..., :3, :3], T[..., :3, 3], T[..., 3, 3] = rotation, translation, 1
    return T
