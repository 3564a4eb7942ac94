# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joint motions that arrive group by group, brought together at one instant."""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import factorial

from .joint_groups import JointGroup

TOO_FAR_APART = 'joints_too_far_apart_in_time'


class Rounds:
    """
    Collects the motions of several groups and joins them.

    A round is complete when every group has arrived since the last one. A group that arrives
    twice in a round does not wait for the others: they lag from then on, until they do the
    same, and are carried on to the present by their derivatives. The instant of a round is
    that of the oldest motion among the groups that do not lag, since going back in time a
    little is more exact than going on.

    Parameters
    ----------
    n_joints : int
    max_apart_ns : int, optional
        Motions further apart in time than this are not joined [ns].

    Examples
    --------
    >>> a, b = JointGroup((0,), False), JointGroup((1,), False)
    >>> rounds = Rounds(2, max_apart_ns=10**9)
    >>> rounds.add(a, 10**9, [1.0, 2.0])
    >>> rounds.add(b, 1_500_000_000, [0.5, 1.0])    # at 1 s it was at 0
    (1000000000, [1.0, 0.0, 2.0, 1.0])

    """

    def __init__(self, n_joints: int, max_apart_ns: int = 500_000_000) -> None:
        self.max_apart_ns = max_apart_ns
        self._n_joints = n_joints
        self._parts: dict[JointGroup, tuple[int, Sequence[float]]] = {}
        self._fresh: set[JointGroup] = set()
        self._lagging: set[JointGroup] = set()

    def add(self, group: JointGroup, stamp_ns: int, motion: Sequence[float],
            ) -> tuple[int, list[float]] | str | None:
        """
        Take the motion of one group.

        Parameters
        ----------
        group : JointGroup
            Whose motion it is.
        stamp_ns : int
            The instant the motion describes [ns].
        motion : sequence of float
            Positions of the group's joints, then velocities, ...

        Returns
        -------
        (int, list of float), str, or None
            Instant [ns] and motion of all joints, in the order of the robot; the reason why
            it was refused; None while joints are awaited.

        """
        repeated = group in self._fresh
        self._parts[group] = (stamp_ns, motion)
        self._fresh.add(group)
        if sum(len(g.columns) for g in self._parts) < self._n_joints:
            return None
        if repeated:
            self._lagging = self._parts.keys() - self._fresh
        elif group in self._lagging or self._parts.keys() - self._fresh - self._lagging:
            return None
        return self._join()

    def keep(self, groups: Iterable[JointGroup]) -> None:
        """Forget all groups but these, and await their joints again."""
        kept = set(groups)
        self._parts = {group: part for group, part in self._parts.items() if group in kept}
        self._fresh &= kept
        self._lagging &= kept

    def clear(self) -> None:
        """Await all joints again."""
        self._parts.clear()
        self._fresh.clear()
        self._lagging.clear()

    def _join(self) -> tuple[int, list[float]] | str:
        self._fresh.clear()
        instant = min(self._parts[g][0] for g in self._parts.keys() - self._lagging)
        n = self._n_joints
        orders = min(len(m) // len(g.columns) for g, (_, m) in self._parts.items())
        joined = [0.0] * (orders * n)
        for group, (stamp_ns, motion) in self._parts.items():
            if abs(instant - stamp_ns) > self.max_apart_ns:
                return TOO_FAR_APART
            dt = (instant - stamp_ns) * 1e-9
            powers = [dt**k / factorial(k) for k in range(orders)]
            width = len(group.columns)
            for i, column in enumerate(group.columns):
                own = motion[i:orders * width:width]
                for k in range(orders):
                    joined[k * n + column] = sum(
                        p * x for p, x in zip(powers, own[k:]))
        return instant, joined
