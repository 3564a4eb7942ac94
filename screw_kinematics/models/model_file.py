# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Chains from model files in YAML.

A file gives the joints either as screws or as Denavit-Hartenberg rows::

    name: two_axes                   # default: the file's name
    units: {length: mm, angle: deg}  # of all numbers here; default: m, rad
    base_frame: base                 # names for messages; default: base, tool
    tip_frame: tool
    joints:                          # from base to tip, at q = 0, in the base frame
      - {name: turn, kind: revolute, axis: [0, 0, 1], point: [0, 0, 0]}
      - {name: spindle, kind: helical, axis: [0, 0, 1], point: [250, 0, 0], pitch: 0.5}
    home: {xyz: [250, 0, 100], rpy: [0, 180, 0]}    # the tip frame at q = 0

or, in place of ``joints`` and ``home``::

    dh:
      convention: standard           # or modified
      rows:                          # a, alpha, d, theta default to 0
        - {name: q1, kind: revolute, a: 0, alpha: -90, d: 0, theta: 0}
    base: {xyz: [0, 0, 0]}           # first frame of the rows in the base frame
    tool: {xyz: [0, 0, 0]}           # tip frame in the last frame of the rows

``kind`` is revolute (the default), continuous, prismatic or helical; ``pitch`` is the
length per angle, in the file's units. ``axis`` needs no unit length. A pose is ``xyz`` and
``rpy`` (roll, pitch, yaw about fixed x, y, z), or a ``matrix`` of four rows. Any joint or
row may follow another one, ``mimic: {joint: turn, multiplier: 2, offset: 0}``; the
multiplier is a ratio of SI values, the offset in the file's units.
"""
from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from .dh import CONVENTIONS, DHRow, place_rows
from .fields import Fields, reported
from .following import followed_joint
from .placement import pose, rotation_rpy
from .units import Units
from ..chain import SerialChain
from ..joint import Joint, KINDS, Mimic
from ..se3 import Array

MAX_JOINTS = 1000
"""Most joints of one file."""

_COMMON = ('name', 'units', 'base_frame', 'tip_frame')
_ROWS = ('row 1', 'row 2', 'row 3', 'row 4')
_JOINT = ('name', 'kind', 'pitch', 'mimic')


def chain_from_data(data: Any, source: str, name: str, base_frame: str | None = None,
                    tip_frame: str | None = None) -> SerialChain:
    """
    Return the chain of a model file.

    Parameters
    ----------
    data : mapping
        The file's content, as this module describes it.
    source : str
        The file, for messages.
    name : str
        Name of the robot where the file gives none.
    base_frame, tip_frame : str, optional
        Wanted frames; where the file names them, the same ones.

    Returns
    -------
    SerialChain

    Raises
    ------
    ModelError
        A key is unknown or missing, or a value not usable.

    """
    fields = Fields(source, '', data)
    if 'dh' in fields:
        fields = Fields(source, '', data, (*_COMMON, 'dh', 'base', 'tool'))
        read = _dh_joints
    else:
        fields = Fields(source, '', data, (*_COMMON, 'joints', 'home'))
        read = _screw_joints
    units = Units.from_fields(
        Fields(source, 'units', fields.raw('units', {}), ('length', 'angle')))
    with reported(source):
        joints, T_base_tool = read(fields, units)
        return SerialChain(
            _measured_ends(source, joints), T_base_tool,
            base_frame=_frame(fields, 'base_frame', base_frame, 'base'),
            tip_frame=_frame(fields, 'tip_frame', tip_frame, 'tool'),
            name=fields.text('name', name))


def _frame(fields: Fields, key: str, wanted: str | None, default: str) -> str:
    given = fields.text(key, wanted or default)
    if wanted is not None and wanted != given:
        raise fields.wrong(wanted, f'{given!r}, as the file names it', key)
    return given


def _screw_joints(fields: Fields, units: Units) -> tuple[list[Joint], Array]:
    joints = []
    for i, entry in enumerate(fields.items('joints', MAX_JOINTS), start=1):
        joint = _joint_fields(fields.source, f'joint {i}', entry, ('axis', 'point'))
        point = [units.length(x) for x in joint.numbers('point', 3, (0, 0, 0))]
        joints.append(_joint(joint, units, joint.numbers('axis', 3), point))
    return joints, _pose(fields, 'home', units, required=True)


def _dh_joints(fields: Fields, units: Units) -> tuple[list[Joint], Array]:
    dh = Fields(fields.source, 'dh', fields.raw('dh'), ('convention', 'rows'))
    convention = dh.choice('convention', CONVENTIONS)
    entries = [_joint_fields(fields.source, f'dh row {i}', entry,
                             ('a', 'alpha', 'd', 'theta'))
               for i, entry in enumerate(dh.items('rows', MAX_JOINTS), start=1)]
    rows = [DHRow(units.length(row.number('a', 0.0)), units.angle(row.number('alpha', 0.0)),
                  units.length(row.number('d', 0.0)), units.angle(row.number('theta', 0.0)))
            for row in entries]
    frames, last = place_rows(rows, convention, _pose(fields, 'base', units))
    joints = [_joint(row, units, frame[:3, 2], frame[:3, 3])
              for row, frame in zip(entries, frames)]
    return joints, last @ _pose(fields, 'tool', units)


def _joint_fields(source: str, place: str, entry: Any, more: tuple[str, ...]) -> Fields:
    """Return the fields of one joint, its errors located by its name."""
    name = Fields(source, place, entry).text('name')
    return Fields(source, f'joint {name!r}', entry, (*_JOINT, *more))


def _joint(fields: Fields, units: Units, axis: Any, point: Any) -> Joint:
    kind = fields.choice('kind', KINDS, 'revolute')
    pitch = units.pitch(fields.number('pitch', None if kind == 'helical' else 0.0))
    return Joint(fields.text('name'), kind, axis, point, pitch,
                 _followed(fields, units, kind))


def _followed(fields: Fields, units: Units, kind: str) -> Mimic | None:
    """Return what the joint follows directly, by its own ``mimic``."""
    if 'mimic' not in fields:
        return None
    mimic = Fields(fields.source, f'{fields.place}: mimic', fields.raw('mimic'),
                   ('joint', 'multiplier', 'offset'))
    offset = mimic.number('offset', 0.0)
    return Mimic(mimic.text('joint'), mimic.number('multiplier', 1.0),
                 units.length(offset) if kind == 'prismatic' else units.angle(offset))


def _measured_ends(source: str, joints: list[Joint]) -> list[Joint]:
    """Return the joints, each that follows another now following a measured one."""
    rules = {joint.name: joint.mimic for joint in joints}
    return [replace(joint, mimic=followed_joint(source, joint.name, rules.get))
            for joint in joints]


def _pose(fields: Fields, key: str, units: Units, required: bool = False) -> Array:
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
