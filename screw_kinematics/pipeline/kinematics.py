# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""From the motion of all joints to the state of the end effector."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from .group_motion import Motion
from ..errors import Reason


class RobotProgram(Protocol):
    """
    What a compiled robot offers.

    Attributes
    ----------
    order : int
        Highest derivative of the joint positions that it takes.
    inputs : int
        How many numbers that makes.
    slices : mapping from str to slice
        Where each of its outputs is among the values.

    """

    order: int
    inputs: int
    slices: Mapping[str, slice]

    def evaluate(self, values: Sequence[float], /) -> Sequence[float]:
        """Return the outputs from positions, velocities, ... of the joints."""

    def continue_from(self, before: RobotProgram) -> None:
        """Go on where the program before was, if samples depend on each other."""


@dataclass(slots=True)
class State:
    """
    The state of a robot at one instant.

    Attributes
    ----------
    stamp_ns : int
        The instant [ns].
    values : sequence of float
        Of the program's outputs; see its ``slices``.
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
        self._inputs = program.inputs
        self._dof = program.inputs // (program.order + 1)

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
