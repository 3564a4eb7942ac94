# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Tracing of chains: from the names of outputs to a straight-line program."""
from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TYPE_CHECKING

import numpy as np

from .tip_motion import tip_motion
from ..errors import InvalidValueError
from ..programs.quantities import checked_outputs, find_quantity, order_of
from ..programs.straight_line_program import StraightLineProgram
from ..programs.tracing import Graph, straight_line
from ..screws.body_state import BodyState
from ..screws.rigid import row_of_pose
from ..screws.se3 import Array, rotate
from ..screws.states import reduced_from_classical

if TYPE_CHECKING:
    from .serial_chain import SerialChain


def trace_chain(chain: SerialChain, outputs: Iterable[str], axes: str, pole: str,
                ) -> StraightLineProgram:
    """
    Return the straight-line program of a chain's quantities, one behind the other.

    It reads positions and derivatives by order.
    """
    outputs = checked_outputs(outputs, axes, pole)
    if any(np.asarray(x).dtype == object for x in _parameters(chain)):
        raise InvalidValueError(
            f'{chain!r} has symbolic parameters; only a chain of numbers can be compiled')
    order = order_of(outputs)
    n = chain.dof
    inputs = Graph().inputs((order + 1) * n)
    q, *derivatives = [inputs[k * n:(k + 1) * n] for k in range(order + 1)]
    pose, motions = tip_motion(chain, q, *derivatives)
    state = BodyState(pose, tuple(reduced_from_classical(motions)), pose[:3, 3])
    seen = state.about(pole).expressed_in(axes)
    values: list[Any] = []
    for name in outputs:
        if name == 'pose':
            values += [*row_of_pose(pose)]
        elif name == 'jacobian':
            values += [*_in_axes(chain.jacobian(q, pole).T, pose, axes).T.ravel()]
        elif name == 'screws':
            values += [*_in_axes(chain.screws(q, pole), pose, axes).ravel()]
        elif name == 'coriolis_lie':
            values += [*_in_axes(chain.coriolis_lie(q, derivatives[0], pole), pose, axes)]
        elif pole == 'tip' and not find_quantity(name).reduced:
            # Already classical, so it need not be made from the reduced state.
            values += [*_in_axes(motions[find_quantity(name).order - 1], pose, axes)]
        else:
            values += [*find_quantity(name).of(seen)]
    return straight_line(len(inputs), values)


def _parameters(chain: SerialChain) -> list[Any]:
    mimics = [joint.mimic for joint in chain.joints if joint.mimic is not None]
    return [chain.T_base_tool,
            *[x for joint in chain.joints for x in (joint.axis, joint.point, joint.pitch)],
            *[x for mimic in mimics for x in (mimic.multiplier, mimic.offset)]]


def _in_axes(x: Array, pose: Array, axes: str) -> Array:
    """Return six-vectors of base axes in the wanted ones, by the pose that is known anyway."""
    return x if axes == 'base' or not len(x) else rotate(pose[:3, :3].T, x)
