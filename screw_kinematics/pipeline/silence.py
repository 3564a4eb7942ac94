# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Which groups of joints are not heard of any more."""
from __future__ import annotations

from collections.abc import Iterable

from .joint_groups import JointGroup


class Silence:
    """
    Watches the message counts of groups.

    Examples
    --------
    >>> group, silence = JointGroup((0,), True), Silence()
    >>> [silence.of([group], now, timeout=0.5) == [group] for now in (0.0, 0.25, 0.5, 0.75)]
    [False, False, False, True]

    """

    def __init__(self) -> None:
        self._heard: dict[JointGroup, tuple[int, float, float]] = {}

    def of(self, groups: Iterable[JointGroup], now: float, timeout: float) -> list[JointGroup]:
        """
        Return the groups that brought no message for too long.

        Parameters
        ----------
        groups : iterable of JointGroup
            All present groups.
        now : float
            Any clock [s].
        timeout : float
            Longest silence [s].

        """
        heard, silent = {}, []
        for group in groups:
            messages, last, silence = self._heard.get(group, (-1, now, 0.0))
            # A long time between two calls tells little: messages may be waiting to be taken.
            silence = silence + min(now - last, timeout / 2) if messages == group.messages else 0.0
            if silence > timeout:
                silent.append(group)
            else:
                heard[group] = group.messages, now, silence
        self._heard = heard
        return silent

    def clear(self) -> None:
        """Begin anew, as after a jump of the clock."""
        self._heard.clear()
