# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What a robot computes for each sample: the program of its tip, or those of several tips."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from .robot_model import TipsModel
from .settings import RobotSettings
from ..programs.moving_base import BASE_INPUTS, MovingBaseProgram

Needs = tuple[tuple[str, ...], ...]
"""For each tip the outputs of its program; none if nobody listens."""


class RobotProgram(Protocol):
    """
    What a compiled robot offers.

    Attributes
    ----------
    order : int
        Highest derivative of the joint positions that it takes.
    dof : int
        Number of measured joints.
    moving_base, standing_base : bool
        Whether some of its outputs are relative to the world, so that it takes the motion of the
        base behind that of the joints; and whether some are relative to the base.

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

    def evaluate(self, values: Sequence[float]) -> Sequence[float]:
        """Return the outputs from positions, velocities, ... of the joints."""
        values = self.program.evaluate(values)
        return values

    def continue_from(self, before: Any) -> None:
        """Go on where the program before was."""
        if isinstance(before, OneTip):
            self.program.continue_from(before.program)

    def report(self) -> dict[str, Any]:
        """Return how the last posture is, if the program knows."""
        return dict(getattr(self.program, 'report', dict)())


class SeveralTips:
    """The programs of several tips, each of which takes its own joints of all."""

    def __init__(self, model: TipsModel, needs: Needs, settings: RobotSettings) -> None:
        self.dof = n = len(model.joint_names)
        self.order = 0
        self.tips: list[dict[str, slice]] = []
        self._parts: list[tuple[Any, list[int]]] = []
        self.moving_base = self.standing_base = False
        moving: list[list[int]] = []
        end = 0
        for tip, columns, wanted, own in zip(
                model.tips, model.columns, needs, settings.parts):
            if not wanted:
                self.tips.append({})
                continue
            program = compile_tip(tip, wanted, own)
            self.order = max(self.order, program.order)
            inputs = [k * n + column for k in range(program.order + 1) for column in columns]
            self._parts.append((program, inputs))
            if own.relative_to == 'world':
                self.moving_base = True
                moving.append(inputs)
            else:
                self.standing_base = True
            self.tips.append({name: slice(part.start + end, part.stop + end)
                              for name, part in program.slices.items()})
            end += max(part.stop for part in program.slices.values())
        for inputs in moving:       # the base's motion is behind that of all joints
            inputs += range((self.order + 1) * n, (self.order + 1) * n + BASE_INPUTS)

    def evaluate(self, values: Sequence[float]) -> Sequence[float]:
        """Return the outputs of all tips, one after the other."""
        outputs: list[float] = []
        for program, inputs in self._parts:
            outputs += program.evaluate([values[i] for i in inputs])
        return outputs

    def continue_from(self, before: Any) -> None:
        """Do nothing: samples of open chains are independent."""

    def report(self) -> dict[str, Any]:
        """Return nothing: open chains have no posture to look for."""
        return {}
