# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Checks of single parameter values: each returns the value in the form used, or raises."""
from __future__ import annotations

from collections.abc import Callable
import re
from typing import Any

Check = Callable[[Any], Any]

LARGEST_OFFSET = 1e6
"""Of a tool from the tip frame [m, rad]."""


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


def topics(value: Any) -> tuple[str, ...]:
    """Return one or several topics, given as a string or a list."""
    names = (value,) if isinstance(value, str) else strings(value)
    if not names or not all(name.strip() for name in names):
        raise ValueError
    return tuple(dict.fromkeys(names))


def offset(value: Any) -> tuple[float, ...]:
    """Return six numbers."""
    check = number(-LARGEST_OFFSET, LARGEST_OFFSET)
    numbers = tuple(check(v) for v in _items(value))
    if len(numbers) != 6:
        raise ValueError
    return numbers


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
