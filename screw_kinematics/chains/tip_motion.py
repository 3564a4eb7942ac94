# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The tip's motion, gathered from the tip to the base.

What the compiled programs compute: the same states as :func:`states.chain_states`, from
fewer operations. Seen from the body before a joint, the tip's position is the position
seen from the body behind it, turned by the joint. Its derivatives follow by Leibniz' rule
in the plane across the joint's axis. Nothing is rotated back, no moment is shifted, and
near the tip almost everything is still zero; at the base the derivatives are the classical
ones in base axes. For a 7R arm it takes three fifths of the operations of the recursion from
base to tip.
"""
from __future__ import annotations

from math import comb
from typing import Any, TYPE_CHECKING

import numpy as np

from .elementary_transforms import Derivatives, Translation, transform_sequence
from ..screws.se3 import Array, cos, cross, sin

if TYPE_CHECKING:
    from .serial_chain import SerialChain


def tip_motion(chain: SerialChain, q: Array, *derivatives: Array) -> tuple[Array, list[Array]]:
    """
    Return pose and classical motion of the tip, pole at the tip, axes of the base.

    From traced positions and derivatives: ``[w; v]``, ``[alpha; a]``, ... as many as there are
    derivatives.
    """
    motion = [chain.joint_values(d, n) for n, d in enumerate((q, *derivatives))]
    joints = [[values[i] for values in motion] for i in range(len(chain.joints))]
    path = transform_sequence(chain, joints)
    position: Derivatives = [_zeros() for _ in motion]
    angular: Derivatives = [_zeros() for _ in derivatives]
    # Two columns and a cross product cost less than three columns.
    axis = path.turns[-1].axis if path.turns else 2
    order = np.argsort(-np.abs(path.orientation[axis]), kind='stable')
    kept = list(order) if len(path.turns) < 3 else list(order[:2])
    columns = {int(k): path.orientation[:, k].astype(object) for k in kept}
    waiting: Array = np.zeros(3)    # a constant part of the position, not yet added
    for turn in reversed(path.turns):
        total = turn.angles[-1]
        waiting = _add_translation(position, turn.translations[-1], waiting, turn.axis)
        position = _turned(position, turn.axis, total)
        for angle, translation in zip(turn.angles[:-1], turn.translations[:-1]):
            waiting = waiting + _add_turned_translation(position, translation, turn.axis, angle)
        angular = _turned(angular, turn.axis, total)
        for n, rate in enumerate(total[1:]):
            angular[n][turn.axis] = angular[n][turn.axis] + rate
        columns = {k: _turned([c], turn.axis, total)[0] for k, c in columns.items()}
    _add_translation(position, path.base, waiting, None)
    pose = np.zeros((4, 4), dtype=object)
    pose[3, 3] = 1
    for k, column in columns.items():
        pose[:3, k] = column
    for k in set(range(3)) - set(columns):
        pose[:3, k] = cross(pose[:3, (k + 1) % 3], pose[:3, (k + 2) % 3])
    pose[:3, 3] = position[0]
    return pose, [np.concatenate([w, p]) for w, p in zip(angular, position[1:])]


def _add_translation(position: Derivatives, translation: Translation, waiting: Array,
                     axis: int | None) -> Array:
    """
    Add a translation to the position in place, and return what is left to be added later.

    A constant along the axis of the turn to come is not changed by it. It waits, and is
    added together with the constants of later translations.
    """
    constant = waiting + translation.constant
    later = np.zeros(3)
    if axis is not None:
        later[axis] = constant[axis]
    for direction, amount in translation.moving:
        for n, value in enumerate(amount):
            position[n] = position[n] + value * direction
    position[0] = position[0] + (constant - later)
    return later


def _add_turned_translation(position: Derivatives, translation: Translation, axis: int,
                            angle: Derivatives) -> Array:
    """Add a translation from within a turn, and return what is left to be added later."""
    vector: Derivatives = [_zeros() for _ in position]
    later = _add_translation(vector, translation, np.zeros(3), axis)
    for n, term in enumerate(_turned(vector, axis, angle)):
        position[n] = position[n] + term
    return later


def _turned(vector: Derivatives, axis: int, angle: Derivatives) -> Derivatives:
    """
    Return the derivatives of a vector after a turn of its axes that itself changes.

    With y_n(m) the n-th derivative of the turned m-th derivative, and e the axis,
    ``y_n(m) = y_0(m+n) + sum_k phi^(k+1) e x sum_{h>=k} C(h, k) y_{h-k}(m+n-1-h)``.
    """
    s, c = sin(angle[0]), cos(angle[0])
    i, j = (axis + 1) % 3, (axis + 2) % 3
    highest = len(vector) - 1
    table: list[list[Any]] = [[]]
    for x in vector:
        y = x.copy()
        y[i], y[j] = c * x[i] - s * x[j], s * x[i] + c * x[j]
        table[0].append(y)
    for n in range(1, highest + 1):
        table.append([])
        for m in range(highest + 1 - n):
            y = table[0][m + n].copy()
            for k in range(n):
                a, b = (sum(comb(h, k) * table[h - k][m + n - 1 - h][across]
                            for h in range(k, n)) for across in (i, j))
                y[i] = y[i] - angle[k + 1] * b
                y[j] = y[j] + angle[k + 1] * a
            table[n].append(y)
    return [row[0] for row in table] if table[0] else []


def _zeros() -> Array:
    return np.zeros(3, dtype=object)
