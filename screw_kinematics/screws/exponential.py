# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Exponential and logarithm of the Euclidean group SE(3), on floats and batches of floats.

Both keep full accuracy at angle 0, at angle pi, and in between: what would cancel is taken
from a series near 0, and the rotation vector goes through a unit quaternion.
"""
from __future__ import annotations

from collections.abc import Callable
from math import factorial

import numpy as np

from .rigid import checked_pose
from .rotations import rotation_vector
from .vectors import Array, cross, finite_array, skew

__all__ = ['exp', 'log']

# Below this angle the closed forms of the third coefficients lose digits; the truncation
# error of the series is then below 1e-17.
_SMALL = 0.5
_TERMS = 8
# (x - sin x) / x^3 and (1 - (x/2) cot (x/2)) / x^2, in powers of x^2.
_CUBIC = [(-1) ** k / factorial(2 * k + 3) for k in range(_TERMS)]
_COTANGENT = [1 / 12, 1 / 720, 1 / 30240, 1 / 1209600, 1 / 47900160,
              691 / 1307674368000, 1 / 74724249600, 3617 / 10670622842880000]


def exp(x: Array) -> Array:
    """
    Return the rigid displacement that a constant twist produces in unit time.

    Parameters
    ----------
    x : array, shape (..., 6)
        Twist times time (angular; linear) [rad, m], pole at the origin.

    Returns
    -------
    array, shape (..., 4, 4)
        The displacement.

    Raises
    ------
    ShapeError, InvalidValueError
        The last axis is not 6 long, or a component is not finite.

    Examples
    --------
    >>> exp(np.array([0, 0, np.pi / 2, 0, 0, 1])).round(12)[:3, 3]
    array([0., 0., 1.])

    """
    x = finite_array('x', x, (..., 6))
    w, v = x[..., :3], x[..., 3:]
    angle = np.linalg.norm(w, axis=-1)
    first = np.sinc(angle / np.pi)
    second = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    third = _by_angle(angle, _CUBIC, lambda t: (t - np.sin(t)) / t ** 3)
    W = skew(w)    # noqa: N806
    W2 = W @ W    # noqa: N806
    a, b, c = (f[..., None, None] for f in (first, second, third))
    T = np.zeros(x.shape[:-1] + (4, 4))    # noqa: N806
    T[..., :3, :3] = np.eye(3) + a * W + b * W2
    T[..., :3, 3] = v + (b * W @ v[..., None] + c * W2 @ v[..., None])[..., 0]
    T[..., 3, 3] = 1
    return T


def log(T: Array) -> Array:    # noqa: N803
    """
    Return the twist that produces a rigid displacement in unit time.

    The inverse of :func:`exp` for angles up to pi. At exactly pi the axis may have either
    sense; both give the same displacement.

    Parameters
    ----------
    T : array, shape (..., 4, 4)
        Rigid displacement [m].

    Returns
    -------
    array, shape (..., 6)
        Angular and linear part [rad, m], pole at the origin.

    Raises
    ------
    ShapeError, InvalidValueError
        The last axes are not 4 x 4, an entry is not finite, or T is no rigid displacement
        within 1e-6.

    Examples
    --------
    >>> twist = np.array([0.1, 0.2, 0.3, 1, 2, 3])
    >>> bool(np.allclose(log(exp(twist)), twist, rtol=0, atol=1e-15))
    True

    """
    T = checked_pose('T', finite_array('T', T, (..., 4, 4)))    # noqa: N806
    w = rotation_vector(T[..., :3, :3])
    p = T[..., :3, 3]
    angle = np.linalg.norm(w, axis=-1)
    second = _by_angle(angle, _COTANGENT, lambda t: (1 - t / 2 / np.tan(t / 2)) / t ** 2)
    wp = cross(w, p)
    v = p - wp / 2 + second[..., None] * cross(w, wp)
    return np.concatenate([w, v], axis=-1)


def _by_angle(angle: Array, series: list[float], closed_form: Callable[[Array], Array]) -> Array:
    """Evaluate an even function of the angle by its series below _SMALL."""
    small = angle < _SMALL
    near = np.polynomial.polynomial.polyval(np.where(small, angle, 0) ** 2, series)
    far = closed_form(np.where(small, 1, angle))
    return np.where(small, near, far)
