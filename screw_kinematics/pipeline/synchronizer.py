# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joint motions that arrive group by group, brought together at one instant."""
from __future__ import annotations

from collections.abc import Iterable
from math import factorial, nan

from .group_motion import Motion
from .joint_groups import JointGroup
from ..errors import Reason

KEPT_UP = 10
"""A group that came in so many rounds in a row, and is no older than they, does not lag."""


class Synchronizer:
    """
    Collects the motions of several groups and joins them.

    A round is complete when every group has arrived since the last one. A group that arrives twice
    in a round does not wait for the others: they lag from then on, until they do the same or have
    kept up for many rounds in a row, and are carried on to the present by their derivatives. The
    instant of a round is that of the oldest motion among the groups that do not lag, since going
    back in time a little is more exact than going on.

    Examples
    --------
    >>> a, b = JointGroup((0,), False), JointGroup((1,), False)
    >>> synchronizer = Synchronizer(2, max_apart_ns=10**9)
    >>> synchronizer.add(a, Motion(10**9, [1.0, 2.0]))
    <Reason.JOINTS_MISSING: 'other_joints_missing'>
    >>> synchronizer.add(b, Motion(1_500_000_000, [0.5, 1.0]))      # at 1 s it was at 0
    Motion(stamp_ns=1000000000, values=[1.0, 0.0, 2.0, 1.0], variances=())

    """

    def __init__(self, n_joints: int, max_apart_ns: int = 500_000_000) -> None:
        self._max_apart_ns = max_apart_ns
        self._n_joints = n_joints
        self._parts: dict[JointGroup, Motion] = {}
        self._fresh: set[JointGroup] = set()
        self._lagging: dict[JointGroup, int] = {}
        """For each group that lags how many rounds in a row it has kept up."""
        self._at = 0
        """The instant of the round before [ns]."""

    def add(self, group: JointGroup, motion: Motion) -> Motion | Reason:
        """Take the motion of some joints; return that of all, or why there is none."""
        repeated = group in self._fresh
        before = self._parts.get(group)
        self._parts[group] = motion
        if self._lagging.get(group) == KEPT_UP:     # it comes behind the others: of their round
            del self._lagging[group]
            return Reason.MERGED
        self._fresh.add(group)
        if sum(len(g.columns) for g in self._parts) < self._n_joints:
            return Reason.JOINTS_MISSING
        behind = self._behind(group, before, motion)
        if repeated:
            self._lagging = dict.fromkeys(self._parts.keys() - self._fresh, 0)
        elif group in self._lagging or self._parts.keys() - self._fresh - self._lagging.keys():
            return Reason.MERGED
        elif behind - self._lagging.keys():
            self._fresh = {group}
            return Reason.MERGED
        self._take_back(behind)
        self._fresh.clear()
        return self._join()

    def _take_back(self, behind: set[JointGroup]) -> None:
        """
        Wait again for groups that have kept up; for those behind the others from the next on.

        One that is older than the round before would take the instant back to its own.

        """
        counted = {
            group: n + 1 if group in self._fresh and self._parts[group].stamp_ns >= self._at else 0
            for group, n in self._lagging.items()}
        self._lagging = {group: n for group, n in counted.items()
                         if n < KEPT_UP or group in behind}

    def _behind(self, group: JointGroup, before: Motion | None, now: Motion) -> set[JointGroup]:
        """Return whose parts belong to the round before, by a group that has come again."""
        if before is None:
            return set()
        stamps = {other: self._parts[other].stamp_ns for other in self._fresh if other != group}
        return {other for other, stamp in stamps.items()
                if 2 * abs(stamp - before.stamp_ns) < abs(stamp - now.stamp_ns)}

    def keep(self, groups: Iterable[JointGroup]) -> None:
        """Forget all groups but these, and await their joints again."""
        kept = set(groups)
        self._parts = {group: part for group, part in self._parts.items() if group in kept}
        self._fresh &= kept
        self._lagging = {group: n for group, n in self._lagging.items() if group in kept}

    def clear(self) -> None:
        """Await all joints again."""
        self._parts.clear()
        self._fresh.clear()
        self._lagging.clear()

    def _join(self) -> Motion | Reason:
        instant = min(self._parts[g].stamp_ns for g in self._parts.keys() - self._lagging.keys())
        self._at, n = instant, self._n_joints
        orders = min(len(m.values) // len(g.columns) for g, m in self._parts.items())
        joined = [0.0] * (orders * n)
        known = any(motion.variances for motion in self._parts.values())
        variances = [nan] * (4 * n if known else 0)
        for group, motion in self._parts.items():
            if abs(instant - motion.stamp_ns) > self._max_apart_ns:
                return Reason.TOO_FAR_APART
            dt = (instant - motion.stamp_ns) * 1e-9
            powers = [dt**k / factorial(k) for k in range(orders)]
            width, unsure = len(group.columns), motion.variances_after(dt)
            for i, column in enumerate(group.columns):
                own = motion.values[i:orders * width:width]
                for k in range(orders):
                    joined[k * n + column] = sum(
                        p * x for p, x in zip(powers, own[k:]))
                if unsure:
                    variances[column::n] = unsure[i::width]
        # Groups have clocks of their own: what they do not know is not common to them.
        return Motion(instant, joined, variances or ())
