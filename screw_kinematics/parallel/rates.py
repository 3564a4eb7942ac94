# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
States of every order of a parallel manipulator: one linear system, new right-hand sides.

The bias of order n holds everything of the limb's recursion but the highest derivative of
its joints; it is known once the lower orders are solved.
"""
from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .closed_posture import ClosedPosture
from .limbs import Limbs
from .screw_system import SINGULAR
from ..errors import InvalidValueError, SingularityError
from ..screws.se3 import Array

INFEASIBLE = 1e-6
"""Part of a platform motion that may be left over by the limbs."""


def platform_states(limbs: Limbs, posture: ClosedPosture,
                    derivatives: Sequence[Array]) -> tuple[list[Array], list[Array]]:
    """
    Return the platform's states and the passive joints' derivatives.

    From those of the actuated joints, by order. States are reduced, pole at the platform frame's
    origin, axes of the base.
    """
    system, values = posture.system, posture.joints.tolist()
    states: list[Array] = []
    passive: list[Array] = []
    for order, given in enumerate(derivatives, start=1):
        tips = system.actuated_motion(given)
        if order > 1:
            tips = tips + limbs.bias(values, order)
        state, slots = system.solve_platform(tips)
        states.append(state)
        passive.append(slots[limbs.slot_of])
        values += [*given.tolist(), *passive[-1].tolist()]
    return states, passive


def joint_rates(limbs: Limbs, posture: ClosedPosture,
                states: Sequence[Array]) -> tuple[list[Array], list[Array]]:
    """
    Return the derivatives of the actuated and the passive joints for states of the platform.

    States are reduced, pole at the platform frame's origin, axes of the base.

    Raises
    ------
    SingularityError
        An actuator can move with the platform at rest.
    InvalidValueError
        The limbs do not allow such a motion of the platform.

    """
    system, values = posture.system, posture.joints.tolist()
    if posture.conditioning.inverse < SINGULAR:
        raise SingularityError(
            'inverse singularity: an actuator can move with the platform at rest; smallest '
            f'singular value of the actuators {posture.conditioning.inverse:.2g}')
    actuated: list[Array] = []
    passive: list[Array] = []
    for order, state in enumerate(states, start=1):
        demand = np.tile(state, (len(limbs.chains), 1))
        if order > 1:
            demand = demand - limbs.bias(values, order)
        given, slots = system.solve_joints(demand)
        left = system.size(demand - system.actuated_motion(given) - system.passive_motion(slots))
        worst = int(np.argmax(left))
        if left[worst] > INFEASIBLE * np.max(system.size(demand)):
            raise InvalidValueError(
                f'limb {limbs.names[worst]!r} does not allow the platform state of order '
                f'{order} {state.tolist()}; it would be off by {left[worst]:.3g}')
        actuated.append(given)
        passive.append(slots[limbs.slot_of])
        values += [*given.tolist(), *passive[-1].tolist()]
    return actuated, passive
