# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Axodes: the ruled surfaces that the instantaneous screw axis of a motion sweeps.

One in fixed space and one in the moving body. At each instant they touch along the axis, and
the moving one rolls on the fixed one while it slides along that line by the pitch. In a plane
they are the centrodes, which roll on each other without slipping.

References
----------
O. Bottema, B. Roth, "Theoretical kinematics", 1979, chapter VI.

"""
from __future__ import annotations

import reprlib
from typing import NamedTuple

from .body_state import BodyState
from .screw import Screw, screw_of_twist
from ..errors import InvalidValueError

__all__ = ['Axodes', 'axodes']


class Axodes(NamedTuple):
    """
    The screw axes of a motion, as seen from the base and from the moving body.

    The i-th line of both is the same line of space at instant i.

    Parameters
    ----------
    fixed : Screw
        About the base's origin, in its axes.
    moving : Screw
        About the tip's origin, in its axes.

    """

    fixed: Screw
    moving: Screw


def axodes(motion: BodyState) -> Axodes:
    """
    Return the fixed and the moving axode of a motion.

    Parameters
    ----------
    motion : BodyState
        Many samples, shape (N,), of order 1 at least.

    Returns
    -------
    Axodes
        Lines by their directions and their points that are nearest to the origins, with the
        pitches [m/rad] and the angular speeds [rad/s].

    Raises
    ------
    InvalidValueError
        It is no state of a body, holds no velocity, or one that is not finite.

    Examples
    --------
    A wheel of radius 0.5 m that rolls along x turns about the point where it touches.

    >>> import numpy as np
    >>> pose = np.eye(4)
    >>> pose[:3, 3] = 0, 0.5, 0
    >>> found = axodes(BodyState(pose, (np.array([0, 0, -1, 0.5, 0, 0]),), pose[:3, 3]))
    >>> found.fixed.point, found.moving.point
    (array([0., 0., 0.]), array([ 0. , -0.5,  0. ]))

    """
    if not isinstance(motion, BodyState):
        raise InvalidValueError(f'motion must be a BodyState, got {reprlib.repr(motion)}')
    return Axodes(screw_of_twist(motion.about('base').expressed_in('base').velocity),
                  screw_of_twist(motion.about('tip').expressed_in('tip').velocity))
