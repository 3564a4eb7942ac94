# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The reference points (poles) and axes a six-vector can have, by name."""
from __future__ import annotations

from .vectors import Array, checked_array
from ..errors import UnknownNameError

__all__ = ['FRAMES', 'check_axes', 'resolve_pole']

FRAMES = ('base', 'tip')


def resolve_pole(pole: str | Array, pose: Array) -> tuple[str, Array]:
    """
    Return the name and the base coordinates of a pole.

    Parameters
    ----------
    pole : 'base', 'tip' or array, shape (..., 3)
        Origin of the base, origin of the tip frame, or a point in base coordinates [m].
    pose : array, shape (..., 4, 4)
        T_base_tool.

    Returns
    -------
    name : str
        'base', 'tip' or 'point'.
    point : array, shape (..., 3)
        In base coordinates [m].

    Raises
    ------
    UnknownNameError, ShapeError
        There is no such pole, or the point has not three coordinates.

    """
    if isinstance(pole, str):
        if pole not in FRAMES:
            raise UnknownNameError('pole', pole, FRAMES)
        tip = pose[..., :3, 3]
        return pole, tip if pole == 'tip' else 0 * tip
    return 'point', checked_array('pole', pole, (..., 3))


def check_axes(axes: str) -> None:
    """
    Refuse axes that are neither those of the base nor those of the tip.

    Parameters
    ----------
    axes : str
        Allowed are 'base' and 'tip'.

    Raises
    ------
    UnknownNameError
        There are no such axes.

    """
    if axes not in FRAMES:
        raise UnknownNameError('axes', axes, FRAMES)
