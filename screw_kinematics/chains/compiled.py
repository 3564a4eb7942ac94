# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Tracing of chains: from the names of outputs to a compiled program."""
from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, TYPE_CHECKING

import numpy as np

from .tip_motion import tip_motion
from ..errors import InvalidValueError, UnknownNameError
from ..programs.instructions import StraightLine
from ..programs.program import Program
from ..programs.tracing import Graph, straight_line
from ..screws.body_state import BodyState
from ..screws.reference import FRAMES
from ..screws.rigid import row_of_pose
from ..screws.se3 import Array, rotate
from ..screws.states import reduced_from_classical

if TYPE_CHECKING:
    from .serial_chain import SerialChain

ORDERS = {'pose': 0, 'jacobian': 0, 'twist': 1, 'accel': 2, 'reduced_accel': 2, 'jerk': 3,
          'reduced_jerk': 3, 'snap': 4, 'reduced_snap': 4}
"""Outputs, and the highest derivative of the joint positions that each needs."""


def compile_chain(chain: SerialChain, outputs: Iterable[str] = ('pose', 'twist', 'accel'),
                  axes: str = 'base', pole: str = 'tip') -> Program:
    """
    Return the compiled program of a chain; see :meth:`SerialChain.compile`.

    Raises
    ------
    UnknownNameError, InvalidValueError
        An output, axes or pole is unknown; the message lists those that exist.

    """
    outputs = checked_outputs(outputs, axes, pole)
    symbols = [x for x in _parameters(chain) if np.asarray(x).dtype == object]
    if symbols:
        raise InvalidValueError(
            f'{chain!r} has symbolic parameters; only a chain of numbers can be compiled')
    order = max(ORDERS[output] for output in outputs)
    line = trace_chain(chain, outputs, order, axes, pole)
    return Program(line, output_sizes(outputs, chain.dof), chain.joint_names, order, axes,
                   pole, chain.base_frame, chain.tip_frame)


def checked_outputs(outputs: Iterable[str], axes: str, pole: str,
                    known: Mapping[str, int] = ORDERS) -> tuple[str, ...]:
    """Return the names of the outputs, after checking them, axes and pole."""
    outputs = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    if not outputs:
        raise InvalidValueError(f'no outputs asked for; known: {", ".join(known)}')
    for output in outputs:
        if output not in known:
            raise UnknownNameError('output', output, known)
        if outputs.count(output) > 1:
            raise InvalidValueError(f'output {output!r} is asked for more than once')
    for what, value in (('axes', axes), ('pole', pole)):
        if value not in FRAMES:
            raise UnknownNameError(what, value, FRAMES)
    return outputs


def output_sizes(outputs: Iterable[str], dof: int) -> dict[str, int]:
    """Return how many numbers each output has."""
    return {name: 12 if name == 'pose' else 6 * dof if name == 'jacobian' else 6
            for name in outputs}


def _parameters(chain: SerialChain) -> list[Any]:
    mimics = [joint.mimic for joint in chain.joints if joint.mimic is not None]
    return [chain.T_base_tool,
            *[x for joint in chain.joints for x in (joint.axis, joint.point, joint.pitch)],
            *[x for mimic in mimics for x in (mimic.multiplier, mimic.offset)]]


def trace_chain(chain: SerialChain, outputs: Iterable[str], order: int, axes: str,
                pole: str) -> StraightLine:
    """Return the straight-line program of a chain's outputs, in the order given."""
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
            values += [*_jacobian(chain, q, pose, axes, pole).ravel()]
        elif name.startswith('reduced_'):
            values += [*seen.reduced[ORDERS[name] - 1]]
        elif pole == 'tip':
            # Already classical, so it need not be made from the reduced state.
            motion = motions[ORDERS[name] - 1]
            values += [*(motion if axes == 'base' else rotate(pose[:3, :3].T, motion))]
        else:
            values += [*seen.classical(ORDERS[name])]
    return straight_line(len(inputs), values)


def _jacobian(chain: SerialChain, q: Array, pose: Array, axes: str, pole: str) -> Array:
    """Return d twist / d qd of the measured joints, shape (6, dof)."""
    jacobian = chain.jacobian(q, pole)
    if axes == 'base' or not chain.dof:
        return jacobian
    # By the pose that is computed anyway, which chain.jacobian does not know.
    return np.stack([rotate(pose[:3, :3].T, column) for column in jacobian.T], axis=-1)
