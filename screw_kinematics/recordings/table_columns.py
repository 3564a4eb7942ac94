# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the columns of a table are, by their names.

Joints are found by their own names, by a number (``q1`` to ``qn``, ``position[0]`` ...), or as
``rostopic echo -p`` and PlotJuggler write them.
"""
from __future__ import annotations

from collections.abc import Iterable, Sequence
import re
from typing import Any

from ..errors import ToolError

VELOCITY = '.velocity'
"""Ending of a joint's name in ``TableFormat.columns`` that means its velocity."""

_STAMPS = ('stamp', 'header.stamp', 'field.header.stamp', 'timestamp', '__time', 'time', '%time',
           't')
_SECONDS = (('header.stamp.sec', 'header.stamp.nanosec'), ('sec', 'nanosec'), ('secs', 'nsecs'))
_VELOCITY = {'velocity', 'velocities', 'vel', 'qd', 'dq', 'qdot', 'speed', 'v', 'omega'}
_POSITION = {'position', 'positions', 'pos', 'q', 'angle', 'angles', 'joint', 'j', 'theta'}
_OTHER = {'effort', 'torque', 'tau', 'current', 'acc', 'acceleration', 'accelerations', 'qdd',
          'ddq', 'desired', 'target', 'command', 'cmd', 'setpoint', 'temperature', 'name'}
_UNITS = {'deg': 'deg', 'rad': '(?<![a-z])rad', 'mm': '(?<![a-z])mm(?![a-z])',
          'm': '(?<![a-z])m(?![a-z])'}


def stamp_columns(there: Sequence[str]) -> tuple[str, ...] | None:
    """
    Return the column of stamps, or those of seconds and nanoseconds.

    Examples
    --------
    >>> stamp_columns(['q1', 'Time']), stamp_columns(['sec', 'nanosec', 'q1'])
    (('Time',), ('sec', 'nanosec'))

    """
    lower = {_stem(name): name for name in reversed(there)}
    for seconds, rest in _SECONDS:
        for ending in ('', *(name.removesuffix(seconds) for name in lower
                             if name.endswith((f'.{seconds}', f'/{seconds}')))):
            if ending + seconds in lower and ending + rest in lower:
                return lower[ending + seconds], lower[ending + rest]
    return next(((lower[name],) for name in _STAMPS if name in lower), None)


def is_stamp(column: str) -> bool:
    """Return whether a column is one of stamps."""
    return _stem(column) in _STAMPS


def named_unit(column: str, joint: str, units: Iterable[str]) -> str:
    """
    Return which unit the name of a joint's column tells, or an empty text.

    Examples
    --------
    >>> named_unit('lift [mm]', 'lift', ['m', 'mm']), named_unit('deg_1', 'deg_1', ['rad', 'deg'])
    ('mm', '')

    """
    rest = column.replace(joint, ' ').lower()
    return next((unit for unit in units if re.search(_UNITS[unit], rest)), '')


def _stem(column: str) -> str:
    """Return the name of a column of stamps without its unit."""
    return re.sub(r'(\s*[\[(].*|_(ns|us|ms|s))$', '', column.strip(' "').lower())


def by_number(there: Sequence[str], joints: Sequence[str]) -> dict[str, str]:
    """
    Return columns that number the joints, by joint.

    Examples
    --------
    >>> by_number(['t', 'q0', 'q1', 'v0', 'v1'], ['shoulder', 'elbow'])
    {'shoulder': 'q0', 'elbow': 'q1', 'shoulder.velocity': 'v0', 'elbow.velocity': 'v1'}

    """
    stems: dict[str, dict[int, str]] = {}
    for column in there:
        parts = re.fullmatch(r'(.*?)(\d+)(\D*)', column.lower())
        if parts:
            stems.setdefault(f'{parts[1]}#{parts[3]}', {})[int(parts[2])] = column
    found: dict[str, list[dict[int, str]]] = {'': [], VELOCITY: []}
    for key, columns in stems.items():
        words, first = set(re.findall('[a-z]+', key)), min(columns)
        if words & _OTHER or first > 1 or (
                set(columns) != set(range(first, first + len(joints)))):
            continue
        if words & _VELOCITY:
            found[VELOCITY].append(columns)
        elif words & _POSITION:
            found[''].append(columns)
    # Two that could be meant are none: the user is asked.
    return {joint + ending: columns[0][min(columns[0]) + i] for ending, columns in found.items()
            if len(columns) == 1 for i, joint in enumerate(joints)}


def echoed(batch: Any) -> dict[str, str]:
    """Return columns by joint where a row has the names: messages, or ``rostopic echo -p``."""
    found: dict[str, str] = {}
    for column in batch.schema.names if batch.num_rows else ():
        names = re.fullmatch(r'(.*?)name(\d+|\[\d+\])', column)
        if names:
            joint = str(batch.column(column)[0].as_py())
            for ending, part in (('', 'position'), (VELOCITY, 'velocity')):
                if f'{names[1]}{part}{names[2]}' in batch.schema.names:
                    found[joint + ending] = f'{names[1]}{part}{names[2]}'
    return found


def by_name(there: Sequence[str], joints: Sequence[str]) -> dict[str, str]:
    """
    Return columns that hold a joint's name, by joint.

    Raises
    ------
    ToolError
        Two may be of the same.

    Examples
    --------
    >>> by_name(['t', 'pos elbow', 'elbow_vel', 'tau elbow'], ['elbow'])
    {'elbow': 'pos elbow', 'elbow.velocity': 'elbow_vel'}

    """
    found: dict[str, str] = {}
    for column in dict.fromkeys(there):
        named = [name for name in joints if re.search(
            f'(?<![A-Za-z0-9]){re.escape(name)}(?![A-Za-z0-9])', column)]
        if not named:
            continue
        joint = max(named, key=len)
        words = set(re.findall('[a-z]+', column.replace(joint, ' ').lower()))
        if words & _OTHER:
            continue
        key = joint + (VELOCITY if words & _VELOCITY else '')
        if key in found and column != joint:
            if found[key] == joint:
                continue
            raise ToolError(f'both {found[key]!r} and {column!r} may be {key}; '
                            f'choose by --columns {key}=COLUMN')
        found[key] = column
    return found
