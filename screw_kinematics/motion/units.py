# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether positions are in rad and m, and turn on where they seem to jump by a whole turn."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .joint_motion import Array

_TURNS = 4 * math.pi    # no limited joint turns further [rad]
_REACH = 20.0           # nor is a slide longer [m]
WRAP = 0.35             # a jump is a wrap if it is a turn but for this [rad]
_LARGE = 1000.0         # whole numbers beyond are ticks, others may be degrees or mm

TURNS_ON = "declare it 'continuous' in the model, or let the driver count its turns"
"""What to do about a joint that wraps."""


class UnitDoubt(NamedTuple):
    """What is odd about the positions of a joint, and what they may be instead."""

    problem: str
    advice: str


def unit_doubts(position: Array, kind: str = '') -> list[UnitDoubt]:
    """
    Return what the size and the jumps of positions say against their unit and the joint's kind.

    Positions, shape (N,), are of one joint [rad, m]; what is not finite is passed over. Its kind
    is as in :class:`~screw_kinematics.Joint`; empty: not known.

    Examples
    --------
    >>> unit_doubts(np.array([0.0, 45.5, 90.0]), 'revolute')[0].advice
    'are these degrees?: positions must be in rad'
    >>> unit_doubts(np.array([0.0, 0.8, 1.6]), 'revolute')
    []

    """
    position = position[np.isfinite(position)]
    if not len(position):
        return []
    largest, steps = float(np.abs(position).max()), np.abs(np.diff(position))
    whole = bool((position == np.rint(position)).all())
    if kind == 'prismatic':
        if largest <= _REACH:
            return []
        return [UnitDoubt(f'is a slide and reaches {largest:.4g} m', _meant(whole, largest, 'm'))]
    doubts = []
    for turn, unit in ((2 * math.pi, 'rad'), (360.0, 'degrees')):
        wraps = int((np.abs(steps - turn) < WRAP * turn / (2 * math.pi)).sum())
        # Ticks of an encoder step by turns of a radian all the time.
        rare = wraps > 0 and np.median(steps) < turn / 20
        if rare and (unit == 'rad' or largest > _TURNS) and kind != 'continuous':
            doubts.append(UnitDoubt(
                f'jumps by a whole turn, {turn:.4g}, {times(wraps)}',
                TURNS_ON))
            break
    # A continuous joint may turn on for ever, but not in whole numbers, nor wrap at 360.
    in_degrees = bool((np.abs(steps - 360) < 20).any()) and largest < 365
    if (largest > _TURNS if kind else largest > _REACH) and (
            kind != 'continuous' or whole or in_degrees):
        doubts.append(UnitDoubt(
            f'reaches {largest:.4g} rad, {largest / (2 * math.pi):.1f} turns' if kind
            else f'reaches {largest:.4g} rad or m',
            _meant(whole, largest, 'rad' if kind else 'rad or m')))
    return doubts


def _meant(whole: bool, largest: float, unit: str) -> str:
    """Return what numbers may be that are too large."""
    other = {'m': 'mm', 'rad': 'degrees'}.get(unit, 'degrees or mm')
    if whole and largest > _LARGE:
        guess = 'these are whole numbers, of an encoder'
    elif whole:
        guess = f'are these ticks of an encoder, or {other}?'
    else:
        guess = f'are these {other}?'
    return f'{guess}: positions must be in {unit}'


def times(count: int) -> str:
    """
    Return how often something was, in words that fit.

    Examples
    --------
    >>> times(1), times(3)
    ('once', '3 times')

    """
    return 'once' if count == 1 else f'{count} times'
