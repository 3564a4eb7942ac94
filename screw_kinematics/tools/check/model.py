# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What a robot model means for the node, and what may be wrong with it."""
from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .findings import FACT, Finding, REMARK
from ...chains.freedom import freedom_of
from ...chains.serial_chain import SerialChain
from ...parallel import ParallelProgram


def report_model(robot: Any) -> Iterator[Finding]:
    """Yield what is found in a model that could be read."""
    yield Finding(FACT, f'{robot!r}')
    for warning in robot.warnings:
        yield Finding(REMARK, warning)
    listed = ', '.join(f'{name} ({kind})'
                       for name, kind in zip(robot.joint_names, robot.joint_kinds))
    yield Finding(FACT, f'measured joints, which must be published: {listed or "none"}')
    inside = {joint.name for joint in robot.joints}
    for joint in robot.joints:
        if joint.mimic is not None:
            where = '' if joint.mimic.joint in inside else ', a joint outside the chain'
            yield Finding(FACT, f'joint {joint.name!r} follows {joint.mimic.joint!r}{where}: '
                                f'q = {joint.mimic.multiplier:g} q + {joint.mimic.offset:g}')
    if not robot.joint_names:
        yield Finding(REMARK, f'no joint moves {robot.tip_frame} relative to '
                              f'{robot.base_frame}', 'choose other frames')
        return
    if isinstance(robot, SerialChain):
        yield from _report_freedom(robot)
    program = robot.compile(('pose', 'twist', 'accel'))
    if isinstance(program, ParallelProgram) and not program.traced:
        yield Finding(FACT, 'each posture is searched for: passive joints can move by themselves')
    else:
        where = ', two Newton steps included' if isinstance(program, ParallelProgram) else ''
        yield Finding(FACT, 'pose, twist and acceleration take '
                            f'{program.operations} operations{where}')


def _report_freedom(robot: SerialChain) -> Iterator[Finding]:
    """Say in how many directions the tip moves, and which joints do not move it."""
    found = freedom_of(robot)
    spare = robot.dof - found.rank
    yield Finding(FACT, f'{robot.tip_frame} moves in {found.rank} of 6 directions'
                        + (f'; {spare} joint(s) to spare' if spare else ''))
    if found.idle:
        yield Finding(REMARK, f'{", ".join(found.idle)}: moves nothing')
