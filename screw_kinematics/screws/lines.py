# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Lines of space in Plücker coordinates ``(d ; p x d)``.

A line is a six-vector like any other: direction d, then the moment about the pole (the
origin) of any of its points p. The coordinates are homogeneous: a multiple is the same
line. :func:`line`, :func:`line_through` and :func:`moment_about` run on any scalar type, the
others on floats.

References
----------
The paper, section 2.1. Its m = l x q is a slip for m = q x l, as its next equation has it;
(7) and (8) hold if q is the foot of the perpendicular from the origin; and (10) is the
moment of line 2 about the point p1 of line 1, not the moment m1.

"""
from __future__ import annotations

from typing import Any

import numpy as np

from .se3 import klein_form, shift_pole
from .vectors import Array, checked_array, cross, dot, finite_array
from ..errors import InvalidValueError

__all__ = ['angle', 'common_perpendicular', 'distance', 'line', 'line_through', 'moment_about',
           'mutual_position', 'nearest_point']

# Directions that differ by less than this angle [rad] count as parallel: beyond it, the two
# formulas for the distance are equally accurate.
_PARALLEL = 1e-8


def line(point: Array, direction: Array) -> Array:
    """
    Return the line through a point in a direction, ``(d ; p x d)``.

    Parameters
    ----------
    point : array, shape (..., 3)
        Any point p of the line [m].
    direction : array, shape (..., 3)
        Direction d; it need not be a unit vector, and its length stays in the result.

    Returns
    -------
    array, shape (..., 6)
        Direction, then moment about the origin.

    Raises
    ------
    ShapeError, InvalidValueError
        An argument has not three components of numbers or symbols, or the direction is zero.

    References
    ----------
    The paper, section 2.1.

    Examples
    --------
    >>> line(np.array([1, 0, 0]), np.array([0, 0, 1]))
    array([ 0,  0,  1,  0, -1,  0])

    """
    point = checked_array('point', point, (..., 3))
    direction = checked_array('direction', direction, (..., 3))
    _check_direction('direction', direction)
    return np.concatenate(np.broadcast_arrays(direction, cross(point, direction)), axis=-1)


def line_through(p: Array, q: Array) -> Array:
    """
    Return the line through two points, from p to q: ``(q - p ; p x q)``.

    Parameters
    ----------
    p, q : array, shape (..., 3)
        Two different points [m].

    Returns
    -------
    array, shape (..., 6)
        Direction, then moment about the origin.

    Raises
    ------
    ShapeError, InvalidValueError
        An argument has not three components of numbers or symbols, or the direction is zero.

    References
    ----------
    The paper, section 2.1.

    Examples
    --------
    >>> line_through(np.array([1, 0, 0]), np.array([1, 0, 2]))
    array([ 0,  0,  2,  0, -2,  0])

    """
    p, q = checked_array('p', p, (..., 3)), checked_array('q', q, (..., 3))
    _check_direction('q - p', q - p)
    return np.concatenate(np.broadcast_arrays(q - p, cross(p, q)), axis=-1)


def moment_about(x: Array, point: Array) -> Array:
    """
    Return the moment of a line about a point, ``m + d x r``.

    Parameters
    ----------
    x : array, shape (..., 6)
        Line.
    point : array, shape (..., 3)
        Vector r from the pole to the point [m].

    Returns
    -------
    array, shape (..., 3)
        Zero for points of the line.

    Raises
    ------
    ShapeError, InvalidValueError
        The last axes are not 6 and 3 long.

    Examples
    --------
    >>> moment_about(line(np.array([1, 0, 0]), np.array([0, 0, 1])), np.array([1, 0, 5]))
    array([0, 0, 0])

    """
    return shift_pole(x, point)[..., 3:]


def nearest_point(x: Array, point: Array = (0, 0, 0)) -> Array:    # type: ignore[assignment]
    """
    Return the point of a line that is nearest to a given point.

    Parameters
    ----------
    x : array, shape (..., 6)
        Line.
    point : array, shape (..., 3)
        Given point [m]; by default the origin.

    Returns
    -------
    array, shape (..., 3)
        On the line [m].

    Raises
    ------
    ShapeError, InvalidValueError
        These are not the coordinates of a line.

    Examples
    --------
    >>> nearest_point(line(np.array([1, 0, 7]), np.array([0, 0, 3])), np.array([9, 9, 2]))
    array([1., 0., 2.])

    """
    x = _unit_line(x)
    point = finite_array('point', point, (..., 3))
    return point + cross(x[..., :3], moment_about(x, point))


def distance(x: Array, y: Array) -> Any:
    """
    Return the shortest distance of two lines.

    It is ``|{x;y}| / |dx x dy|``, their reciprocal product (Klein form) over the sine of
    their angle; for parallel lines the distance of y's nearest point from x.

    Parameters
    ----------
    x, y : array, shape (..., 6)
        Lines.

    Returns
    -------
    array, shape (...) [m]
        Never negative.

    Raises
    ------
    ShapeError, InvalidValueError
        These are not the coordinates of a line.

    References
    ----------
    The paper, section 2.1.

    Examples
    --------
    >>> x = line(np.array([0, 0, 0]), np.array([1, 0, 0]))
    >>> float(distance(x, line(np.array([0, 0, 2]), np.array([0, 3, 0]))))
    2.0

    """
    x, y = _unit_line(x), _unit_line(y)
    sine = np.linalg.norm(cross(x[..., :3], y[..., :3]), axis=-1)
    parallel = sine < _PARALLEL
    skew_distance = np.abs(klein_form(x, y)) / np.where(parallel, 1, sine)
    offset = moment_about(x, nearest_point(y, nearest_point(x)))
    return np.where(parallel, np.linalg.norm(offset, axis=-1), skew_distance)[()]


def common_perpendicular(x: Array, y: Array) -> tuple[Array, Array]:
    """
    Return the feet of the common perpendicular of two lines.

    The points of x and of y that are nearest to each other. Parallel lines have many such
    pairs; of these, the one with the point of x that is nearest to the origin.

    Parameters
    ----------
    x, y : array, shape (..., 6)
        Lines.

    Returns
    -------
    on_x, on_y : array, shape (..., 3)
        The feet [m]. ``line_through(on_x, on_y)`` is the perpendicular where the lines do
        not meet; where they do, both are the point of intersection.

    Raises
    ------
    ShapeError, InvalidValueError
        These are not the coordinates of a line.

    References
    ----------
    The paper, section 2.1, has its length, :func:`distance`. J. Denavit, R. S. Hartenberg,
    "A kinematic notation for lower-pair mechanisms", J. Applied Mechanics 22, 1955: it is
    the x axis of their frames.

    Examples
    --------
    >>> x = line(np.array([0, 0, 0]), np.array([1, 0, 0]))
    >>> on_x, on_y = common_perpendicular(x, line(np.array([5, 7, 2]), np.array([0, 3, 0])))
    >>> on_x, on_y
    (array([5., 0., 0.]), array([5., 0., 2.]))

    """
    x, y = np.broadcast_arrays(_unit_line(x), _unit_line(y))
    d, e = x[..., :3], y[..., :3]
    p = nearest_point(x)
    across = cross(d, e)
    square = dot(across, across)
    parallel = square < _PARALLEL ** 2
    # Along x to where the plane through y and the perpendicular cuts it.
    offset = nearest_point(y, p) - p
    along = dot(offset, cross(e, across)) / np.where(parallel, 1, square)
    on_x = p + np.where(parallel, 0, along)[..., None] * d
    return on_x + 0.0, nearest_point(y, on_x) + 0.0


def angle(x: Array, y: Array) -> Any:
    """
    Return the angle between the directions of two lines.

    Parameters
    ----------
    x, y : array, shape (..., 6)
        Lines; a line and its reverse differ by pi.

    Returns
    -------
    array, shape (...) [rad], 0 to pi
        Of their directions.

    Raises
    ------
    ShapeError, InvalidValueError
        These are not the coordinates of a line.

    Examples
    --------
    >>> x = line(np.array([0, 0, 0]), np.array([1, 0, 0]))
    >>> round(float(angle(x, line(np.array([0, 0, 2]), np.array([0, 3, 0])))), 12)
    1.570796326795

    """
    d, e = _unit_line(x)[..., :3], _unit_line(y)[..., :3]
    return np.arctan2(np.linalg.norm(cross(d, e), axis=-1), dot(d, e))


def mutual_position(x: Array, y: Array, tolerance: float = 1e-9) -> str:
    """
    Return how two lines lie: 'identical', 'parallel', 'intersecting' or 'skew'.

    Parameters
    ----------
    x, y : array, shape (6,)
        Lines; their senses do not matter.
    tolerance : float
        Distance [m] below which lines meet. Angles below 1e-8 rad count as none.

    Returns
    -------
    str
        One of the four words.

    Raises
    ------
    ShapeError, InvalidValueError
        These are not the coordinates of one line each.

    Examples
    --------
    >>> x = line(np.array([0, 0, 0]), np.array([1, 0, 0]))
    >>> mutual_position(x, line(np.array([0, 1, 0]), np.array([-2, 0, 0])))
    'parallel'
    >>> mutual_position(x, line(np.array([5, 0, 0]), np.array([0, 1, 0])))
    'intersecting'

    """
    x, y = finite_array('line x', x, (6,)), finite_array('line y', y, (6,))
    touching = distance(x, y) <= tolerance
    if np.sin(angle(x, y)) < _PARALLEL:
        return 'identical' if touching else 'parallel'
    return 'intersecting' if touching else 'skew'


def _check_direction(name: str, direction: Array) -> None:
    """Refuse a zero direction, which is that of no line; symbols are not known to be zero."""
    if direction.dtype != object and not np.all(np.any(direction != 0, axis=-1)):
        raise InvalidValueError(f'{name} must not be zero, got {direction.tolist()}')


def _unit_line(x: Array) -> Array:
    """Return the line with unit direction, after checking that it is one."""
    x = finite_array('line', x, (..., 6))
    size = np.linalg.norm(x[..., :3], axis=-1, keepdims=True)
    if not np.all(size > 0):
        raise InvalidValueError(
            f'line: the direction must be finite and not zero, got {x.tolist()}')
    x = x / size
    pitch = np.abs(dot(x[..., :3], x[..., 3:]))
    if np.any(pitch > 1e-9 * (1 + np.linalg.norm(x[..., 3:], axis=-1))):
        raise InvalidValueError(
            'line: direction and moment must be perpendicular (Plücker condition), '
            f'got {x.tolist()}')
    return x
