# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joints that follow others that follow others: the measured one at the end."""
from __future__ import annotations

from collections.abc import Callable
import math

from .fields import listed
from ..chains.joint import Mimic
from ..errors import ModelError

MAX_FOLLOWED = 50


def followed_joint(source: str, name: str, rule: Callable[[str], Mimic | None]
                   ) -> Mimic | None:
    """
    Return how a joint depends on a measured one.

    Parameters
    ----------
    source : str
        File or topic, for messages.
    name : str
        The joint.
    rule : callable
        Gives for a joint's name what it follows directly, or None if it is measured.

    Returns
    -------
    Mimic or None
        None if the joint itself is measured.

    Raises
    ------
    ModelError
        Joints follow each other in a circle, in too long a line, or with a product of
        multipliers that is not finite.

    Examples
    --------
    >>> rules = {'b': Mimic('a', 2.0, 1.0), 'c': Mimic('b', 3.0, 0.5)}
    >>> found = followed_joint('doc', 'c', rules.get)
    >>> found.joint, found.multiplier, found.offset
    ('a', 6.0, 3.5)

    """
    multiplier, offset = 1.0, 0.0
    line = [name]
    while (step := rule(line[-1])) is not None:
        offset += multiplier * step.offset
        multiplier *= step.multiplier
        if not math.isfinite(offset) or not math.isfinite(multiplier):
            raise ModelError(source, f'joint {name!r}: mimic: got multiplier {multiplier}, '
                             f'offset {offset}; allowed: finite numbers')
        if step.joint in line or len(line) > MAX_FOLLOWED:
            raise ModelError(source, f'joint {name!r}: mimic: got {listed([*line, step.joint])}; '
                             f'allowed: a line of at most {MAX_FOLLOWED} joints, no circle')
        line.append(step.joint)
    return None if len(line) == 1 else Mimic(line[-1], multiplier, offset)
