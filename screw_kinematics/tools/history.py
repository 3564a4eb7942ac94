# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Time histories of a tip's states, from wherever they come."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .motions import ReferenceMotion
from ..errors import UnknownNameError
from ..se3 import Array

ORDERS = {'twist': 1, 'accel': 2, 'reduced_accel': 2, 'jerk': 3, 'reduced_jerk': 3,
          'snap': 4, 'reduced_snap': 4}
QUANTITIES = ('pose', *ORDERS)


@dataclass(frozen=True)
class History:
    """
    States of a tip over time.

    Parameters
    ----------
    name : str
        Of the robot and its motion, for titles.
    base_frame, tip_frame : str
        Frames; axes are the base's and the reference point is the tip's origin.
    time : array, shape (N,)
        In s.
    values : mapping of str to array
        'pose' (N, 4, 4); all others (N, 6), angular first, in SI units.
    start : int
        Epoch time of ``time`` 0 [ns].

    """

    name: str
    base_frame: str
    tip_frame: str
    time: Array
    values: Mapping[str, Array]
    start: int = 0


def of_motion(robot: Any, motion: ReferenceMotion, time: Array, quantities: Sequence[str],
              name: str = '') -> History:
    """
    Return the exact states of a robot in a reference motion.

    Parameters
    ----------
    robot : SerialChain
        With measured joints as the motion has them.
    motion : ReferenceMotion
        Known exactly.
    time : array, shape (N,)
        Instants [s].
    quantities : sequence of str
        Any of ``QUANTITIES``.
    name : str
        For titles.

    Raises
    ------
    UnknownNameError
        A quantity is not one of them.

    """
    for quantity in quantities:
        if quantity not in QUANTITIES:
            raise UnknownNameError('quantity', quantity, QUANTITIES)
    order = max((ORDERS[q] for q in quantities if q != 'pose'), default=0)
    state = robot.state(*motion.derivatives(time, order))
    values = {}
    for quantity in quantities:
        if quantity == 'pose':
            values[quantity] = state.pose
        elif quantity.startswith('reduced'):
            values[quantity] = state.reduced[ORDERS[quantity] - 1]
        else:
            values[quantity] = state.classical(ORDERS[quantity])
    return History(name or robot.name, robot.base_frame, robot.tip_frame,
                   np.asarray(time, dtype=float), values)
