# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""From a twist that is measured in the body's own axes to the body's states."""
from __future__ import annotations

from collections.abc import Sequence
from math import comb

from .se3 import Array
from .states import body_fixed_derivatives
from .vectors import checked_array

__all__ = ['states_from_body_derivatives']


def states_from_body_derivatives(derivatives: Sequence[Array]) -> list[Array]:
    """
    Return reduced states from the body-fixed components of a twist and their derivatives.

    With u the components, ``V = u``, ``A = u'``, ``J = u'' + [V, A]``,
    ``S = u''' + 2 [V, J] - [V, [V, A]]``, and so on: the inverse of
    :func:`~screw_kinematics.screws.states.body_derivatives`. It is what odometry and
    gyroscopes need, which measure in axes that turn with the body.

    Parameters
    ----------
    derivatives : sequence of array, shape (..., 6)
        Derivatives of order 0 to N-1 of the components of the twist in the body's axes, about
        a point of the body.

    Returns
    -------
    list of N arrays, shape (..., 6)
        Reduced states of order 1 to N about that point, in the body's axes as they now are.

    Raises
    ------
    ShapeError, InvalidValueError
        A derivative is no six-vector of numbers or symbols.

    References
    ----------
    The paper, section 2.4.2: a field that is fixed in a moving body changes by Lie products.

    Examples
    --------
    A car that gathers speed in a bend: its jerk is lateral though no derivative of u is.

    >>> import numpy as np
    >>> twist = np.array([0, 0, 1, 2, 0, 0])
    >>> rest = np.zeros(6, dtype=int)
    >>> states_from_body_derivatives([twist, np.array([0, 0, 0, 1, 0, 0]), rest])[2]
    array([0, 0, 0, 0, 1, 0])

    """
    seen = [checked_array(f'derivative {n}', y, (..., 6)) for n, y in enumerate(derivatives)]
    states: list[Array] = []
    for n, y in enumerate(seen):
        moved = sum(comb(n, k) * body_fixed_derivatives(states, seen[n - k], k + 1)[k]
                    for k in range(1, n + 1))
        states.append(y + moved)
    return states
