# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""One parameter, and the checks of what it may be."""
from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from difflib import SequenceMatcher
import re
from typing import Any

from ..errors import ParameterError

Check = Callable[[Any], Any]


@dataclass(frozen=True)
class Setting:
    """
    One parameter.

    The text says what it does, with its unit; allowed are the values in words. The check returns
    the value in the form used here, or raises ValueError. It is fixed once the node is configured,
    or started, or, if empty, never; the span is the least and greatest value of a number.
    """

    name: str
    default: Any
    text: str
    allowed: str
    check: Check
    fixed: str = ''
    span: tuple[float, float] | None = None

    def read(self, value: Any, prefix: str = '') -> Any:
        """Return the checked value; raise ParameterError naming it and what is allowed."""
        try:
            return self.check(value)
        except ValueError:
            raise ParameterError(prefix + self.name, value, self.allowed) from None


def boolean(value: Any) -> bool:
    """Return true or false; raise ValueError for anything else."""
    if not isinstance(value, bool):
        raise ValueError
    return value


def text(value: Any) -> str:
    """Return a string; raise ValueError for anything else."""
    if not isinstance(value, str):
        raise ValueError
    return value


def nonempty(value: Any) -> str:
    """Return a string that is not blank, or raise ValueError."""
    if not text(value).strip():
        raise ValueError
    return str(value)


def number(low: float, high: float) -> Check:
    """Return a check for finite numbers of a range, whole numbers among them."""
    def check(value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ValueError
        if not low <= value <= high:    # refuses NaN too
            raise ValueError
        return float(value)
    return check


def whole_number(low: int, high: int) -> Check:
    """Return a check for whole numbers of a range."""
    def check(value: Any) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise ValueError
        return value
    return check


def one_of(*choices: str) -> Check:
    """Return a check for a choice."""
    def check(value: Any) -> str:
        if value not in choices:
            raise ValueError
        return str(value)
    return check


def some_of(*choices: str) -> Check:
    """Return a check for at least one of the choices; their order here is kept."""
    def check(value: Any) -> tuple[str, ...]:
        names = strings(value)
        if not names or not set(names) <= set(choices):
            raise ValueError
        return tuple(name for name in choices if name in names)
    return check


def robot_names(value: Any) -> tuple[str, ...]:
    """Return different names that can begin a parameter's and a topic's name."""
    # An empty list has no type in ROS 2, so the default is a list of one empty string.
    names = tuple(name for name in strings(value) if name)
    if len(set(names)) < len(names) or not all(
            re.fullmatch('[A-Za-z][A-Za-z0-9_]*', name) for name in names):
        raise ValueError
    return names


def tip_frames(value: Any) -> tuple[str, ...]:
    """Return different frames whose names can be in the names of parameters and topics."""
    names = tuple(name for name in strings(value) if name)
    if any('.' in name for name in names) or len(set(map(topic_name, names))) < len(names):
        raise ValueError
    return names


def topic_name(frame: str) -> str:
    """
    Return the name of a frame as part of a topic.

    Examples
    --------
    >>> topic_name('left/tool-0')
    'left_tool_0'

    """
    name = re.sub('[^A-Za-z0-9_]', '_', frame)
    return f'_{name}' if name[0].isdigit() else name


def topics(value: Any) -> tuple[str, ...]:
    """Return one or several topics, given as a string or a list."""
    names = (value,) if isinstance(value, str) else strings(value)
    if not names or not all(name.strip() for name in names):
        raise ValueError
    return tuple(dict.fromkeys(names))


def numbers(count: int, largest: float) -> Check:
    """Return a check for so many finite numbers."""
    def check(value: Any) -> tuple[float, ...]:
        values = tuple(map(number(-largest, largest), _items(value)))
        if len(values) != count:
            raise ValueError
        return values
    return check


def strings(value: Any) -> tuple[str, ...]:
    """Return a list of strings as a tuple."""
    items = _items(value)
    if isinstance(value, (str, bytes)) or not all(isinstance(v, str) for v in items):
        raise ValueError
    return tuple(items)


def _items(value: Any) -> list[Any]:
    try:
        return list(value)
    except TypeError:
        raise ValueError from None


def choice(name: str, default: str, text: str, choices: tuple[str, ...],
           fixed: str = '') -> Setting:
    """Return a parameter that is one of some words."""
    return Setting(name, default, text, f'one of {", ".join(choices)}', one_of(*choices), fixed)


def quantity(name: str, default: float, text: str, low: float, high: float) -> Setting:
    """Return a parameter that is a number of a range."""
    return Setting(name, default, text, f'a number from {low:g} to {high:g}',
                   number(low, high), span=(low, high))


def most_like(name: str, known: Iterable[str]) -> str:
    """
    Return the parameter that is meant, empty if none is like it; the robot's name alone is not.

    Examples
    --------
    >>> most_like('arm.delay', ['arm.estimator.delay', 'arm.gravity'])
    'arm.estimator.delay'
    >>> most_like('arm.rate', ['arm.estimator.delay', 'arm.gravity'])
    ''

    """
    robot = name.partition('.')[0] + '.'

    def likeness(other: str) -> float:
        own = name
        if other.startswith(robot):
            own, other = name.removeprefix(robot), other.removeprefix(robot)
        return max(SequenceMatcher(None, word, own).ratio()
                   for word in (other, other.rpartition('.')[2]))

    found = max(known, key=likeness, default='')
    return found if found and likeness(found) >= 0.57 else ''
