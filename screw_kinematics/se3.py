# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The Lie algebra se(3) on six-vectors.

A six-vector is ``(angular; linear)``, the primal and the dual part of a screw, and has
shape (..., 6). Nothing here casts: all functions run on floats, on batches, and on object
arrays of any scalar type that has ``+`` and ``*`` (symbols, traced expressions).

References
----------
Gallardo-Alvarado et al., "Symbolic Computation of the Lie Algebra se(3) of the Euclidean
Group SE(3)", Mathematics 2024, 12(16), 2538, called "the paper" throughout this package.

"""
from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[Any]]


def _elementwise(name: str) -> Callable[[Any], Any]:
    """Return NumPy's function, extended to scalars that bring a method of that name."""
    numeric = getattr(np, name)

    def apply(x: Any) -> Any:
        x = np.asarray(x)
        if x.dtype != object:
            return numeric(x)
        out = np.empty(x.shape, dtype=object)
        for index, value in np.ndenumerate(x):
            method = getattr(value, name, None)
            if method is not None:
                out[index] = method()
            elif hasattr(value, 'free_symbols'):    # SymPy: functions, not methods
                import sympy
                out[index] = getattr(sympy, name)(value)
            else:
                out[index] = numeric(value)
        return out[()]

    apply.__name__ = name
    apply.__doc__ = f'Return the {name} of each element; floats, SymPy or traced scalars.'
    return apply


sin = _elementwise('sin')
cos = _elementwise('cos')


def cross(a: Array, b: Array) -> Array:
    """
    Return the cross product of three-vectors of any scalar type.

    Parameters
    ----------
    a, b : array, shape (..., 3)
        Factors, in the same axes.

    Returns
    -------
    array, shape (..., 3)

    Examples
    --------
    >>> cross(np.array([1, 0, 0]), np.array([0, 1, 0]))
    array([0, 0, 1])

    """
    a0, a1, a2 = a[..., 0], a[..., 1], a[..., 2]
    b0, b1, b2 = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0], axis=-1)


def dot(a: Array, b: Array) -> Any:
    """
    Return the inner product over the last axis, for any scalar type.

    Examples
    --------
    >>> int(dot(np.array([1, 2, 3]), np.array([4, 5, 6])))
    32

    """
    return (a * b).sum(axis=-1)


def lie_product(x: Array, y: Array) -> Array:
    """
    Return the Lie product (motor product, commutator) of two six-vectors.

    ``[X, Y] = (wx x wy ; wx x vy - wy x vx)``, both about the same pole and in the same
    axes.

    Parameters
    ----------
    x, y : array, shape (..., 6)
        Six-vectors about the same pole, in the same axes.

    Returns
    -------
    array, shape (..., 6)

    References
    ----------
    The paper, section 2.2.

    Examples
    --------
    >>> lie_product(np.array([1, 0, 0, 0, 0, 0]), np.array([0, 1, 0, 0, 0, 0]))
    array([0, 0, 1, 0, 0, 0])

    """
    x, y = np.asarray(x), np.asarray(y)
    wx, vx = x[..., :3], x[..., 3:]
    wy, vy = y[..., :3], y[..., 3:]
    return np.concatenate(
        np.broadcast_arrays(cross(wx, wy), cross(wx, vy) - cross(wy, vx)), axis=-1)


def klein_form(x: Array, y: Array) -> Any:
    """
    Return the Klein form (reciprocal product) ``wx . vy + wy . vx``.

    It does not depend on the pole; it vanishes for reciprocal screws.

    Parameters
    ----------
    x, y : array, shape (..., 6)
        Six-vectors about the same pole, in the same axes.

    Returns
    -------
    array, shape (...)

    References
    ----------
    The paper, section 2.2.

    Examples
    --------
    >>> int(klein_form(np.array([0, 0, 1, 0, 0, 0]), np.array([0, 0, 0, 0, 0, 1])))
    1

    """
    x, y = np.asarray(x), np.asarray(y)
    return dot(x[..., :3], y[..., 3:]) + dot(y[..., :3], x[..., 3:])


def killing_form(x: Array, y: Array) -> Any:
    """
    Return the Killing form as the paper has it, ``wx . wy``.

    The trace form ``tr(ad X ad Y)`` of se(3) is -4 times this value.

    Parameters
    ----------
    x, y : array, shape (..., 6)
        Six-vectors about the same pole, in the same axes.

    Returns
    -------
    array, shape (...)

    References
    ----------
    The paper, section 2.2.

    Examples
    --------
    >>> int(killing_form(np.array([0, 2, 1, 0, 0, 0]), np.array([0, 3, 0, 0, 0, 1])))
    6

    """
    x, y = np.asarray(x), np.asarray(y)
    return dot(x[..., :3], y[..., :3])


def shift_pole(x: Array, displacement: Array) -> Array:
    """
    Return a helicoidal field's six-vector about another pole.

    ``X_P = (X_w ; X_d + X_w x r_OP)``. States of every order (reduced, not classical)
    are helicoidal fields, as are screws.

    Parameters
    ----------
    x : array, shape (..., 6)
        Six-vector about the pole O.
    displacement : array, shape (..., 3)
        Vector r_OP from the old pole O to the new pole P [m], in the axes of ``x``.

    Returns
    -------
    array, shape (..., 6)

    Examples
    --------
    >>> shift_pole(np.array([0, 0, 1, 0, 0, 0]), np.array([2, 0, 0]))
    array([0, 0, 1, 0, 2, 0])

    """
    x, displacement = np.asarray(x), np.asarray(displacement)
    w = x[..., :3]
    return np.concatenate(
        np.broadcast_arrays(w, x[..., 3:] + cross(w, displacement)), axis=-1)


def rotate(rotation: Array, x: Array) -> Array:
    """
    Return a six-vector in other axes, about the same pole.

    Parameters
    ----------
    rotation : array, shape (..., 3, 3)
        Rotation that maps coordinates in the present axes to the wanted axes.
    x : array, shape (..., 6)
        Six-vector in the present axes.

    Returns
    -------
    array, shape (..., 6)

    Examples
    --------
    >>> rotate(np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.array([1, 0, 0, 0, 1, 0]))
    array([ 0,  1,  0, -1,  0,  0])

    """
    rotation, x = np.asarray(rotation), np.asarray(x)
    return np.concatenate(
        [matvec(rotation, x[..., :3]), matvec(rotation, x[..., 3:])], axis=-1)


def matvec(matrix: Array, vector: Array) -> Array:
    """
    Return the product of (batches of) matrices and vectors of any scalar type.

    Examples
    --------
    >>> matvec(np.array([[0, 1], [1, 0]]), np.array([3, 4]))
    array([4, 3])

    """
    return (matrix @ vector[..., None])[..., 0]


def rotation_about(axis: Array, angle: Any) -> Array:
    """
    Return the rotation matrix about a unit axis (Rodrigues).

    Parameters
    ----------
    axis : array, shape (..., 3)
        Unit vector.
    angle : array, shape (...)
        Angle [rad].

    Returns
    -------
    array, shape (..., 3, 3)

    Examples
    --------
    >>> float(rotation_about(np.array([0, 0, 1]), np.pi / 2).round(12)[0, 1])
    -1.0

    """
    axis, angle = np.asarray(axis), np.asarray(angle)
    c, s = np.asarray(cos(angle))[..., None, None], np.asarray(sin(angle))[..., None, None]
    projector = axis[..., :, None] * axis[..., None, :]
    # Written so that constant axes leave no terms such as 1 - (1 - c) in symbolic results.
    return c * (np.eye(3, dtype=int) - projector) + s * skew(axis) + projector


def skew(vector: Array) -> Array:
    """
    Return the matrix of the cross product with a vector.

    Parameters
    ----------
    vector : array, shape (..., 3)
        Left factor of the cross product.

    Returns
    -------
    array, shape (..., 3, 3)

    Examples
    --------
    >>> skew(np.array([1, 2, 3]))
    array([[ 0, -3,  2],
           [ 3,  0, -1],
           [-2,  1,  0]])

    """
    vector = np.asarray(vector)
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    zero = 0 * x
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
