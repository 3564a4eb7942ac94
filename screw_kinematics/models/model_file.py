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
multiplier is a ratio of SI values, the offset in the file's units. ``velocity_limit`` is the
largest speed that the maker states, in the file's units per second.
"""
from __future__ import annotations

from typing import Any

import numpy as np

from .fields import Fields, reported
from .joint_entries import (
    COMMON, joint_fields, MAX_JOINTS, measured_ends, read_joint, read_names, read_pose, units_of)
from .units import Units
from ..chains.dh import CONVENTIONS, DHRow, place_rows
from ..chains.joint import Joint
from ..chains.serial_chain import SerialChain
from ..screws.se3 import Array


@np.errstate(over='ignore', invalid='ignore')    # what overflows is refused as not finite
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
        fields = Fields(source, '', data, (*COMMON, 'dh', 'base', 'tool'))
        read = _dh_joints
    else:
        fields = Fields(source, '', data, (*COMMON, 'joints', 'home'))
        read = _screw_joints
    units = units_of(fields)
    with reported(source):
        joints, T_base_tool = read(fields, units)
        return SerialChain(
            measured_ends(source, joints), T_base_tool,
            *read_names(fields, name, base_frame, tip_frame, 'tool'))


def _screw_joints(fields: Fields, units: Units) -> tuple[list[Joint], Array]:
    joints = []
    for i, entry in enumerate(fields.items('joints', MAX_JOINTS), start=1):
        joint = joint_fields(fields.source, f'joint {i}', entry, ('axis', 'point'))
        point = [units.length(x) for x in joint.numbers('point', 3, (0, 0, 0))]
        joints.append(read_joint(joint, units, joint.numbers('axis', 3), point))
    return joints, read_pose(fields, 'home', units, required=True)


def _dh_joints(fields: Fields, units: Units) -> tuple[list[Joint], Array]:
    dh = Fields(fields.source, 'dh', fields.raw('dh'), ('convention', 'rows'))
    convention = dh.choice('convention', CONVENTIONS)
    entries = [joint_fields(fields.source, f'dh row {i}', entry,
                            ('a', 'alpha', 'd', 'theta'))
               for i, entry in enumerate(dh.items('rows', MAX_JOINTS), start=1)]
    rows = [DHRow(units.length(row.number('a', 0.0)), units.angle(row.number('alpha', 0.0)),
                  units.length(row.number('d', 0.0)), units.angle(row.number('theta', 0.0)))
            for row in entries]
    frames, last = place_rows(rows, convention, read_pose(fields, 'base', units))
    joints = [read_joint(row, units, frame[:3, 2], frame[:3, 3])
              for row, frame in zip(entries, frames)]
    return joints, last @ read_pose(fields, 'tool', units)
