# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joints, poses and frame names as all model files write them."""
from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import Any

import numpy as np

from .fields import Fields
from .following import followed_joint
from .units import Units
from ..chains.joint import Joint, KINDS, Mimic
from ..screws.rotations import pose, rotation_rpy
from ..screws.se3 import Array

MAX_JOINTS = 1000
"""Most joints of one file."""

COMMON = ('name', 'units', 'base_frame', 'tip_frame')
"""Keys that every model file may have."""

_ROWS = ('row 1', 'row 2', 'row 3', 'row 4')
_JOINT = ('name', 'kind', 'pitch', 'mimic', 'velocity_limit')


def units_of(fields: Fields) -> Units:
    """Return the units a file declares."""
    return Units.from_fields(
        Fields(fields.source, 'units', fields.raw('units', {}), ('length', 'angle')))


def read_frame(fields: Fields, key: str, wanted: str | None, default: str) -> str:
    """Return a frame's name: what the file says, which must be the wanted one, if any."""
    given = fields.text(key, wanted or default)
    if wanted is not None and wanted != given:
        raise fields.wrong(wanted, f'{given!r}, as the file names it', key)
    return given


def read_names(fields: Fields, name: str, base_frame: str | None, tip_frame: str | None,
               tip: str) -> tuple[str, str, str]:
    """
    Return the names of base frame, tip frame and robot, as a file gives them.

    Parameters
    ----------
    fields : Fields
        The file's.
    name : str
        Name of the robot where the file gives none.
    base_frame, tip_frame : str, optional
        Wanted frames; where the file names them, the same ones.
    tip : str
        Name of the tip frame where nobody names it.

    """
    return (read_frame(fields, 'base_frame', base_frame, 'base'),
            read_frame(fields, 'tip_frame', tip_frame, tip), fields.text('name', name))


def joint_fields(source: str, place: str, entry: Any, more: tuple[str, ...]) -> Fields:
    """Return the fields of one joint, its errors located by its name."""
    name = Fields(source, place, entry).text('name')
    return Fields(source, f'joint {name!r}', entry, (*_JOINT, *more))


def read_joint(fields: Fields, units: Units, axis: Any, point: Any) -> Joint:
    """Return the joint with the given axis; all else is read from the fields."""
    kind = fields.choice('kind', KINDS, 'revolute')
    pitch = units.pitch(fields.number('pitch', None if kind == 'helical' else 0.0))
    return Joint(fields.text('name'), kind, axis, point, pitch,
                 _followed(fields, units, kind), _velocity_limit(fields, units, kind))


def _velocity_limit(fields: Fields, units: Units, kind: str) -> float:
    """Return the largest speed of the joint, infinite where none is given."""
    if 'velocity_limit' not in fields:
        return inf
    limit = fields.number('velocity_limit')
    if not limit > 0:
        raise fields.wrong(limit, 'a positive number', 'velocity_limit')
    return units.length(limit) if kind == 'prismatic' else units.angle(limit)


def _followed(fields: Fields, units: Units, kind: str) -> Mimic | None:
    """Return what the joint follows directly, by its own ``mimic``."""
    if 'mimic' not in fields:
        return None
    mimic = Fields(fields.source, f'{fields.place}: mimic', fields.raw('mimic'),
                   ('joint', 'multiplier', 'offset'))
    offset = mimic.number('offset', 0.0)
    return Mimic(mimic.text('joint'), mimic.number('multiplier', 1.0),
                 units.length(offset) if kind == 'prismatic' else units.angle(offset))


def measured_ends(source: str, joints: list[Joint]) -> list[Joint]:
    """Return the joints, each that follows another now following a measured one."""
    rules = {joint.name: joint.mimic for joint in joints}
    return [replace(joint, mimic=followed_joint(source, joint.name, rules.get))
            for joint in joints]


def read_pose(fields: Fields, key: str, units: Units, required: bool = False) -> Array:
    """Return the pose under a key, shape (4, 4); the identity if there may be none."""
    value = fields.raw(key, None if required else {})
    place = Fields(fields.source, key, value, ('xyz', 'rpy', 'matrix'))
    if 'matrix' in place:
        rows = place.items('matrix', 4)
        if 'xyz' in place or 'rpy' in place or len(rows) != 4:
            raise place.wrong(value, 'xyz and rpy, or a matrix of four rows')
        matrix = Fields(fields.source, f'{key}: matrix', dict(zip(_ROWS, rows)))
        T = np.array([matrix.numbers(row, 4) for row in _ROWS])
        T[:3, 3] = [units.length(x) for x in T[:3, 3]]
        return T
    return pose(rotation_rpy(*(units.angle(x) for x in place.numbers('rpy', 3, (0, 0, 0)))),
                [units.length(x) for x in place.numbers('xyz', 3, (0, 0, 0))])
