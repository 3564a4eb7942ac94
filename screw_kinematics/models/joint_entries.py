# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joints, poses, units and frame names as all model files write them; who mimics whom."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
import math
from typing import Any

import numpy as np

from .fields import Fields, listed
from ..chains.joint import Joint, KINDS, Mimic
from ..errors import ModelError
from ..screws.rotations import pose, rotation_rpy
from ..screws.se3 import Array

MAX_JOINTS = 1000
"""Most joints of one file, or between base and tip."""

COMMON = ('name', 'units', 'base_frame', 'tip_frame')
"""Keys that every model file may have."""

_ROWS = ('row 1', 'row 2', 'row 3', 'row 4')
_JOINT = ('name', 'kind', 'pitch', 'mimic', 'velocity_limit')
_MAX_FOLLOWED = 50
# Quotients, so that 431.8 mm becomes the number nearest to 0.4318.
_LENGTHS = {'m': (1, 1), 'cm': (1, 100), 'mm': (1, 1000), 'in': (127, 5000)}
_ANGLES = ('rad', 'deg')


@dataclass(frozen=True)
class Units:
    """
    The length and angle unit of a file: m, cm, mm or in; rad or deg.

    Examples
    --------
    >>> units = Units('mm', 'deg')
    >>> units.length(431.8), units.angle(180.0)
    (0.4318, 3.141592653589793)

    """

    length_unit: str = 'm'
    angle_unit: str = 'rad'

    @classmethod
    def of(cls, fields: Fields) -> Units:
        """Return the units that a file declares."""
        units = Fields(fields.source, 'units', fields.raw('units', {}), ('length', 'angle'))
        return cls(units.choice('length', _LENGTHS, 'm'), units.choice('angle', _ANGLES, 'rad'))

    def length(self, value: float) -> float:
        """Return a length in m; one that is a symbol stands for metres."""
        if hasattr(value, 'free_symbols'):
            return value
        numerator, denominator = _LENGTHS[self.length_unit]
        return value * numerator / denominator

    def angle(self, value: float) -> float:
        """Return an angle in rad."""
        return math.radians(value) if self.angle_unit == 'deg' else value

    def joint(self, kind: str, value: float) -> float:
        """Return a joint's value in m if it is prismatic, else in rad."""
        return self.length(value) if kind == 'prismatic' else self.angle(value)

    def pitch(self, value: float) -> float:
        """Return a pitch, length per angle of the file, in m/rad."""
        return self.length(value) / self.angle(1.0)


def read_frame(fields: Fields, key: str, wanted: str | None, default: str) -> str:
    """Return a frame's name: what the file says, which must be the wanted one, if any."""
    given = fields.text(key, wanted or default)
    if wanted is not None and wanted != given:
        raise fields.wrong(wanted, f'{given!r}, as the file names it', key)
    return given


def read_names(fields: Fields, name: str, base_frame: str | None, tip_frame: str | None,
               tip: str) -> tuple[str, str, str]:
    """
    Return the names of base frame, tip frame and robot.

    As a file gives them, or else as given here; frames that are wanted may not be others.
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
        return math.inf
    limit = fields.number('velocity_limit')
    if not limit > 0:
        raise fields.wrong(limit, 'a positive number', 'velocity_limit')
    return units.joint(kind, limit)


def _followed(fields: Fields, units: Units, kind: str) -> Mimic | None:
    """Return what the joint follows directly, by its own ``mimic``."""
    if 'mimic' not in fields:
        return None
    mimic = Fields(fields.source, f'{fields.place}: mimic', fields.raw('mimic'),
                   ('joint', 'multiplier', 'offset'))
    offset = mimic.number('offset', 0.0)
    return Mimic(mimic.text('joint'), mimic.number('multiplier', 1.0),
                 units.joint(kind, offset))


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


def resolve_mimic(source: str, name: str, rule: Callable[[str], Mimic | None]
                  ) -> Mimic | None:
    """
    Return how a joint depends on a measured one; None if it is measured itself.

    The rule gives for a joint's name what it follows directly, or None.

    Raises
    ------
    ModelError
        Joints follow each other in a circle, in too long a line, or with a product of
        multipliers that is not finite.

    Examples
    --------
    >>> rules = {'b': Mimic('a', 2.0, 1.0), 'c': Mimic('b', 3.0, 0.5)}
    >>> found = resolve_mimic('doc', 'c', rules.get)
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
        if step.joint in line or len(line) > _MAX_FOLLOWED:
            raise ModelError(source, f'joint {name!r}: mimic: got {listed([*line, step.joint])}; '
                             f'allowed: a line of at most {_MAX_FOLLOWED} joints, no circle')
        line.append(step.joint)
    return None if len(line) == 1 else Mimic(line[-1], multiplier, offset)


def resolve_mimics(source: str, joints: list[Joint]) -> list[Joint]:
    """Return the joints, each that follows another now following a measured one."""
    rules = {joint.name: joint.mimic for joint in joints}
    return [replace(joint, mimic=resolve_mimic(source, joint.name, rules.get))
            for joint in joints]
