# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Velocity, reduced acceleration, jerk and jounce states, to any order.

The state of order n, X_n, is the (n-1)-th time derivative of the spatial twist at a
space-fixed pole: X_1 = V = (w ; v), X_2 = A = (alpha ; a - w x v), and so on. All of them
are helicoidal fields, so one rule moves any of them to another pole.

One recursion carries everything: a field fixed in a body with the states X changes as::

    D_0 = Y,   D_k = sum_{j<k} C(k-1, j) [X_{j+1}, D_{k-1-j}]

The body may be a link (chains), a moving base (:func:`compose`), a moving observer
(:func:`relative`), or the body itself (:func:`body_derivatives`). It holds to any order.

References
----------
The paper, sections 2.4.1 and 2.4.2, for order 1 and 2.

"""
from __future__ import annotations

from collections.abc import Sequence
from math import comb
from typing import Any

import numpy as np

from .se3 import Array, cross, lie_product
from .vectors import checked_array
from ..errors import InvalidValueError

__all__ = ['body_derivatives', 'body_fixed_derivatives', 'chain_states',
           'classical_from_reduced', 'compose', 'link_states', 'reduced_from_classical',
           'relative']


def body_fixed_derivatives(states: Sequence[Array], field: Array, order: int) -> list[Array]:
    """
    Return a body-fixed six-vector and its time derivatives, seen from fixed space.

    Parameters
    ----------
    states : sequence of array, shape (..., 6)
        Reduced states of the body, at least ``order - 1`` of them.
    field : array, shape (..., 6)
        Six-vector fixed in the body, about the same space-fixed pole, in the same axes.
    order : int
        How many to return, at least 1.

    Returns
    -------
    list of array, shape (..., 6)
        D_0 to D_(order-1).

    Raises
    ------
    ShapeError, InvalidValueError
        The field is no six-vector, or there are too few states.

    Examples
    --------
    >>> spin = np.array([0, 0, 1, 0, 0, 0])
    >>> body_fixed_derivatives([spin], np.array([1, 0, 0, 0, 0, 0]), 2)[1]
    array([0, 1, 0, 0, 0, 0])

    """
    field = checked_array('field', field, (..., 6))
    if len(states) < order - 1:
        raise InvalidValueError(
            f'order {order} needs {order - 1} states of the body, got {len(states)}')
    carried: list[Any] = [field]
    for k in range(1, order):
        carried.append(sum(
            comb(k - 1, j) * lie_product(states[j], carried[k - 1 - j]) for j in range(k)))
    return carried


def chain_states(screws: Sequence[Array], derivatives: Sequence[Any]) -> list[Array]:
    """
    Return the states of the last body of an open chain, of order 1 to N.

    For joint i with present unit screw ``$`` and the states X of body i-1::

        D_0 = $,   D_k = sum_{j<k} C(k-1, j) [X_{j+1}, D_{k-1-j}]
        X_n(i) = X_n(i-1) + sum_{k<n} C(n-1, k) q_i^(n-k) D_k

    which holds for every order and contains the paper's Coriolis-Lie term.

    Parameters
    ----------
    screws : array, shape (..., joints, 6), or sequence of array, shape (..., 6)
        Present unit screws of the joints from base to tip, about one pole, in one set
        of axes.
    derivatives : sequence of array_like, shape (..., joints)
        Joint rates, accelerations, ... (first, second, ... derivative), N of them; numbers
        or symbols.

    Returns
    -------
    list of N arrays, shape (..., 6)
        Reduced states about the pole of the screws, in their axes.

    Raises
    ------
    ShapeError, InvalidValueError
        Screws and derivatives are not of as many joints.

    References
    ----------
    The paper, Theorems 3 and 4, for order 1 and 2.

    Examples
    --------
    >>> screw = np.array([0, 0, 1, 0, -1, 0])
    >>> chain_states([screw], [[2], [3]])[1]
    array([ 0,  0,  3,  0, -3,  0])

    """
    bodies = link_states(screws, derivatives)
    return bodies[-1] if bodies else [np.zeros(np.shape(d)[:-1] + (6,)) for d in derivatives]


def link_states(screws: Sequence[Array], derivatives: Sequence[Any]) -> list[list[Array]]:
    """
    Return the states of every body of an open chain, from the first moving one to the last.

    Parameters
    ----------
    screws : array, shape (..., joints, 6), or sequence of array, shape (..., 6)
        As of :func:`chain_states`.
    derivatives : sequence of array_like, shape (..., joints)
        As of :func:`chain_states`.

    Returns
    -------
    list of (list of N arrays, shape (..., 6))
        For each joint the states of order 1 to N of the body behind it; all about the one
        pole of the screws.

    Raises
    ------
    ShapeError, InvalidValueError
        Screws and derivatives are not of as many joints.

    References
    ----------
    The paper, Theorems 3 and 4: the partial sums.

    Examples
    --------
    >>> screws = [np.array([0, 0, 1, 0, 0, 0]), np.array([0, 0, 1, 0, -1, 0])]
    >>> [body[0].tolist() for body in link_states(screws, [[2, 3]])]
    [[0, 0, 2, 0, 0, 0], [0, 0, 5, 0, -3, 0]]

    """
    joints = _screws(screws)
    motion = [checked_array(f'derivative {n}', d, (..., len(joints)))
              for n, d in enumerate(derivatives, start=1)]
    order = len(motion)
    bodies: list[list[Array]] = []
    for i, screw in enumerate(joints):
        rates = [np.asarray(d[..., i])[..., None] for d in motion]
        # The base is at rest: the first joint's screw does not change.
        transported = body_fixed_derivatives(bodies[-1], screw, order) if i > 0 else [screw]
        states = []
        for n in range(1, order + 1):
            added = sum(
                comb(n - 1, k) * rates[n - k - 1] * transported[k]
                for k in range(min(n, len(transported))))
            states.append(np.asarray(added if i == 0 else bodies[-1][n - 1] + added))
        bodies.append(states)
    return bodies


def _screws(screws: Any) -> list[Array]:
    """Return the screws one by one: of an array they are along the last axis but one."""
    if isinstance(screws, np.ndarray):
        return list(np.moveaxis(checked_array('screws', screws, (..., None, 6)), -2, 0))
    return [checked_array(f'screw {i}', screw, (..., 6)) for i, screw in enumerate(screws, 1)]


def classical_from_reduced(states: Sequence[Array]) -> list[Array]:
    """
    Return the angular and linear derivatives of a body point from reduced states.

    The point is the body's material point now at the pole. With p^(n) its n-th
    derivative::

        p^(n) = dual_n + sum_{k=1}^{n-1} C(n-1, k) w^(n-1-k) x p^(k)

    so ``[w; v]``, ``[alpha; a]``, ``[rho; j]``, ``[sigma; s]`` for n = 1 ... 4.

    Parameters
    ----------
    states : sequence of array, shape (..., 6)
        Reduced states of order 1 to N, one pole, one set of axes.

    Returns
    -------
    list of N arrays, shape (..., 6)
        Of the body point at the pole, of order 1 to N.

    Raises
    ------
    ShapeError, InvalidValueError
        A state is no six-vector of numbers or symbols.

    Examples
    --------
    Uniform rotation about z, point at x = 1: centripetal acceleration -1.

    >>> float(classical_from_reduced([np.array([0, 0, 1, 0, 1, 0]), np.zeros(6)])[1][3])
    -1.0

    """
    states = _six_vectors(states)
    angular = [x[..., :3] for x in states]
    linear: list[Array] = []
    for n, state in enumerate(states, start=1):
        point = state[..., 3:]
        for k in range(1, n):
            point = point + comb(n - 1, k) * cross(angular[n - 1 - k], linear[k - 1])
        linear.append(point)
    return [np.concatenate([w, p], axis=-1) for w, p in zip(angular, linear)]


def reduced_from_classical(motions: Sequence[Array]) -> list[Array]:
    """
    Return reduced states from the angular and linear derivatives of a body point.

    The inverse of :func:`classical_from_reduced`.

    Parameters
    ----------
    motions : sequence of array, shape (..., 6)
        ``[w; v]``, ``[alpha; a]``, ... of the body point at the pole.

    Returns
    -------
    list of arrays, shape (..., 6)
        About the pole, of order 1 to N.

    Raises
    ------
    ShapeError, InvalidValueError
        A state is no six-vector of numbers or symbols.

    Examples
    --------
    >>> twist = np.array([0, 0, 1, 0, 1, 0])
    >>> reduced_from_classical([twist, np.array([0, 0, 0, -1, 0, 0])])[1]
    array([0, 0, 0, 0, 0, 0])

    """
    motions = _six_vectors(motions)
    angular, linear = [x[..., :3] for x in motions], [x[..., 3:] for x in motions]
    out = []
    for n in range(1, len(motions) + 1):
        dual = linear[n - 1]
        for k in range(1, n):
            dual = dual - comb(n - 1, k) * cross(angular[n - 1 - k], linear[k - 1])
        out.append(np.concatenate([angular[n - 1], dual], axis=-1))
    return out


def compose(outer: Sequence[Array], inner: Sequence[Array]) -> list[Array]:
    """
    Return the states of a body that moves relative to a moving body.

    ``A = A1 + A2 + [V1, V2]``, ``J = J1 + J2 + 2 [V1, A2] + [A1, V2] + [V1, [V1, V2]]``,
    and so on for every order.

    Parameters
    ----------
    outer : sequence of array, shape (..., 6)
        Reduced states of body 1 (a moving base, say) of order 1 to N.
    inner : sequence of array, shape (..., 6)
        Reduced states of body 2 as observed from body 1, of order 1 to N.

    Returns
    -------
    list of N arrays, shape (..., 6)
        States of body 2. All three about one pole, in one set of axes; the observer's
        pole is the point of body 1 that now coincides with it.

    Raises
    ------
    ShapeError, InvalidValueError
        A state is no six-vector of numbers or symbols.

    References
    ----------
    The paper, section 2.4.2; the Coriolis-Lie term of its Theorem 4 enters once.

    Examples
    --------
    >>> turntable = [np.array([0, 0, 1, 0, 0, 0]), np.zeros(6, dtype=int)]
    >>> sliding = [np.array([0, 0, 0, 1, 0, 0]), np.zeros(6, dtype=int)]
    >>> compose(turntable, sliding)[1]
    array([0, 0, 0, 0, 1, 0])

    """
    outer, inner = _six_vectors(outer), _six_vectors(inner)
    total = []
    carried = [body_fixed_derivatives(outer, y, len(inner) - m) for m, y in enumerate(inner)]
    for n, x in enumerate(outer[:len(inner)], start=1):
        total.append(x + sum(comb(n - 1, k) * carried[n - 1 - k][k] for k in range(n)))
    return total


def relative(total: Sequence[Array], observer: Sequence[Array]) -> list[Array]:
    """
    Return the states of a body as observed from another moving body.

    The inverse of :func:`compose`: ``compose(observer, relative(total, observer))`` is
    ``total``.

    Parameters
    ----------
    total : sequence of array, shape (..., 6)
        Reduced states of the observed body of order 1 to N.
    observer : sequence of array, shape (..., 6)
        Reduced states of the observing body of order 1 to N.

    Returns
    -------
    list of N arrays, shape (..., 6)
        All about one pole, in one set of axes.

    Raises
    ------
    ShapeError, InvalidValueError
        A state is no six-vector of numbers or symbols.

    Examples
    --------
    Two bodies at rest, seen from a turntable, turn about its axis backwards.

    >>> relative([np.zeros(6, dtype=int)], [np.array([0, 0, 1, 0, 0, 0])])[0]
    array([ 0,  0, -1,  0,  0,  0])

    """
    total, observer = _six_vectors(total), _six_vectors(observer)
    return _seen_from([z - x for z, x in zip(total, observer)], observer)


def body_derivatives(states: Sequence[Array]) -> list[Array]:
    """
    Return the twist in the body's own axes and the derivatives of its components.

    The trap of body-fixed components: their first derivative is the reduced acceleration
    in body axes, because [V, V] = 0, but the second is not the jerk: it is J - [V, A]; the
    third is S - 2 [V, J] + [V, [V, A]]. An integrator or a differentiator that works on
    tool-frame twists deals with these, not with the states.

    Parameters
    ----------
    states : sequence of array, shape (..., 6)
        Reduced states of order 1 to N, pole at a point of the body, in any axes.

    Returns
    -------
    list of N arrays, shape (..., 6)
        Derivatives of order 0 to N-1 of the body-fixed components of the twist about the
        body point at the pole, written in the axes of ``states`` (in the body's own axes,
        where they are plain derivatives, if ``states`` were).

    Raises
    ------
    ShapeError, InvalidValueError
        A state is no six-vector of numbers or symbols.

    Examples
    --------
    >>> twist = np.array([0, 0, 1, 0, 0, 0])
    >>> accel = np.array([1, 0, 0, 0, 0, 0])
    >>> body_derivatives([twist, accel, np.zeros(6, dtype=int)])[2]
    array([ 0, -1,  0,  0,  0,  0])

    """
    states = _six_vectors(states)
    return _seen_from(states, states)


def _six_vectors(states: Sequence[Any]) -> list[Array]:
    return [checked_array(f'state of order {n}', x, (..., 6))
            for n, x in enumerate(states, start=1)]


def _seen_from(derivatives: Sequence[Array], observer: Sequence[Array]) -> list[Array]:
    """Return the derivatives, as a moving observer sees them, of a field given in space."""
    seen: list[Any] = []
    carried: list[list[Array]] = []
    for n, x in enumerate(derivatives):
        moved = sum(comb(n, k) * carried[n - k][k] for k in range(1, n + 1))
        seen.append(x - moved)
        carried.append(body_fixed_derivatives(observer, seen[-1], len(derivatives) - n))
    return seen
