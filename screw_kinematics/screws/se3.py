# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The Lie algebra se(3) on six-vectors.

A six-vector is ``(angular; linear)``, the primal and the dual part of a screw, and has
shape (..., 6): the last axis holds it, so that a column of shape (6, 1) is refused. A SymPy
column matrix is taken as the six-vector that it stands for. A wrench as a screw is
``(force; moment)``: its primal part is the force. Nothing here casts: all functions but
:func:`exp` and :func:`log` run on floats, on batches, and on object arrays of any scalar type
that has ``+`` and ``*`` (symbols, traced expressions). Poses and rotations of floats are
checked to be such within 1e-6.

References
----------
Gallardo-Alvarado et al., "Symbolic Computation of the Lie Algebra se(3) of the Euclidean
Group SE(3)", Mathematics 2024, 12(16), 2538, called "the paper" throughout this package.

"""
from __future__ import annotations

from typing import Any

import numpy as np

from .exponential import exp, log
from .rigid import checked_pose, checked_rotation
from .rotations import rotation_about
from .vectors import Array, checked_array, cos, cross, dot, matvec, sin, skew

__all__ = [
    'Array', 'ad', 'adjoint', 'coadjoint', 'cos', 'cross', 'dot', 'exp', 'inverse',
    'killing_form', 'klein_form', 'lie_product', 'log', 'matvec', 'rotate', 'rotation_about',
    'shift_pole', 'sin', 'skew']

SIX = (..., 6)


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
        About the pole of x and y, in their axes.

    Raises
    ------
    ShapeError, InvalidValueError
        The last axis is not 6 long, or an argument is no array of numbers or symbols.

    References
    ----------
    The paper, section 2.3.

    Examples
    --------
    >>> lie_product(np.array([1, 0, 0, 0, 0, 0]), np.array([0, 1, 0, 0, 0, 0]))
    array([0, 0, 1, 0, 0, 0])

    """
    x, y = checked_array('x', x, SIX), checked_array('y', y, SIX)
    wx, vx = x[..., :3], x[..., 3:]
    wy, vy = y[..., :3], y[..., 3:]
    return np.concatenate(
        np.broadcast_arrays(cross(wx, wy), cross(wx, vy) - cross(wy, vx)), axis=-1)


def ad(x: Array) -> Array:
    """
    Return the matrix that takes Y to the Lie product [X, Y] with a given six-vector X.

    Parameters
    ----------
    x : array, shape (..., 6)
        Left factor.

    Returns
    -------
    array, shape (..., 6, 6)
        Acts on six-vectors about the pole of x, in its axes.

    Raises
    ------
    ShapeError, InvalidValueError
        The last axis is not 6 long, or an argument is no array of numbers or symbols.

    Examples
    --------
    >>> ad(np.array([1, 0, 0, 0, 0, 0])) @ np.array([0, 1, 0, 0, 0, 0])
    array([0, 0, 1, 0, 0, 0])

    """
    x = checked_array('x', x, SIX)
    w, v = skew(x[..., :3]), skew(x[..., 3:])
    return _blocks(w, 0 * w, v, w)


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
        The same about every pole; power, if one is a twist and one a wrench.

    Raises
    ------
    ShapeError, InvalidValueError
        The last axis is not 6 long, or an argument is no array of numbers or symbols.

    References
    ----------
    The paper, section 2.3.

    Examples
    --------
    >>> int(klein_form(np.array([0, 0, 1, 0, 0, 0]), np.array([0, 0, 0, 0, 0, 1])))
    1

    """
    x, y = checked_array('x', x, SIX), checked_array('y', y, SIX)
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
        The same about every pole.

    Raises
    ------
    ShapeError, InvalidValueError
        The last axis is not 6 long, or an argument is no array of numbers or symbols.

    References
    ----------
    The paper, section 2.3.

    Examples
    --------
    >>> int(killing_form(np.array([0, 2, 1, 0, 0, 0]), np.array([0, 3, 0, 0, 0, 1])))
    6

    """
    x, y = checked_array('x', x, SIX), checked_array('y', y, SIX)
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
        About the new pole P, in the same axes.

    Raises
    ------
    ShapeError, InvalidValueError
        The last axes are not 6 and 3 long.

    Examples
    --------
    >>> shift_pole(np.array([0, 0, 1, 0, 0, 0]), np.array([2, 0, 0]))
    array([0, 0, 1, 0, 2, 0])

    """
    x = checked_array('x', x, SIX)
    displacement = checked_array('displacement', displacement, (..., 3))
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
        In the wanted axes, about the same pole.

    Raises
    ------
    ShapeError, InvalidValueError
        The last axes are not 3 x 3 and 6, or the rotation is none within 1e-6.

    Examples
    --------
    >>> rotate(np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.array([1, 0, 0, 0, 1, 0]))
    array([ 0,  1,  0, -1,  0,  0])

    """
    rotation, x = checked_rotation('rotation', rotation), checked_array('x', x, SIX)
    return np.concatenate(
        [matvec(rotation, x[..., :3]), matvec(rotation, x[..., 3:])], axis=-1)


def adjoint(T: Array) -> Array:    # noqa: N803
    """
    Return the matrix that carries six-vectors from one frame to another.

    ``adjoint(T_a_b) @ X_b``: from axes and origin of frame b to axes and origin of frame a.
    It carries screws, states of every order, and wrenches written as screws
    (force; moment).

    Parameters
    ----------
    T : array, shape (..., 4, 4)
        Pose T_a_b of frame b in frame a [m].

    Returns
    -------
    array, shape (..., 6, 6)
        Acts on six-vectors (angular; linear).

    Raises
    ------
    ShapeError, InvalidValueError
        T is no rigid displacement within 1e-6.

    Examples
    --------
    A rotation about the z axis of a frame whose origin is at x = 1.

    >>> T = np.array([[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    >>> adjoint(T) @ np.array([0, 0, 1, 0, 0, 0])
    array([ 0,  0,  1,  0, -1,  0])

    """
    T = checked_pose('T', T)    # noqa: N806
    R = T[..., :3, :3]    # noqa: N806
    return _blocks(R, 0 * R, skew(T[..., :3, 3]) @ R, R)


def coadjoint(T: Array) -> Array:    # noqa: N803
    """
    Return the matrix that carries (moment; force) from one frame to another.

    Six-vectors (moment; force) pair with twists by the ordinary inner product, which is
    power; they are carried by the inverse transpose of :func:`adjoint`.

    Parameters
    ----------
    T : array, shape (..., 4, 4)
        Pose T_a_b of frame b in frame a [m].

    Returns
    -------
    array, shape (..., 6, 6)
        Acts on six-vectors (moment; force).

    Raises
    ------
    ShapeError, InvalidValueError
        T is no rigid displacement within 1e-6.

    Examples
    --------
    A force along y that acts at x = 1 has the moment 1 about the origin.

    >>> T = np.array([[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    >>> coadjoint(T) @ np.array([0, 0, 0, 0, 1, 0])
    array([0, 0, 1, 0, 1, 0])

    """
    T = checked_pose('T', T)    # noqa: N806
    R = T[..., :3, :3]    # noqa: N806
    return _blocks(R, skew(T[..., :3, 3]) @ R, 0 * R, R)


def inverse(T: Array) -> Array:    # noqa: N803
    """
    Return the inverse T_b_a of a pose T_a_b.

    Parameters
    ----------
    T : array, shape (..., 4, 4)
        Rigid displacement [m].

    Returns
    -------
    array, shape (..., 4, 4)
        The pose T_b_a.

    Raises
    ------
    ShapeError, InvalidValueError
        T is no rigid displacement within 1e-6.

    Examples
    --------
    >>> inverse(np.array([[0, -1, 0, 5], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]))[:3, 3]
    array([0, 5, 0])

    """
    T = checked_pose('T', T)    # noqa: N806
    R = np.swapaxes(T[..., :3, :3], -1, -2)    # noqa: N806
    upper = np.concatenate([R, -matvec(R, T[..., :3, 3])[..., None]], axis=-1)
    return np.concatenate([upper, T[..., 3:, :]], axis=-2)


def _blocks(a: Array, b: Array, c: Array, d: Array) -> Array:
    upper, lower = np.concatenate([a, b], axis=-1), np.concatenate([c, d], axis=-1)
    return np.concatenate([upper, lower], axis=-2)
