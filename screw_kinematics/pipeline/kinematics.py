# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""From the motion of all joints to the state of the end effector."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .group_motion import Motion
from .robot_program import RobotProgram
from ..errors import Reason


@dataclass(slots=True)
class State:
    """
    The state of a robot at one instant.

    Attributes
    ----------
    stamp_ns : int
        The instant [ns].
    values : sequence of float
        Of the program's outputs; see its ``tips``.
    motion : Motion
        Of the joints.
    order : int
        Highest derivative of the joint positions that is known: outputs that need a higher one
        have no values.

    """

    stamp_ns: int
    values: Sequence[float]
    motion: Motion
    order: int


class Kinematics:
    """
    What is computed for each sample.

    Parameters
    ----------
    program : RobotProgram
    covariance : bool
        Whether the variances of the joints' motion are wanted too.
    order : int
        Derivative of the joints' motion that is wanted, beside what the program takes.

    """

    def __init__(self, program: RobotProgram, covariance: bool = False, order: int = 0) -> None:
        self.program = program
        self.covariance = covariance
        self.order = max(program.order, order)
        self._dof = program.dof
        self._inputs = program.dof * (program.order + 1)

    def evaluate(self, motion: Motion) -> State | Reason:
        """
        Return the state that a motion of all joints leads to.

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
        values = self.program.evaluate(inputs)
        total = sum(values)
        if total - total != 0.0:
            return Reason.STATE_NOT_FINITE
        return State(motion.stamp_ns, values, motion, order)
