# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Velocity, reduced acceleration, jerk and jounce states of bodies in a chain.

The state of order n, X_n, is the (n-1)-th time derivative of the spatial twist at a
space-fixed pole: X_1 = V = (w ; v), X_2 = A = (alpha ; a - w x v), and so on. All of them
are helicoidal fields, so one rule moves any of them to another pole.
"""
from __future__ import annotations

from collections.abc import Sequence
from math import comb
from typing import Any

import numpy as np

from .se3 import Array, cross, lie_product


def chain_states(screws: Sequence[Array], derivatives: Sequence[Array]) -> list[Array]:
    """
    Return the states of the last body of an open chain, of order 1 to N.

    For joint i with present unit screw ``$`` and the states X of body i-1::

        D_0 = $,   D_k = sum_{j<k} C(k-1, j) [X_{j+1}, D_{k-1-j}]
        X_n(i) = X_n(i-1) + sum_{k<n} C(n-1, k) q_i^(n-k) D_k

    which holds for every order and contains the paper's Coriolis-Lie term.

    Parameters
    ----------
    screws : sequence of array, shape (..., 6)
        Present unit screws of the joints from base to tip, about one pole, in one set
        of axes.
    derivatives : sequence of array, shape (..., n)
        Joint rates, accelerations, ... (first, second, ... derivative), N of them.

    Returns
    -------
    list of N arrays, shape (..., 6)
        Reduced states about the pole of the screws, in their axes.

    References
    ----------
    The paper, sections 3.1 and 3.2 for order 1 and 2.

    Examples
    --------
    >>> screw = np.array([0, 0, 1, 0, -1, 0])
    >>> chain_states([screw], [np.array([2]), np.array([3])])[1]
    array([ 0,  0,  3,  0, -3,  0])

    """
    order = len(derivatives)
    states: list[Any] = [None] * order
    for i, screw in enumerate(screws):
        rates = [np.asarray(d[..., i])[..., None] for d in derivatives]
        transported: list[Any] = [screw]
        if i > 0:
            for k in range(1, order):
                transported.append(sum(
                    comb(k - 1, j) * lie_product(states[j], transported[k - 1 - j])
                    for j in range(k)))
        # The base is at rest: the first joint's screw does not change.
        for n in range(1, order + 1):
            added = sum(
                comb(n - 1, k) * rates[n - k - 1] * transported[k]
                for k in range(min(n, len(transported))))
            states[n - 1] = added if i == 0 else states[n - 1] + added
    if not screws:
        return [np.zeros(np.shape(d)[:-1] + (6,)) for d in derivatives]
    return states


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

    Examples
    --------
    Uniform rotation about z, point at x = 1: centripetal acceleration -1.

    >>> float(classical_from_reduced([np.array([0, 0, 1, 0, 1, 0]), np.zeros(6)])[1][3])
    -1.0

    """
    angular = [np.asarray(x)[..., :3] for x in states]
    linear: list[Array] = []
    for n, state in enumerate(states, start=1):
        point = np.asarray(state)[..., 3:]
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

    Examples
    --------
    >>> twist = np.array([0, 0, 1, 0, 1, 0])
    >>> reduced_from_classical([twist, np.array([0, 0, 0, -1, 0, 0])])[1]
    array([0, 0, 0, 0, 0, 0])

    """
    angular = [np.asarray(x)[..., :3] for x in motions]
    linear = [np.asarray(x)[..., 3:] for x in motions]
    out = []
    for n in range(1, len(motions) + 1):
        dual = linear[n - 1]
        for k in range(1, n):
            dual = dual - comb(n - 1, k) * cross(angular[n - 1 - k], linear[k - 1])
        out.append(np.concatenate([angular[n - 1], dual], axis=-1))
    return out
