# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How large an arm is, in how many directions its tip moves, and by which joints."""
from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .serial_chain import SerialChain

_POSTURES = 20


class Freedom(NamedTuple):
    """Longest lever arm [m], directions of six that the tip moves in, joints that do nothing."""

    size: float
    rank: int
    idle: tuple[str, ...]


def freedom_of(chain: SerialChain) -> Freedom:
    """
    Return the freedom of a chain's tip, in postures with all joints within 1 rad or m.

    Examples
    --------
    >>> from screw_kinematics import Joint
    >>> freedom_of(SerialChain([Joint('turn', 'revolute', (0, 0, 1)),
    ...                         Joint('slide', 'prismatic', (0, 0, 1))])).rank
    2

    """
    postures = np.random.default_rng(0).uniform(-1.0, 1.0, (_POSTURES, chain.dof))
    jacobians = chain.jacobian(postures)
    size = max(float(np.abs(jacobians[:, 3:]).max()), 1e-9)
    jacobians[:, 3:] /= size
    moved = np.abs(jacobians).max(axis=(0, 1)) > 1e-12
    return Freedom(size, int(np.linalg.matrix_rank(jacobians, tol=1e-9).max()),
                   tuple(name for name, moves in zip(chain.joint_names, moved) if not moves))
