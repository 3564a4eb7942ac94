# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""From the motion of all joints to the state of the end effector."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .group_motion import Motion
from .moving_base import BaseMotion
from .robot_program import RobotProgram
from ..errors import Reason
from ..programs.moving_base import AT_REST


@dataclass
class State:
    """
    The state of a robot at one instant.

    Values are those of the program's outputs, see its ``tips``; outputs that need a higher
    derivative of the joint positions than the order have none. Without base, what is relative to
    the world has none, though it is wanted.
    """

    stamp_ns: int
    values: Sequence[float]
    motion: Motion
    order: int
    base: BaseMotion | None = None
    without_base: bool = False


class Kinematics:
    """
    What is computed for each sample.

    ``told`` is the highest derivative of the joint positions in what is told, by default that of
    the program; ``order`` that which is wanted of the joints' motion, for this and the program.
    """

    def __init__(self, program: RobotProgram, covariance: bool = False,
                 order: int | None = None) -> None:
        self.program, self._evaluate = program, program.evaluate
        self.covariance = covariance
        self.told = program.order if order is None else order
        self.order = max(program.order, self.told)
        self.moving_base, self.standing_base = program.moving_base, program.standing_base
        self._dof = program.dof
        self._inputs = program.dof * (program.order + 1)

    def evaluate(self, motion: Motion, base: BaseMotion | None = None) -> State | Reason:
        """
        Return the state that a motion of all joints, and of the base, leads to.

        Raises
        ------
        ScrewKinematicsError, ArithmeticError, ValueError
            The robot has no state at this posture.

        """
        inputs = motion.values
        order = len(inputs) // self._dof - 1
        if len(inputs) > self._inputs:
            inputs = inputs[:self._inputs]
        elif len(inputs) < self._inputs:
            inputs = [*inputs, *(0.0,) * (self._inputs - len(inputs))]
        if self.moving_base:
            inputs = [*inputs, *(AT_REST if base is None else base.values)]
        values = self._evaluate(inputs)
        total = 0.0
        for value in values:
            total += value
        if total - total != 0.0:
            return Reason.STATE_NOT_FINITE
        return State(motion.stamp_ns, values, motion, order, base,
                     self.moving_base and base is None)
