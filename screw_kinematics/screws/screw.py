# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Screws: from axis, point and pitch to six-vectors and back; reciprocity.

Every twist is a rotation about a line together with a translation along it (Chasles,
Mozzi): amplitude times unit screw.

References
----------
The paper, sections 2.1 (screws by their pitch) and 2.2 (Chasles' theorem).

"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .exponential import log
from .se3 import klein_form
from .vectors import Array, checked_array, cross, dot, finite_array
from ..errors import InvalidValueError

__all__ = ['Screw', 'are_reciprocal', 'prismatic_screw', 'reciprocal_screws',
           'screw_of_displacement', 'screw_of_twist', 'unit_screw']

# Ratios below this are rounding noise. For a twist it means: an axis further away than
# 1e12 m is that of a translation, and a pitch below 1e-12 of |v| / |w| is none.
_NEGLIGIBLE = 1e-12
_RANK = 1e-9


def unit_screw(axis: Array, point: Array, pitch: Any = 0) -> Array:
    """
    Return the unit screw ``(s ; p x s + h s)``, or ``(0 ; s)`` if the pitch is infinite.

    Parameters
    ----------
    axis : array, shape (..., 3)
        Unit direction s of the screw axis.
    point : array, shape (..., 3)
        Vector p from the pole to any point of the axis [m].
    pitch : array, shape (...)
        Pitch h [m/rad] of either sign; 0 for a rotation, inf for a translation.

    Returns
    -------
    array, shape (..., 6)
        About the pole, in the axes of the arguments.

    Raises
    ------
    ShapeError, InvalidValueError
        Axis or point have not three components of numbers or symbols.

    References
    ----------
    The paper, section 2.1.

    Examples
    --------
    >>> unit_screw(np.array([0, 0, 1]), np.array([1, 0, 0]))
    array([ 0,  0,  1,  0, -1,  0])
    >>> unit_screw(np.array([0, 0, 1]), np.array([1, 0, 0]), np.inf)
    array([0., 0., 0., 0., 0., 1.])

    """
    axis, point = checked_array('axis', axis, (..., 3)), checked_array('point', point, (..., 3))
    pitch = checked_array('pitch', pitch, (...,))[..., None]
    if pitch.dtype != object and np.any(np.isinf(pitch)):
        infinite = np.isinf(pitch)
        finite = unit_screw(axis, point, np.where(infinite, 0, pitch)[..., 0])
        return np.where(infinite, prismatic_screw(axis), finite)
    moment = cross(point, axis) + pitch * axis
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
        It has no place, hence no pole.

    Raises
    ------
    ShapeError, InvalidValueError
        The axis has not three components of numbers or symbols.

    References
    ----------
    The paper, section 2.1.

    Examples
    --------
    >>> prismatic_screw(np.array([0, 1, 0]))
    array([0, 0, 0, 0, 1, 0])

    """
    axis = checked_array('axis', axis, (..., 3))
    return np.concatenate([0 * axis, axis], axis=-1)


@dataclass(frozen=True, eq=False)
class Screw:
    """
    A motion as its screw: where the axis is, how it advances, how fast it turns.

    Parameters
    ----------
    axis : array, shape (..., 3)
        Unit direction; zero at rest.
    point : array, shape (..., 3)
        Vector from the pole to the nearest point of the axis [m]; zero for translations,
        whose axis has no place.
    pitch : array, shape (...)
        Advance per angle [m/rad]: 0 for a rotation, inf for a translation, 0 at rest.
    amplitude : array, shape (...)
        ``|w|`` [rad/s], for translations ``|v|`` [m/s]; never negative. For a finite
        displacement the angle [rad] or the distance [m].

    """

    axis: Array
    point: Array
    pitch: Array
    amplitude: Array

    @property
    def kind(self) -> Array:
        """Return 'rest', 'rotation', 'translation' or 'helical', shape (...)."""
        conditions = [self.amplitude == 0, self.pitch == 0, np.isinf(self.pitch)]
        return np.select(conditions, ['rest', 'rotation', 'translation'], 'helical')

    @property
    def twist(self) -> Array:
        """Return amplitude times unit screw, shape (..., 6), about the pole."""
        unit = unit_screw(self.axis, self.point, self.pitch)
        return np.asarray(self.amplitude)[..., None] * unit


def screw_of_twist(twist: Array) -> Screw:
    """
    Return axis, nearest point, pitch and amplitude of a twist: its Mozzi axis.

    Sizes are compared with each other only, so that twists of any magnitude are decomposed
    alike; rest is the zero twist. An axis further than 1e12 m away is that of a translation.

    Parameters
    ----------
    twist : array, shape (..., 6)
        Any six-vector [rad/s, m/s].

    Returns
    -------
    Screw
        About the pole of the twist, in its axes.

    Raises
    ------
    ShapeError, InvalidValueError
        The last axis is not 6 long, or a component is not finite.

    References
    ----------
    The paper, section 2.2.

    Examples
    --------
    >>> screw = screw_of_twist(np.array([0, 0, 2, 0, -2, 1]))
    >>> screw.axis, screw.point, float(screw.pitch), float(screw.amplitude)
    (array([0., 0., 1.]), array([1., 0., 0.]), 0.5, 2.0)

    """
    twist = finite_array('twist', twist, (..., 6))
    turning, s = _polar(twist[..., :3])
    moving, u = _polar(twist[..., 3:])
    translation = turning <= _NEGLIGIBLE * moving
    with np.errstate(under='ignore'):
        ratio = np.where(translation, 0, moving / np.where(translation, 1, turning))
    cosine = dot(s, u)
    pitch = np.where(np.abs(cosine) <= _NEGLIGIBLE, 0, ratio * cosine)
    return Screw(
        axis=np.where(translation[..., None], u, s),
        point=ratio[..., None] * cross(s, u) + 0.0,    # no negative zeros
        pitch=np.where(translation & (moving > 0), np.inf, pitch),
        amplitude=np.where(translation, moving, turning))


def screw_of_displacement(T: Array) -> Screw:    # noqa: N803
    """
    Return the screw of a finite rigid displacement (Chasles).

    Parameters
    ----------
    T : array, shape (..., 4, 4)
        Rigid displacement [m].

    Returns
    -------
    Screw
        Its amplitude is the angle, from 0 to pi [rad], or the distance of a translation [m].

    Raises
    ------
    ShapeError, InvalidValueError
        T is no rigid displacement within 1e-6, or an entry is not finite.

    References
    ----------
    The paper, section 2.2, for its first half: every displacement is one about a screw.

    Examples
    --------
    Half a turn about the line x = 1, with an advance of 0.5.

    >>> T = np.array([[-1, 0, 0, 2], [0, -1, 0, 0], [0, 0, 1, 0.5], [0, 0, 0, 1]])
    >>> screw = screw_of_displacement(T)
    >>> abs(screw.point.round(12)), round(float(screw.amplitude * screw.pitch), 12)
    (array([1., 0., 0.]), 0.5)

    """
    return screw_of_twist(log(T))


def are_reciprocal(x: Array, y: Array, tolerance: float = 1e-12) -> Any:
    """
    Return whether two screws are reciprocal: a wrench on one does no work on the other.

    Parameters
    ----------
    x, y : array, shape (..., 6)
        Screws about the same pole, in the same axes.
    tolerance : float
        Klein form allowed as a fraction of ``|wx| |vy| + |wy| |vx|``, its largest possible
        value.

    Returns
    -------
    array of bool, shape (...)
        True where they are.

    Raises
    ------
    ShapeError, InvalidValueError
        The last axis is not 6 long, or a component is not finite.

    References
    ----------
    The paper, section 2.3 (Klein form).

    Examples
    --------
    >>> bool(are_reciprocal(np.array([0, 0, 1, 0, 0, 0]), np.array([1, 0, 0, 0, 0, 0])))
    True

    """
    x, y = finite_array('x', x, (..., 6)), finite_array('y', y, (..., 6))
    size = [np.linalg.norm(part, axis=-1)
            for part in (x[..., :3], y[..., 3:], y[..., :3], x[..., 3:])]
    return np.abs(klein_form(x, y)) <= tolerance * (size[0] * size[1] + size[2] * size[3])


def reciprocal_screws(screws: Array, length: float = 1.0) -> Array:
    """
    Return a basis of the screws reciprocal to all given ones.

    For the screws of an arm they are the wrenches its joints cannot balance and need not:
    the directions of the tip that are blocked.

    Parameters
    ----------
    screws : array, shape (n, 6)
        Screws about one pole, in one set of axes.
    length : float
        Characteristic length [m] that makes angles and lengths comparable when deciding
        which screws depend on each other.

    Returns
    -------
    array, shape (6 - rank, 6)
        Unit screws about the same pole (translations have a unit dual part).

    Raises
    ------
    ShapeError, InvalidValueError
        The screws are no array of shape (n, 6), or a component is not finite.

    References
    ----------
    The paper, section 2.3 (Klein form).

    Examples
    --------
    A revolute joint alone: every wrench with no moment about its axis.

    >>> reciprocal_screws(np.array([[0, 0, 1, 0, 0, 0]])).shape
    (5, 6)

    """
    screws = finite_array('screws', screws, (None, 6))
    if not 0 < length < np.inf:
        raise InvalidValueError(f'length must be positive and finite, got {length!r}')
    scale = np.array([1, 1, 1, 1 / length, 1 / length, 1 / length])
    _, sizes, rows = np.linalg.svd(screws * scale)
    rank = int(np.sum(sizes > _RANK * sizes[0])) if len(sizes) and sizes[0] > 0 else 0
    # Klein form = inner product with primal and dual part exchanged.
    found = np.roll(rows[rank:] * scale, 3, axis=-1)
    size = np.array([screw_of_twist(x).amplitude for x in found])
    return found / size.reshape(-1, 1)


def _polar(x: Array) -> tuple[Array, Array]:
    """Return size and direction, without overflow or underflow of the squares."""
    scale = np.max(np.abs(x), axis=-1, keepdims=True)
    x = x / np.where(scale > 0, scale, 1)
    size = np.linalg.norm(x, axis=-1, keepdims=True)
    return (scale * size)[..., 0], x / np.where(size > 0, size, 1)
