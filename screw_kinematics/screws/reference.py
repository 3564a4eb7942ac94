# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The reference points (poles) and axes a six-vector can have, by name."""
from __future__ import annotations

from .vectors import Array, checked_array
from ..errors import UnknownNameError

FRAMES = ('base', 'tip')


def resolve_pole(pole: str | Array, pose: Array) -> tuple[str, Array]:
    """Return the name ('point' of one that is given) and the base coordinates [m] of a pole."""
    if isinstance(pole, str):
        if pole not in FRAMES:
            raise UnknownNameError('pole', pole, FRAMES)
        tip = pose[..., :3, 3]
        return pole, tip if pole == 'tip' else 0 * tip
    return 'point', checked_array('pole', pole, (..., 3))


def check_axes(axes: str) -> None:
    """Raise UnknownNameError for axes that are neither those of the base nor those of the tip."""
    if axes not in FRAMES:
        raise UnknownNameError('axes', axes, FRAMES)
