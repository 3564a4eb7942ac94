# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Denavit-Hartenberg rows as screws.

References
----------
Standard: Denavit and Hartenberg 1955; modified: Craig, Introduction to Robotics, ch. 3.

"""
from __future__ import annotations

from dataclasses import dataclass

from ..screws.rigid import rigid_displacement
from ..screws.rotations import pose, turn
from ..screws.se3 import Array

CONVENTIONS = ('standard', 'modified')


@dataclass(frozen=True)
class DHRow:
    """The numbers of one row, in the letters of both conventions."""

    a: float        # length [m] and twist [rad] of the link along and about x: of the one
    alpha: float    # after the joint (standard) or before it (modified)
    d: float        # offset [m] and angle [rad] along and about the joint's axis z, at q = 0
    theta: float

    def link(self) -> Array:
        """Return the displacement along and about x."""
        return pose(turn('x', self.alpha), (self.a, 0.0, 0.0))

    def joint(self) -> Array:
        """Return the displacement along and about z at q = 0."""
        return pose(turn('z', self.theta), (0.0, 0.0, self.d))


def place_rows(rows: list[DHRow], convention: str,
               T_base_first: Array) -> tuple[list[Array], Array]:    # noqa: N803
    """
    Return the frames whose z axes are the joints' axes, and the last frame, at q = 0.

    Standard: joint first, ``Rz(theta) Tz(d) Tx(a) Rx(alpha)``; modified: link first,
    ``Rx(alpha) Tx(a) Rz(theta) Tz(d)``. The first row starts from T_base_first.

    Examples
    --------
    >>> frames, last = place_rows([DHRow(1, 0, 0, 0)] * 2, 'standard', pose())
    >>> [float(T[0, 3]) for T in frames], float(last[0, 3])
    ([0.0, 1.0], 2.0)

    """
    T, frames = rigid_displacement('T_base_first', T_base_first), []
    for row in rows:
        if convention == 'modified':
            T = T @ row.link()
        frames.append(T)
        T = T @ row.joint()
        if convention == 'standard':
            T = T @ row.link()
    return frames, T
