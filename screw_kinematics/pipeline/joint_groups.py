# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Which joints of a robot a message brings, by name.

A robot's joints may arrive in one message or in several ones, from several publishers, at
different rates. The joints that always come together form a *group*; groups never share a
joint. A *layout* says where in a message, with given names, the joints of a group are.
"""
from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from operator import itemgetter

MAX_LAYOUTS = 64

NO_JOINT = 'no_joint_of_robot'
NAMED_TWICE = 'joint_named_twice'
OWNED = 'joints_come_with_other_message'

Pick = Callable[[Sequence[float]], Sequence[float]]


class JointGroup:
    """
    Joints of a robot that come together.

    Parameters
    ----------
    columns : tuple of int
        Which joints of the robot they are, increasing.
    complete : bool
        Whether these are all the joints of the robot.

    """

    def __init__(self, columns: tuple[int, ...], complete: bool) -> None:
        self.columns = columns
        self.complete = complete
        self.messages = 0


class Layout:
    """
    Where the joints of a group are in a message.

    Parameters
    ----------
    group : JointGroup
        Whose joints the message brings.
    entries : tuple of int
        For each joint of the group its index in the message.
    length : int
        Number of names in the message.

    """

    def __init__(self, group: JointGroup, entries: tuple[int, ...], length: int) -> None:
        self.group = group
        self.length = length
        self.pick = _selection(entries, length)


def _selection(entries: tuple[int, ...], length: int) -> Pick:
    if entries == tuple(range(length)):
        return lambda values: values
    if len(entries) == 1:
        only = entries[0]
        return lambda values: (values[only],)
    return itemgetter(*entries)


class JointGroups:
    """
    The groups of one robot, found from the names in the messages.

    A message that brings all joints of a group and more takes the place of that group, since
    a publisher may announce joints later. Otherwise the group that was there first keeps its
    joints, and the message counts for the others only.

    Parameters
    ----------
    joint_names : iterable of str
        The measured joints of the robot, in its order.

    Examples
    --------
    >>> groups = JointGroups(['shoulder', 'elbow', 'finger'])
    >>> layout = groups.find(('elbow', 'lamp', 'shoulder'))
    >>> layout.group.columns, layout.pick([0.1, 7.0, 0.2])
    ((0, 1), (0.2, 0.1))
    >>> groups.missing()
    ['finger']
    >>> groups.find(('lamp',))
    'no_joint_of_robot'

    """

    def __init__(self, joint_names: Iterable[str]) -> None:
        self.joint_names = tuple(joint_names)
        self._column = {name: i for i, name in enumerate(self.joint_names)}
        self._layouts: dict[tuple[str, ...], Layout | str] = {}
        self._groups: dict[tuple[int, ...], JointGroup] = {}

    @property
    def groups(self) -> tuple[JointGroup, ...]:
        """Return the present groups."""
        return tuple(self._groups.values())

    def find(self, names: tuple[str, ...]) -> Layout | str:
        """
        Return how a message with these names is to be read, or the reason to refuse it.

        Parameters
        ----------
        names : tuple of str
            Joint names of a message.

        """
        layout = self._layouts.get(names)
        if layout is None:
            layout = self._read(names)
            while len(self._layouts) >= MAX_LAYOUTS:    # endlessly new names: forget the oldest
                del self._layouts[next(iter(self._layouts))]
            self._layouts[names] = layout
        return layout

    def missing(self) -> list[str]:
        """Return the names of the joints that no group brings."""
        seen = {column for columns in self._groups for column in columns}
        return [name for i, name in enumerate(self.joint_names) if i not in seen]

    def names_of(self, group: JointGroup) -> list[str]:
        """Return the names of a group's joints."""
        return [self.joint_names[column] for column in group.columns]

    def release(self, group: JointGroup) -> None:
        """Forget a group that comes no more, so that other messages may bring its joints."""
        if self._groups.pop(group.columns, None) is not None:
            self._layouts.clear()

    def _read(self, names: tuple[str, ...]) -> Layout | str:
        entry = {self._column[name]: i for i, name in enumerate(names) if name in self._column}
        if not entry:
            return NO_JOINT
        if sum(name in self._column for name in names) > len(entry):
            return NAMED_TWICE
        for group in self.groups:
            if entry.keys() > set(group.columns):
                self.release(group)
        taken = {c for columns in self._groups if columns != tuple(sorted(entry))
                 for c in columns}
        columns = tuple(sorted(entry.keys() - taken))
        if not columns:
            return OWNED
        if columns not in self._groups:
            self._groups[columns] = JointGroup(columns, len(columns) == len(self.joint_names))
            self._layouts.clear()
        return Layout(self._groups[columns], tuple(entry[c] for c in columns), len(names))
