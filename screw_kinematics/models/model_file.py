# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Robots from model files in YAML.

A file gives the joints in one of three forms. As screws::

    name: two_axes                   # default: the file's name
    units: {length: mm, angle: deg}  # of all numbers here; default: m, rad
    base_frame: base                 # names for messages; default: base, tool
    tip_frame: tool
    joints:                          # from base to tip, at q = 0, in the base frame
      - {name: turn, kind: revolute, axis: [0, 0, 1], point: [0, 0, 0]}
      - {name: spindle, kind: helical, axis: [0, 0, 1], point: [250, 0, 0], pitch: 0.5}
    home: {xyz: [250, 0, 100], rpy: [0, 180, 0]}    # the tip frame at q = 0

As Denavit-Hartenberg rows, in place of ``joints`` and ``home``::

    dh:
      convention: standard           # or modified
      rows:                          # a, alpha, d, theta default to 0
        - {name: q1, kind: revolute, a: 0, alpha: -90, d: 0, theta: 0}
    base: {xyz: [0, 0, 0]}           # first frame of the rows in the base frame
    tool: {xyz: [0, 0, 0]}           # tip frame in the last frame of the rows

As the limbs of a parallel manipulator, all of them in one posture with closed loops, as one
would draw the robot, together with the readings of the joints there::

    platform: {xyz: [0, 0, 500]}     # the platform's frame in the drawn posture
    actuated: [leg_1, leg_2]         # the measured joints; all others are passive
    limbs:
      - name: limb_1
        joints:                      # from base to platform, in the base frame
          - {name: foot_1, kind: universal, axes: [[1, 0, 0], [0, 1, 0]], point: [100, 0, 0]}
          - {name: leg_1, kind: prismatic, axis: [0, 0, 1], position: 500}
          - {name: head_1, kind: spherical, point: [100, 0, 500]}

``kind`` is revolute (the default), continuous, prismatic or helical; ``pitch`` is the
length per angle, in the file's units. ``axis`` needs no unit length. A pose is ``xyz`` and
``rpy`` (roll, pitch, yaw about fixed x, y, z), or a ``matrix`` of four rows. Any joint or
row may follow another one, ``mimic: {joint: turn, multiplier: 2, offset: 0}``; the
multiplier is a ratio of SI values, the offset in the file's units. ``velocity_limit`` is the
largest speed that the maker states, in the file's units per second.

A number may be the name of a parameter, with a sign or a factor: ``parameters: {a: 250}`` and
``xyz: [2*a, 0, -a]``. In the formulas of ``derive`` lengths so named stay symbols.

In limbs, ``position`` is what the joint reads in the drawn posture, 0 unless given; a joint
with a ``mimic`` reads what that says. A universal joint is two revolute joints ``foot_1_a``
and ``foot_1_b`` about the ``axes``, a spherical joint three, by default about x, y and z. A
parallelogram is a revolute joint at its one end and, at its other end, one that follows it
with the multiplier -1. Frames are called base and platform by default.
"""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from .fields import Fields, reported
from .joint_entries import (
    COMMON, joint_fields, MAX_JOINTS, read_joint, read_names, read_pose, resolve_mimics, Units)
from ..chains.dh import CONVENTIONS, DHRow, place_rows
from ..chains.joint import Joint
from ..chains.posture import Posture
from ..chains.serial_chain import SerialChain
from ..parallel import ParallelManipulator
from ..screws.se3 import Array

MAX_LIMBS = 100
"""Most limbs of one file."""

_FORMS = {'limbs': ('limbs', 'platform', 'actuated'), 'dh': ('dh', 'base', 'tool'),
          'joints': ('joints', 'home')}
_COMPOUND = {'universal': ('a', 'b'), 'spherical': ('a', 'b', 'c')}


@np.errstate(over='ignore', invalid='ignore')    # what overflows is refused as not finite
def robot_from_data(data: Any, source: str, name: str, base_frame: str | None = None,
                    tip_frame: str | None = None) -> SerialChain | ParallelManipulator:
    """
    Return the robot of a model file, a parallel manipulator if the file has limbs.

    The name is for a robot to which the file gives none; frames that are wanted are those that the
    file names, if it does.
    """
    given = Fields(source, '', data)
    form = next((form for form in _FORMS if form in given), 'joints')
    fields = Fields(source, '', data, (*COMMON, *_FORMS[form]))
    units = Units.of(fields)
    frames = base_frame, tip_frame
    with reported(source):
        if form == 'limbs':
            return _manipulator(fields, units, read_names(fields, name, *frames, 'platform'))
        joints, T_base_tool = (_dh_joints if form == 'dh' else _screw_joints)(fields, units)
        return SerialChain(resolve_mimics(source, joints), T_base_tool,
                           *read_names(fields, name, *frames, 'tool'))


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


def _manipulator(fields: Fields, units: Units, names: tuple[str, str, str],
                 ) -> ParallelManipulator:
    base, tip, name = names
    platform = read_pose(fields, 'platform', units, required=True)
    drawn: dict[str, float] = {}
    limbs = [_limb(fields.source, f'limb {i}', entry, units, drawn)
             for i, entry in enumerate(fields.items('limbs', MAX_LIMBS), start=1)]
    chains = [_at_zero(SerialChain(joints, platform, base, tip, limb), drawn)
              for limb, joints in limbs]
    actuated = [str(joint) for joint in fields.items('actuated', MAX_JOINTS)]
    return ParallelManipulator(chains, actuated, drawn, base, tip, name)


def _limb(source: str, place: str, entry: Any, units: Units, drawn: dict[str, float],
          ) -> tuple[str, list[Joint]]:
    """Return a limb's name and joints in the drawn posture; note the joints' readings."""
    name = Fields(source, place, entry).text('name')
    limb = Fields(source, f'limb {name!r}', entry, ('name', 'joints'))
    joints: list[Joint] = []
    for i, given in enumerate(limb.items('joints', MAX_JOINTS), start=1):
        fields = joint_fields(source, f'limb {name!r}: joint {i}', given,
                              ('axis', 'axes', 'point', 'position'))
        found = _limb_joints(fields, units)
        joints += found
        if found[0].mimic is None:
            drawn[found[0].name] = units.joint(found[0].kind, fields.number('position', 0.0))
        elif 'position' in fields:
            raise fields.error('position: a joint that follows another one has none')
    return name, resolve_mimics(source, joints)


def _limb_joints(fields: Fields, units: Units) -> list[Joint]:
    """Return the joint of an entry, or the revolute joints it stands for."""
    point = [units.length(x) for x in fields.numbers('point', 3, (0, 0, 0))]
    kind = fields.raw('kind')
    if kind not in _COMPOUND:
        return [read_joint(fields, units, fields.numbers('axis', 3), point)]
    for key in ('axis', 'position', 'mimic', 'pitch'):
        if key in fields:
            raise fields.error(f'{key}: a {kind} joint has none')
    suffixes = _COMPOUND[kind]
    default = np.eye(3).tolist() if kind == 'spherical' else None
    rows = fields.raw('axes', default)
    if not isinstance(rows, list) or len(rows) != len(suffixes):
        raise fields.wrong(rows, f'{len(suffixes)} directions', 'axes')
    name = fields.text('name')
    axes = Fields(fields.source, f'{fields.place}: axes', dict(zip(suffixes, rows)))
    return [Joint(f'{name}_{suffix}', 'revolute', np.array(axes.numbers(suffix, 3)),
                  np.array(point)) for suffix in suffixes]


def _at_zero(chain: SerialChain, drawn: Mapping[str, float]) -> SerialChain:
    """Return a chain given at the joints' readings as what it is where all read zero."""
    readings = chain.joint_values(np.array([drawn.get(n, 0.0) for n in chain.joint_names]))
    posture = Posture(chain.joints, chain.T_base_tool, -readings)
    joints = [replace(joint, axis=axis, point=point) for joint, axis, point
              in zip(chain.joints, posture.axes, posture.points)]
    return SerialChain(joints, posture.pose, chain.base_frame, chain.tip_frame, chain.name)
