# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Three-vectors of any scalar type.

Nothing here casts: all functions run on floats, on batches, and on object arrays of any
scalar type that has ``+`` and ``*`` (symbols, traced expressions). NumPy's own ``cross``
does not take object arrays of every kind, hence these few. Arrays from outside are checked
by :func:`checked_array` and, where only numbers will do, :func:`finite_array`.
"""
from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..errors import InvalidValueError, ShapeError

Array = np.ndarray[Any, np.dtype[Any]]


def checked_array(name: str, value: Any, shape: tuple[Any, ...]) -> Array:
    """
    Return a value as an array of any scalar type, after checking its shape.

    An ``...`` in front allows any axes before, a None any length. A SymPy column matrix is taken
    as the vector that it stands for; a NumPy array of shape (n, 1) is not.

    Raises
    ------
    ShapeError, InvalidValueError
        The shape is another one; the value is no array of numbers or symbols.

    Examples
    --------
    >>> checked_array('point', [1, 2, 3], (..., 3))
    array([1, 2, 3])
    >>> checked_array('point', [[1], [2], [3]], (..., 3))
    Traceback (most recent call last):
    ...
    screw_kinematics.errors.ShapeError: point: expected shape (..., 3), got (3, 1)

    """
    if getattr(value, 'is_Matrix', False) and value.shape[1] == 1 and len(shape) < 3:
        value = value.tolist()
        array = np.array([row[0] for row in value], dtype=object)
    else:
        try:
            array = np.asarray(value)
        except ValueError:      # rows of different lengths
            raise InvalidValueError(f'{name}: must be an array, got {value!r}') from None
    if array.dtype.kind not in 'iufO':
        raise InvalidValueError(f'{name} must be numbers, got {array.tolist()!r}')
    anywhere = shape[:1] == (...,)
    wanted = shape[1:] if anywhere else shape
    found = array.shape[array.ndim - len(wanted):] if anywhere else array.shape
    if len(found) != len(wanted) or any(
            n is not None and n != m for n, m in zip(wanted, found)):
        names = ['...' if n is ... else 'N' if n is None else str(n) for n in shape]
        raise ShapeError(name, f'({", ".join(names)}{"," if len(names) == 1 else ""})',
                         array.shape)
    if array.dtype == object and not all(hasattr(entry, '__sub__') for entry in array.flat):
        # None, or a dictionary.
        raise InvalidValueError(f'{name} must be numbers, got {array.tolist()!r}')
    return array


def finite_array(name: str, value: Any, shape: tuple[Any, ...]) -> Array:
    """
    Return a value as an array of finite floats, after checking it as :func:`checked_array`.

    Examples
    --------
    >>> finite_array('axis', (0, 0, 1), (3,))
    array([0., 0., 1.])
    >>> finite_array('axis', (0, 0, np.nan), (3,))
    Traceback (most recent call last):
    ...
    screw_kinematics.errors.InvalidValueError: axis must be finite, got [0.0, 0.0, nan]

    """
    array = checked_array(name, value, shape)
    try:
        array = array.astype(float)
    except (TypeError, ValueError):
        raise InvalidValueError(f'{name} must be numbers, got {array.tolist()!r}') from None
    if not np.all(np.isfinite(array)):
        raise InvalidValueError(f'{name} must be finite, got {array.tolist()!r}')
    return array


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
                # An integer zero among symbols stays exact.
                zero = isinstance(value, int) and value == 0
                out[index] = int(numeric(0)) if zero else numeric(value)
        return out[()]

    apply.__name__ = apply.__qualname__ = name
    apply.__doc__ = f'''
    Return the {name} of each element.

    Parameters
    ----------
    x : array_like
        Angles [rad]: floats, SymPy expressions or traced scalars.

    Returns
    -------
    array, shape of x
        Of the same kind.

    '''
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
        Perpendicular to both, in their axes.

    Examples
    --------
    >>> cross(np.array([1, 0, 0]), np.array([0, 1, 0]))
    array([0, 0, 1])

    """
    a0, a1, a2 = a[..., 0], a[..., 1], a[..., 2]
    b0, b1, b2 = b[..., 0], b[..., 1], b[..., 2]
    first = a1 * b2 - a2 * b1
    out = np.empty(np.shape(first) + (3,), dtype=np.result_type(a, b))
    out[..., 0], out[..., 1], out[..., 2] = first, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
    return out


def dot(a: Array, b: Array) -> Any:
    """
    Return the inner product over the last axis, for any scalar type.

    Parameters
    ----------
    a, b : array, shape (..., n)
        Factors, in the same axes.

    Returns
    -------
    array, shape (...)
        Their product, summed over components.

    Examples
    --------
    >>> int(dot(np.array([1, 2, 3]), np.array([4, 5, 6])))
    32

    """
    return (a * b).sum(axis=-1)


def matvec(matrix: Array, vector: Array) -> Array:
    """
    Return the product of (batches of) matrices and vectors of any scalar type.

    Parameters
    ----------
    matrix : array, shape (..., m, n)
        Left factor.
    vector : array, shape (..., n)
        Right factor.

    Returns
    -------
    array, shape (..., m)
        The image of the vector.

    Examples
    --------
    >>> matvec(np.array([[0, 1], [1, 0]]), np.array([3, 4]))
    array([4, 3])

    """
    return (matrix @ vector[..., None])[..., 0]


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
        Antisymmetric; times a vector it is the cross product.

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
    entries = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1)
    return entries.reshape(vector.shape + (3,))
