# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The home posture: where a parallel manipulator's structure is found out."""
from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .limbs import Limbs
from .loop_closure import close_loops, Solution
from .screw_system import ScrewSystem
from .structure import RANK_TOLERANCE
from ..errors import InvalidValueError, UnknownNameError


def close_at_home(limbs: Limbs, home: Mapping[str, float]) -> Solution:
    """
    Return where the loops close near given joint positions, if they do.

    Parameters
    ----------
    limbs : Limbs
        What to close.
    home : mapping from str to float
        Joint positions [rad, m]; 0 for joints not named.

    Raises
    ------
    UnknownNameError
        There is no joint of a given name.

    """
    for name in home:
        if name not in limbs.joint_names:
            raise UnknownNameError('joint in the home posture:', name, limbs.joint_names)
    return close_loops(limbs, np.array([float(home.get(n, 0.0)) for n in limbs.joint_names]))


def mobility_at_home(limbs: Limbs, system: ScrewSystem) -> int:
    """
    Return the freedoms of the platform together with the actuated joints.

    Parameters
    ----------
    limbs : Limbs
        What moves.
    system : ScrewSystem
        At home.

    Raises
    ------
    InvalidValueError
        The actuators do not hold the platform.

    """
    mobility = system.mobility()
    if system.direct_conditioning < RANK_TOLERANCE:
        raise InvalidValueError(
            f'with the actuated joints {", ".join(limbs.actuated)} locked the platform can '
            f'still move at home: {len(limbs.actuated)} of them for mobility {mobility}, or a '
            'singular home posture')
    return mobility
