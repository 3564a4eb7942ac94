# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Time histories of a tip's states, from wherever they come."""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..programs.quantities import SIX_VECTORS
from ..screws.rotations import pose, rotation_from_quaternion
from ..screws.se3 import Array

QUANTITIES = ('pose', *(quantity.name for quantity in SIX_VECTORS))


@dataclass(frozen=True)
class History:
    """States of a tip over time, about its origin in axes of the base."""

    name: str                      # of the robot and its motion, for titles
    base_frame: str
    tip_frame: str
    time: Array                    # (N,) [s]
    values: Mapping[str, Array]    # 'pose' (N, 4, 4); others (N, 6), angular first, in SI units
    start: int = 0                 # epoch time of time 0 [ns]

    @classmethod
    def of_rows(cls, name: str, base_frame: str, tip_frame: str, stamps: Array,
                rows: Mapping[str, Array]) -> History:
        """Return the history of rows as messages have them: of a pose (N, 7), stamps in ns."""
        values = {quantity: row if quantity != 'pose' else pose(
            rotation_from_quaternion(row[:, 3:]), row[:, :3]) for quantity, row in rows.items()}
        return cls(name, base_frame, tip_frame, (stamps - stamps[0]) * 1e-9, values,
                   int(stamps[0]))
