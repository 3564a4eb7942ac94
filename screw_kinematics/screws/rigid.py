# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Poses and rotations that come from outside: checks, and poses as rows of numbers.

A rotation R is refused if an entry of ``R^T R`` is off by more than a tolerance, or if it
mirrors; a pose also if its last row is not (0, 0, 0, 1). Arrays of symbols or traced scalars
are taken as they are, and entries that are NaN mean "not known" where that is allowed.
"""
from __future__ import annotations

from typing import Any

import numpy as np

from .vectors import Array, checked_array, cross, dot
from ..errors import InvalidValueError

__all__ = ['GEOMETRY', 'TOLERANCE', 'checked_pose', 'checked_rotation', 'pose_from_row',
           'rigid_displacement', 'row_of_pose']

TOLERANCE = 1e-6
"""Of poses and rotations handed to functions: single precision passes."""
GEOMETRY = 1e-9
"""Of poses that a robot is built with: what is off there is off in every result."""


def checked_rotation(name: str, rotation: Any) -> Array:
    """
    Return a rotation as an array, after checking that it is one.

    Parameters
    ----------
    name : str
        What it is, for messages.
    rotation : array, shape (..., 3, 3)
        Floats, symbols or traced scalars.

    Returns
    -------
    array, shape (..., 3, 3)
        As it was given.

    Raises
    ------
    ShapeError, InvalidValueError
        It is no rotation within 1e-6.

    Examples
    --------
    >>> checked_rotation('R', np.diag([1, -1, -1])).shape
    (3, 3)

    """
    R = checked_array(name, rotation, (..., 3, 3))    # noqa: N806
    if R.dtype != object:
        wrong = _not_a_rotation(R, TOLERANCE)
        if np.any(wrong):
            raise InvalidValueError(
                f'{name} is no rotation: R^T R must be the identity within {TOLERANCE:g}, the '
                f'determinant positive, got {R[wrong][0].tolist()}')
    return R


def checked_pose(name: str, T: Any, tolerance: float = TOLERANCE) -> Array:    # noqa: N803
    """
    Return a pose as an array, after checking that it is a rigid displacement.

    Parameters
    ----------
    name : str
        What it is, for messages.
    T : array, shape (..., 4, 4)
        Floats [m], symbols or traced scalars.
    tolerance : float
        Largest error of an entry of ``R^T R``, and of the last row.

    Returns
    -------
    array, shape (..., 4, 4)
        As it was given.

    Raises
    ------
    ShapeError, InvalidValueError
        It is no rigid displacement.

    Examples
    --------
    >>> checked_pose('T', np.eye(4)).shape
    (4, 4)

    """
    T = checked_array(name, T, (..., 4, 4))    # noqa: N806
    if T.dtype != object:
        last = np.abs(T[..., 3, :] - (0, 0, 0, 1)).max(axis=-1) > tolerance
        wrong = last | _not_a_rotation(T[..., :3, :3], tolerance)
        if np.any(wrong):
            raise InvalidValueError(
                f'{name} is no rigid displacement: the upper left 3x3 block must be a rotation '
                f'within {tolerance:g} and the last row (0, 0, 0, 1), '
                f'got {T[wrong][0].tolist()}')
    return T


def rigid_displacement(name: str, T: Any = None) -> Array:    # noqa: N803
    """
    Return a read-only copy of a pose that a robot is built with, after checking it.

    Parameters
    ----------
    name : str
        What it is, for messages.
    T : array, shape (4, 4), optional
        Pose [m]; by default the identity, in integers, which leave symbols exact. Arrays
        of symbols are taken as they are.

    Returns
    -------
    array, shape (4, 4)
        A copy that cannot be written to.

    Raises
    ------
    ShapeError, InvalidValueError
        The pose is no rigid displacement within 1e-9.

    Examples
    --------
    >>> rigid_displacement('T', np.eye(4)).flags.writeable
    False

    """
    T = np.array(checked_array(name, np.eye(4, dtype=int) if T is None else T,    # noqa: N806
                               (4, 4)))
    if T.dtype != object and not np.all(np.isfinite(T)):
        raise InvalidValueError(f'{name} is no rigid displacement: it must be finite, '
                                f'got {T.tolist()}')
    T = checked_pose(name, T, GEOMETRY)    # noqa: N806
    T.setflags(write=False)
    return T


def pose_from_row(row: Any) -> Array:
    """
    Return the pose of a row as compiled programs and tables have it.

    Parameters
    ----------
    row : array, shape (..., 12)
        Position [m], then the rotation matrix, row by row.

    Returns
    -------
    array, shape (..., 4, 4)
        Homogeneous matrices [m].

    Raises
    ------
    ShapeError, InvalidValueError
        The last axis is not 12 long.

    Examples
    --------
    >>> pose_from_row([1, 2, 3, 1, 0, 0, 0, 1, 0, 0, 0, 1])[:3, 3]
    array([1, 2, 3])

    """
    row = checked_array('row', row, (..., 12))
    T = np.zeros(row.shape[:-1] + (4, 4), dtype=row.dtype)    # noqa: N806
    T[..., :3, 3] = row[..., :3]
    T[..., :3, :3] = row[..., 3:].reshape(row.shape[:-1] + (3, 3))
    T[..., 3, 3] = 1
    return T


def row_of_pose(T: Any) -> Array:    # noqa: N803
    """
    Return a pose as a row of numbers: position [m], then the rotation matrix, row by row.

    Parameters
    ----------
    T : array, shape (..., 4, 4)
        Pose [m]; it is not checked to be a rigid displacement.

    Returns
    -------
    array, shape (..., 12)
        Position, then rotation.

    Raises
    ------
    ShapeError, InvalidValueError
        The last axes are not 4 x 4.

    Examples
    --------
    >>> row_of_pose(np.eye(4))[3:6]
    array([1., 0., 0.])

    """
    T = checked_array('T', T, (..., 4, 4))    # noqa: N806
    R = T[..., :3, :3].reshape(T.shape[:-2] + (9,))    # noqa: N806
    return np.concatenate([T[..., :3, 3], R], axis=-1)


def _not_a_rotation(R: Array, tolerance: float) -> Array:    # noqa: N803
    """Return which matrices are no rotations, shape (...); one with NaN is not refused."""
    with np.errstate(all='ignore'):
        off = np.abs(np.swapaxes(R, -1, -2) @ R - np.eye(3)).max(axis=(-1, -2))
        mirrored = dot(R[..., 0], cross(R[..., 1], R[..., 2])) < 0
        return np.asarray((off > tolerance) | mirrored)
