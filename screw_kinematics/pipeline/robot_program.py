# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What a robot computes for each sample: the program of its tip, or those of several tips."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from .robot_model import TipsModel
from .settings import RobotSettings
from ..programs.joining import joined
from ..programs.machine import machine
from ..programs.moving_base import BASE_INPUTS, MovingBaseProgram
from ..programs.program import Program
from ..programs.straight_line_program import StraightLineProgram

Needs = tuple[tuple[str, ...], ...]
"""For each tip the outputs of its program; none if nobody listens."""


class RobotProgram(Protocol):
    """
    What a compiled robot offers.

    The order is the highest derivative of the joint positions that it takes. Where some of its
    outputs are relative to the world, it takes the motion of the base behind that of the joints.
    """

    order: int
    dof: int
    moving_base: bool
    standing_base: bool

    @property
    def tips(self) -> Sequence[Mapping[str, slice]]:
        """Return for each tip where its outputs are among the values."""

    def evaluate(self, values: Sequence[float]) -> Sequence[float]:
        """Return the outputs from positions, velocities, ... of the joints."""

    def continue_from(self, before: Any) -> None:
        """Go on where the program before was, if samples depend on each other."""

    def report(self) -> dict[str, Any]:
        """Return how the last posture is, if that is known."""


def compile_robot(model: Any, needs: Needs, settings: RobotSettings) -> RobotProgram:
    """Return the program for these outputs, with axes and reference points of the settings."""
    if isinstance(model, TipsModel):
        return SeveralTips(model, needs, settings)
    return OneTip(compile_tip(model, needs[0], settings), settings.relative_to == 'world')


def compile_tip(model: Any, needs: Sequence[str], settings: RobotSettings) -> Any:
    """Return the program of one tip, relative to the base or to the world."""
    choices = {'axes': settings.expressed_in, 'pole': settings.reference_point}
    if settings.relative_to == 'world':
        return MovingBaseProgram(model, needs, **choices)
    return model.compile(needs, **choices)


class OneTip:
    """The program of a model, as it is."""

    def __init__(self, program: Any, moving_base: bool = False) -> None:
        self.program = program
        self.moving_base, self.standing_base = moving_base, not moving_base
        self.order, self.dof = program.order, program.dof
        self.tips = [program.slices]
        self.evaluate = program.evaluate

    def continue_from(self, before: Any) -> None:
        """Go on where the program before was."""
        if isinstance(before, OneTip):
            self.program.continue_from(before.program)

    def report(self) -> dict[str, Any]:
        """Return how the last posture is, if the program knows."""
        return dict(getattr(self.program, 'report', dict)())


class SeveralTips:
    """
    The programs of several tips, each of which takes its own joints of all.

    Those of open chains are one program, in which what the tips have in common is computed once.
    """

    def __init__(self, model: TipsModel, needs: Needs, settings: RobotSettings) -> None:
        self.dof = n = len(model.joint_names)
        wanted = [(k, compile_tip(tip, outputs, own), own.relative_to == 'world') for
                  k, (tip, outputs, own) in enumerate(zip(model.tips, needs, settings.parts))
                  if outputs]
        self.order = max((program.order for _, program, _ in wanted), default=0)
        self.moving_base = any(moving for *_, moving in wanted)
        self.standing_base = not all(moving for *_, moving in wanted)
        self.tips: list[dict[str, slice]] = [{} for _ in needs]
        lines: list[tuple[StraightLineProgram, list[int]]] = []
        self._others: list[tuple[Any, list[int]]] = []
        # Those of one program come first among the values.
        wanted.sort(key=lambda each: type(each[1]) is not Program)
        end, joints = 0, (self.order + 1) * n
        for k, program, moving in wanted:
            inputs = [d * n + column for d in range(program.order + 1)
                      for column in model.columns[k]]
            if moving:      # the base's motion is behind that of all joints
                inputs += range(joints, joints + BASE_INPUTS)
            if type(program) is Program:
                lines.append((program.line, inputs))
            else:
                self._others.append((program, inputs))
            self.tips[k] = {name: slice(part.start + end, part.stop + end)
                            for name, part in program.slices.items()}
            end += max(part.stop for part in program.slices.values())
        self._joints = joints
        self._together = machine(joined(lines, joints)).evaluate if lines else None

    def evaluate(self, values: Sequence[float]) -> Sequence[float]:
        """Return the outputs of all tips, one after the other."""
        outputs: Sequence[float] = ()
        if self._together is not None:
            outputs = self._together(values[:self._joints] if self.moving_base else values)
        for program, inputs in self._others:
            outputs = (*outputs, *program.evaluate([values[i] for i in inputs]))
        return outputs

    def continue_from(self, before: Any) -> None:
        """Do nothing: samples of open chains are independent."""

    def report(self) -> dict[str, Any]:
        """Return nothing: open chains have no posture to look for."""
        return {}
