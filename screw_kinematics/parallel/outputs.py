# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Outputs of a parallel manipulator's program, traced from the platform's states."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..chains.compiled import ORDERS as PLATFORM_ORDERS, output_sizes as platform_sizes
from ..programs.tracing import Graph, straight_line, StraightLine
from ..screws.body_state import BodyState
from ..screws.rigid import pose_from_row
from ..screws.se3 import Array

ORDERS = {**PLATFORM_ORDERS, 'passive_position': 0, 'passive_velocity': 1}
"""Outputs, and the highest derivative of the actuated joints' positions that each needs."""

FURTHER = ('jacobian', 'passive_position', 'passive_velocity')
"""What is read after pose and states, in this order, where asked for."""


def output_sizes(outputs: Sequence[str], dof: int, passive: int) -> dict[str, int]:
    """Return how many numbers each output has, of so many actuated and passive joints."""
    sizes = platform_sizes(outputs, dof)
    return {name: passive if name.startswith('passive_') else sizes[name] for name in outputs}


def trace_outputs(outputs: Sequence[str], order: int, dof: int, passive: int, axes: str,
                  pole: str) -> tuple[StraightLine, list[str]]:
    """
    Return the program from solved quantities to the outputs asked for.

    Parameters
    ----------
    outputs : sequence of str
        Any of ORDERS.
    order : int
        Number of reduced states.
    dof, passive : int
        Numbers of actuated and of passive joints.
    axes, pole : {'base', 'tip'}
        Whose axes, and about which point, the six-vectors are.

    Returns
    -------
    line : StraightLine
        Reads position and rotation of the platform, its reduced states about its frame's
        origin in base axes; then, if among the outputs, the Jacobian, and positions and
        velocities of the passive joints.
    names : list of str
        Of what it reads.

    """
    sizes = output_sizes(outputs, dof, passive)
    read = {'pose': 12, 'state': 6 * order, **{n: sizes[n] for n in FURTHER if n in outputs}}
    inputs = Graph().inputs(sum(read.values()))
    parts = dict(zip(read, np.split(inputs, np.cumsum(list(read.values()))[:-1])))
    pose = pose_from_row(parts['pose'])

    def seen(*fields: Array) -> BodyState:
        return BodyState(pose, fields, pose[:3, 3]).about(pole).expressed_in(axes)

    state = seen(*parts['state'].reshape(order, 6))
    values: list[Any] = []
    for name in outputs:
        if name == 'jacobian':
            # Columns are twists per unit rate: they go to other poles and axes as states do.
            values += seen(parts[name].reshape(6, dof).T).velocity.T.ravel().tolist()
        elif name in parts:
            values += parts[name].tolist()
        elif name.startswith('reduced_'):
            values += state.reduced[ORDERS[name] - 1].tolist()
        else:
            values += state.classical(ORDERS[name]).tolist()
    return straight_line(len(inputs), values), [
        f'{name}{k}' for name, size in read.items() for k in range(size)]
