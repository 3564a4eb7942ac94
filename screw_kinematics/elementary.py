# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
A chain as turns and slides along coordinate axes.

A turn about a coordinate axis changes two components of a vector and costs six
operations, a general rotation fifteen. Between two joints the axes may be chosen freely:
they stay parallel to the base's at q = 0 while joint axes are parallel to them, and are
turned by constant angles where they are not. Such a constant turn about the axis of the
joint before it is no work at all, only an offset of its angle.
"""
from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import atan2
from typing import Any, TYPE_CHECKING

import numpy as np

from .se3 import Array, rotation_about
from .trace import SNAP

if TYPE_CHECKING:
    from .chain import SerialChain


@dataclass(frozen=True, eq=False)
class Turn:
    """
    A turn of the axes about one of them.

    Parameters
    ----------
    axis : {0, 1, 2}
        x, y or z.
    angle : list
        Angle and its time derivatives, constant or traced [rad, rad/s, ...].

    """

    axis: int
    angle: list[Any]


@dataclass(frozen=True, eq=False)
class Slide:
    """
    A shift of the origin.

    Parameters
    ----------
    vector : list of array, shape (3,)
        Displacement in the present axes, and its time derivatives [m, m/s, ...].

    """

    vector: list[Array]


@dataclass(frozen=True, eq=False)
class JointMark:
    """
    Where a joint acts, along an axis of the present frame and through its origin.

    Parameters
    ----------
    index : int
        Number of the joint in the chain.
    axis : {0, 1, 2}
    sign : {-1.0, 1.0}
        Whether the joint's axis points against the frame's.

    """

    index: int
    axis: int
    sign: float


Move = Turn | Slide | JointMark
