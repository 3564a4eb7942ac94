# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Which joints of a robot a message brings, by name.

A robot's joints may arrive in one message or in several ones, from several publishers, at
different rates. The joints that always come together form a *group*; groups never share a
joint. A *layout* says where in a message, with given names, the joints of a group are.
"""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from math import hypot

from ..errors import Reason
from ..messages.joint_state import JointSample

MAX_LAYOUTS = 64
MAX_STRANGERS = 256
LISTED = 8

LARGEST = 1e9
"""Beyond this [rad, m, rad/s, m/s] a number is no measurement."""


class JointGroup:
    """Joints of a robot that come together; their columns are in its order."""

    __slots__ = ('columns', 'complete', 'messages', '_messages_before', '_last', '_silence')

    def __init__(self, columns: tuple[int, ...], complete: bool) -> None:
        self.columns = columns
        self.complete = complete
        self.messages = 0
        self.await_messages()

    def await_messages(self) -> None:
        """Begin to measure silence anew."""
        self._messages_before, self._last, self._silence = -1, 0.0, 0.0

    def is_stale(self, now: float, timeout: float) -> bool:
        """Return whether no message came for too long, where this is asked regularly."""
        if self.messages != self._messages_before:
            self._messages_before, self._silence = self.messages, 0.0
        else:
            # A long time between two calls tells little: messages may be waiting to be taken.
            self._silence += min(now - self._last, timeout / 2)
        self._last = now
        return self._silence > timeout


class NameLayout:
    """Where the joints of a group are in a message with so many names: an index for each."""

    __slots__ = ('group', 'length', '_entries', '_as_it_is')

    def __init__(self, group: JointGroup, entries: tuple[int, ...], length: int) -> None:
        self.group = group
        self.length = length
        self._entries = entries
        self._as_it_is = entries == tuple(range(length))

    def select(self, values: Sequence[float]) -> Sequence[float]:
        """Return the values of the group's joints, in its order."""
        return values if self._as_it_is else [values[i] for i in self._entries]


@dataclass
class Reading:
    """What a message says of the joints of a group."""

    group: JointGroup
    stamp_ns: int                       # of the measurement [ns]
    position: Sequence[float]           # [rad, m], finite
    velocity: Sequence[float] | None    # [rad/s, m/s]; NaN where not measured


class JointGroups:
    """
    The groups of one robot, found from the names in the messages.

    A message that brings all joints of a group and more takes the place of that group, since a
    publisher may announce joints later. Otherwise the group that was there first keeps its joints,
    and the message counts for the others only.

    Examples
    --------
    >>> groups = JointGroups(['shoulder', 'elbow', 'finger'])
    >>> reading = groups.read(JointSample(5, ('elbow', 'lamp', 'shoulder'), (0.1, 7.0, 0.2), ()))
    >>> reading.group.columns, reading.position
    ((0, 1), [0.2, 0.1])
    >>> groups.missing()
    ['finger']
    >>> str(groups.read(JointSample(6, ('lamp',), (7.0,), ())))
    'no_joint_of_robot'

    """

    def __init__(self, joint_names: Iterable[str]) -> None:
        self.joint_names = tuple(joint_names)
        self._column = {name: i for i, name in enumerate(self.joint_names)}
        self._layouts: dict[tuple[str, ...], NameLayout | Reason] = {}
        self._groups: dict[tuple[int, ...], JointGroup] = {}
        self._strangers: dict[str, None] = {}

    @property
    def groups(self) -> tuple[JointGroup, ...]:
        """Return the present groups."""
        return tuple(self._groups.values())

    def read(self, sample: JointSample) -> Reading | Reason:
        """Return what a sample says of the joints of a group, or the reason to refuse it."""
        stamp_ns, names, positions, velocities = sample
        found = self._layouts.get(names)
        if found is None:
            found = self._new_layout(names)
        if not isinstance(found, NameLayout):
            return found
        layout = found      # whose type is in the .pxd
        if len(positions) != layout.length:
            return Reason.WRONG_LENGTH
        position = layout.select(positions)
        if not hypot(*position) < LARGEST:      # NaN, infinite, or absurd
            return Reason.NOT_FINITE
        layout.group.messages += 1
        velocity = layout.select(velocities) if len(velocities) == layout.length else None
        return Reading(layout.group, stamp_ns, position, velocity)

    def describe(self, sample: JointSample, refused: Reason) -> str:
        """
        Return which joint and which number a sample was refused for, if that tells more.

        Examples
        --------
        >>> groups = JointGroups(['shoulder', 'elbow'])
        >>> sample = JointSample(5, ('shoulder', 'elbow'), (0.1, float('nan')), ())
        >>> groups.describe(sample, groups.read(sample))
        'elbow at nan'

        """
        _, names, positions, _ = sample
        if refused is Reason.WRONG_LENGTH:
            return f'{len(positions)} positions for {len(names)} names'
        if refused is Reason.NOT_FINITE:
            own = [(name, x) for name, x in zip(names, positions) if name in self._column]
            return listed(f'{name} at {x:g}' for name, x in own
                          if not abs(x) * len(own)**0.5 < LARGEST)
        if refused is Reason.NAMED_TWICE:
            return listed(name for name in dict.fromkeys(names) if names.count(name) > 1)
        return ''

    def missing(self) -> list[str]:
        """Return the names of the joints that no group brings."""
        seen = {column for columns in self._groups for column in columns}
        return [name for i, name in enumerate(self.joint_names) if i not in seen]

    def describe_missing(self) -> str:
        """
        Return a sentence on the joints that no group brings, and on names that are like theirs.

        It is empty if there are no such joints.

        Examples
        --------
        >>> groups = JointGroups(['arm_joint_1'])
        >>> _ = groups.read(JointSample(5, ('left_arm_joint_1', 'lamp'), (0.0, 0.0), ()))
        >>> groups.describe_missing()
        "no joint states of arm_joint_1; there are some of 'left_arm_joint_1'"

        """
        missing = self.missing()
        if not missing:
            return ''
        sentence = f'no joint states of {listed(missing)}'
        alike: dict[str, None] = {}
        for name in missing[:LISTED]:
            alike |= dict.fromkeys(self._names_like(name))
        if alike:
            return f'{sentence}; there are some of {listed(map(repr, alike))}'
        if self._strangers and len(missing) == len(self.joint_names):
            return f'{sentence}; there are some of {listed(self._strangers)}'
        return sentence

    def _names_like(self, name: str) -> list[str]:
        """Return names that were met and may mean this joint: with a prefix, in another case."""
        plain = name.lower()
        ends = [met for met in self._strangers
                if met.lower().endswith(plain) or plain.endswith(met.lower())]
        return ends or get_close_matches(name, self._strangers, 1, 0.8)

    def release(self, group: JointGroup) -> None:
        """Forget a group that comes no more, so that other messages may bring its joints."""
        if self._groups.pop(group.columns, None) is not None:
            self._layouts.clear()

    def stale_groups(self, now: float, timeout: float) -> list[JointGroup]:
        """
        Return the groups that brought no message for longer than a timeout, by any clock [s].

        Examples
        --------
        >>> groups = JointGroups(['q1'])
        >>> reading = groups.read(JointSample(5, ('q1',), (0.1,), ()))
        >>> [len(groups.stale_groups(now, timeout=0.5)) for now in (0.0, 0.25, 0.5, 0.75)]
        [0, 0, 0, 1]

        """
        return [group for group in self.groups if group.is_stale(now, timeout)]

    def _new_layout(self, names: tuple[str, ...]) -> NameLayout | Reason:
        layout = self._find(names)
        while len(self._layouts) >= MAX_LAYOUTS:    # endlessly new names: forget the oldest
            del self._layouts[next(iter(self._layouts))]
        self._layouts[names] = layout
        return layout

    def _find(self, names: tuple[str, ...]) -> NameLayout | Reason:
        entry = {self._column[name]: i for i, name in enumerate(names) if name in self._column}
        for name in names:
            if name not in self._column and len(self._strangers) < MAX_STRANGERS:
                self._strangers[name] = None
        if not entry:
            return Reason.NO_JOINT
        if sum(name in self._column for name in names) > len(entry):
            return Reason.NAMED_TWICE
        for group in self.groups:
            if entry.keys() > set(group.columns):
                self.release(group)
        taken = {c for columns in self._groups if columns != tuple(sorted(entry))
                 for c in columns}
        columns = tuple(sorted(entry.keys() - taken))
        if not columns:
            return Reason.OWNED_BY_OTHERS
        if columns not in self._groups:
            self._groups[columns] = JointGroup(columns, len(columns) == len(self.joint_names))
            self._layouts.clear()
        return NameLayout(self._groups[columns], tuple(entry[c] for c in columns), len(names))


def listed(names: Iterable[str]) -> str:
    """
    Return names in a row, the first ones if they are many.

    Examples
    --------
    >>> listed(f'q{k}' for k in range(400))
    'q0, q1, q2, q3, q4, q5, q6, q7 and 392 more'

    """
    names = list(names)
    more = f' and {len(names) - LISTED} more' if len(names) > LISTED else ''
    return ', '.join(names[:LISTED]) + more
