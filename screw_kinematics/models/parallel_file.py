# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Parallel manipulators from model files in YAML.

All limbs are given in one posture with closed loops, as one would draw the robot, together
with the readings of the joints there::

    name: hexapod                    # default: the file's name
    units: {length: mm, angle: deg}  # of all numbers here; default: m, rad
    base_frame: base                 # default: base, platform
    tip_frame: platform
    platform: {xyz: [0, 0, 500]}     # the platform's frame in the drawn posture
    actuated: [leg_1, leg_2]         # the measured joints; all others are passive
    limbs:
      - name: limb_1
        joints:                      # from base to platform, in the base frame
          - {name: foot_1, kind: universal, axes: [[1, 0, 0], [0, 1, 0]], point: [100, 0, 0]}
          - {name: leg_1, kind: prismatic, axis: [0, 0, 1], position: 500}
          - {name: head_1, kind: spherical, point: [100, 0, 500]}

``position`` is what the joint reads in the drawn posture, 0 unless given; a joint with a
``mimic`` reads what that says. A universal joint is two revolute joints ``foot_1_a`` and
``foot_1_b`` about the ``axes``, a spherical joint three, by default about x, y and z. All
else is as in the files of serial robots (:mod:`.model_file`). A parallelogram is a revolute
joint at its one end and, at its other end, one that follows it with the multiplier -1.
"""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from .fields import Fields, reported
from .joint_entries import (
    COMMON, joint_fields, MAX_JOINTS, measured_ends, read_joint, read_names, read_pose, units_of)
from .units import Units
from ..chains.joint import Joint
from ..chains.posture import Posture
from ..chains.serial_chain import SerialChain
from ..parallel import ParallelManipulator

MAX_LIMBS = 100
"""Most limbs of one file."""

_COMPOUND = {'universal': ('a', 'b'), 'spherical': ('a', 'b', 'c')}


def manipulator_from_data(data: Any, source: str, name: str, base_frame: str | None = None,
                          tip_frame: str | None = None) -> ParallelManipulator:
    """
    Return the parallel manipulator of a model file.

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
    ParallelManipulator

    Raises
    ------
    ModelError
        A key is unknown or missing, a value not usable, or the limbs do not make a
        parallel manipulator.

    """
    fields = Fields(source, '', data, (*COMMON, 'platform', 'actuated', 'limbs'))
    units = units_of(fields)
    with reported(source):
        platform = read_pose(fields, 'platform', units, required=True)
        drawn: dict[str, float] = {}
        limbs = [_limb(source, f'limb {i}', entry, units, drawn)
                 for i, entry in enumerate(fields.items('limbs', MAX_LIMBS), start=1)]
        base, tip, name = read_names(fields, name, base_frame, tip_frame, 'platform')
        chains = [_at_zero(SerialChain(joints, platform, base, tip, limb), drawn)
                  for limb, joints in limbs]
        return ParallelManipulator(
            chains, [str(joint) for joint in fields.items('actuated', MAX_JOINTS)], drawn,
            base, tip, name)


def _limb(source: str, place: str, entry: Any, units: Units, drawn: dict[str, float],
          ) -> tuple[str, list[Joint]]:
    """Return a limb's name and joints in the drawn posture; note the joints' readings."""
    name = Fields(source, place, entry).text('name')
    limb = Fields(source, f'limb {name!r}', entry, ('name', 'joints'))
    joints: list[Joint] = []
    for i, given in enumerate(limb.items('joints', MAX_JOINTS), start=1):
        fields = joint_fields(source, f'limb {name!r}: joint {i}', given,
                              ('axis', 'axes', 'point', 'position'))
        found = _joints(fields, units)
        joints += found
        if found[0].mimic is None:
            convert = units.length if found[0].kind == 'prismatic' else units.angle
            drawn[found[0].name] = convert(fields.number('position', 0.0))
        elif 'position' in fields:
            raise fields.error('position: a joint that follows another one has none')
    return name, measured_ends(source, joints)


def _joints(fields: Fields, units: Units) -> list[Joint]:
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
