# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""From measured joints to all joints of a chain: mimic joints follow others."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .joint import Joint
from ..errors import InvalidValueError
from ..screws.vectors import Array, checked_array


class MimicCoupling:
    """
    How the joints of a chain, from base to tip, depend on the measured ones.

    The latter are in the order of their first use; kind and velocity limit of one outside the
    chain are what its followers say of it.

    Examples
    --------
    >>> from screw_kinematics import Mimic
    >>> left = Joint('left', 'prismatic', axis=(0, 1, 0))
    >>> right = Joint('right', 'prismatic', axis=(0, 1, 0), mimic=Mimic('left', -2, 0.5))
    >>> MimicCoupling([left, right]).values(np.array([0.1]))
    array([0.1, 0.3])

    """

    def __init__(self, joints: Sequence[Joint], owner: str = 'chain') -> None:
        self._owner = owner
        names = [joint.name for joint in joints]
        if len(set(names)) != len(names):
            twice = next(n for n in names if names.count(n) > 1)
            raise InvalidValueError(f'joint {twice!r} occurs more than once in the {owner}')
        following = {joint.name for joint in joints if joint.mimic is not None}
        for joint in joints:
            if joint.mimic is not None and joint.source in following:
                raise InvalidValueError(
                    f'joint {joint.name!r} follows {joint.source!r}, which follows another '
                    'joint itself; a followed joint must be a measured one')
        self.joint_names = tuple(dict.fromkeys(joint.source for joint in joints))
        self.dof = len(self.joint_names)
        self._columns = [self.joint_names.index(joint.source) for joint in joints]
        measured = [measured_as(joints, name) for name in self.joint_names]
        self.joint_kinds = tuple(kind for kind, _ in measured)
        self.prismatic = np.array([kind == 'prismatic' for kind in self.joint_kinds], bool)
        self.velocity_limits = np.array([limit for _, limit in measured], float)
        self._plain = not following
        mimics = [joint.mimic for joint in joints]
        self._multipliers = np.array([1 if m is None else m.multiplier for m in mimics])
        self._offsets = np.array([0 if m is None else m.offset for m in mimics])

    def values(self, q: Any, order: int = 0) -> Array:
        """
        Return the values of all joints of the chain from those of the measured ones, (..., dof).

        Positions, or derivatives, for which the offset does not count.
        """
        what = 'q' if order == 0 else f'derivative {order} of q'
        q = checked_array(f'{what} of {self._owner}', q, (..., self.dof))
        values = q[..., self._columns]
        if self._plain:
            return values
        values = values * self._multipliers
        return values + self._offsets if order == 0 else values

    def columns(self, screws: Sequence[Array]) -> list[Array]:
        """
        Return the six-vectors of unit rates of the measured joints, from the screws of all.

        Each is the joint's own screw and those of its followers, each times its multiplier.
        """
        columns: list[Any] = [None] * self.dof
        for column, multiplier, screw in zip(self._columns, self._multipliers, screws):
            share = screw if self._plain else multiplier * screw
            columns[column] = share if columns[column] is None else columns[column] + share
        return columns


def measured_as(joints: Sequence[Joint], name: str) -> tuple[str, float]:
    """Return kind and velocity limit of a measured joint, by itself or by its followers."""
    own = next((joint for joint in joints if joint.name == name), None)
    if own is not None:
        return own.kind, own.velocity_limit
    followers = [(joint, joint.mimic) for joint in joints
                 if joint.mimic is not None and joint.mimic.joint == name]
    kinds = [mimic.kind for _, mimic in followers if mimic.kind is not None]
    return (kinds[0] if kinds else followers[0][0].kind,
            min(mimic.velocity_limit for _, mimic in followers))
