# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A compiled parallel manipulator: one call from actuated joints to the platform."""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from typing import Any, TYPE_CHECKING

import numpy as np

from .closed_posture import ClosedPosture, posture_of
from .limbs import Limbs
from .loop_closure import close_loops
from .posture_tracker import PostureTracker
from ..errors import ClosureError, InvalidValueError
from ..programs.program import Program
from ..programs.quantities import checked_outputs, find_quantity, order_of, WITHOUT_SCREWS
from ..programs.straight_line_program import StraightLineProgram
from ..programs.tracing import Graph, straight_line
from ..screws.body_state import BodyState
from ..screws.rigid import pose_from_row
from ..screws.se3 import Array

if TYPE_CHECKING:
    from .manipulator import ParallelManipulator

__all__ = ['ParallelProgram']

FURTHER = ('jacobian', 'passive_position', 'passive_velocity')
"""What is read after pose and states, in this order, where asked for."""


class ParallelProgram(Program):
    """
    The kinematics of a parallel manipulator for a stream of samples.

    Made by ``manipulator.compile(...)``; used as :class:`~screw_kinematics.programs.Program` is,
    but samples depend on each other: each posture is found from the one before, which
    keeps the assembly mode. A sample that cannot be solved raises an error and is
    forgotten; the next one starts again from the last good posture.

    Parameters
    ----------
    manipulator : ParallelManipulator
        What is compiled.
    outputs : iterable of str
        As for a serial chain, and 'passive_position' and 'passive_velocity' of the passive
        joints.
    axes, pole : {'base', 'tip'}
        Whose axes, and about which point, the six-vectors are.

    Attributes
    ----------
    passive_joint_names : tuple of str
        In the order of their positions and velocities.

    """

    def __init__(self, manipulator: ParallelManipulator, outputs: Iterable[str],
                 axes: str = 'base', pole: str = 'tip') -> None:
        outputs = checked_outputs(outputs, axes, pole, WITHOUT_SCREWS)
        order = order_of(outputs)
        dof, passive = manipulator.dof, len(manipulator.passive_joint_names)
        line = trace_outputs(outputs, order, dof, passive, axes, pole)
        super().__init__(line, _sizes(outputs, dof, passive), manipulator.joint_names,
                         order, axes, pole, manipulator.base_frame, manipulator.tip_frame)
        self.passive_joint_names = manipulator.passive_joint_names
        self._limbs = Limbs(manipulator.limbs, manipulator.joint_names,
                            manipulator.characteristic_length)
        self._home = manipulator.home
        self._closed = manipulator.closure_tolerance
        self._tracker = PostureTracker(self._limbs, self._home, self._closed, order,
                                       'jacobian' in outputs)
        self.evaluate = self._evaluate
        self.reset()

    @property
    def posture(self) -> ClosedPosture:
        """Return the last good posture."""
        return self._tracker.posture

    @posture.setter
    def posture(self, posture: ClosedPosture) -> None:
        self._tracker.posture = posture

    @property
    def operations(self) -> int:
        """
        Return how many operations a sample near the last one takes, two Newton steps in it.

        0 where postures are searched for (:attr:`traced` is False): that takes as it comes.
        """
        steps = self._tracker.operations
        return 0 if steps is None else steps + super().operations

    @property
    def traced(self) -> bool:
        """Whether samples near the last one take traced steps, and no search."""
        return self._tracker.operations is not None

    @property
    def passive_rates(self) -> list[Array]:
        """Return time derivatives 1 to ``order`` of the passive joints at the last sample."""
        n = len(self.passive_joint_names)
        return [np.array(self._rates[k:k + n]) for k in range(0, len(self._rates), n)]

    def reset(self) -> None:
        """Forget the stream: the next sample is found from the home posture."""
        self._tracker.reset()
        self._rates: Sequence[float] = ()

    def continue_from(self, before: Program) -> None:
        """
        Go on from the last good posture of the program that this one replaces.

        Parameters
        ----------
        before : Program
            Of the same robot, perhaps with another tool. One of other joints, or whose
            last posture is none of this robot, is ignored.

        """
        if not isinstance(before, ParallelProgram) or (
                before._limbs.joint_names != self._limbs.joint_names):
            return
        posture = before.posture
        solution = close_loops(self._limbs, posture.joints, self._home.system.ranks)
        with suppress(ClosureError):
            self.posture = posture_of(
                self._limbs, solution, posture.working_mode, self._closed)

    def report(self) -> dict[str, float]:
        """
        Return how the last good posture is, for diagnostics.

        Returns
        -------
        dict from str to float
            Distances to singularities (0 is singular, see :class:`Conditioning`), largest
            misfit of a loop, Newton steps, and number of limbs on the other side of an
            inverse singularity than at home.

        """
        posture = self.posture
        distance = posture.conditioning
        return {'distance to direct singularity': distance.direct,
                'distance to inverse singularity': distance.inverse,
                'distance to limb singularity': distance.limbs,
                'largest misfit of a loop': float(posture.misfit.max()),
                'Newton steps': posture.iterations,
                'limbs in another working mode': int((posture.working_mode < 0).sum())}

    def __call__(self, *motion: Any) -> dict[str, Array]:
        """Return the outputs for one sample; see :meth:`Program.__call__`."""
        values = np.concatenate(self._checked(motion, 1)).tolist()
        flat = np.array(self.evaluate(values))
        return {name: flat[part] for name, part in self.slices.items()}

    def batch(self, *motion: Any, out: Array | None = None,
              threads: int = 1) -> dict[str, Array]:
        """
        Return the outputs for many samples, each found from the one before.

        Parameters
        ----------
        *motion : array, shape (N, dof)
            q and its derivatives up to at least ``order``.
        out : array, shape (N, size of all outputs), optional
            Where the results go.
        threads : int
            Without effect: each sample needs the one before.

        Returns
        -------
        dict from str to array, shape (N, size of the output)
            Views of ``out``.

        """
        samples = np.concatenate(self._checked(motion, 2), axis=1)
        results = self._results(len(samples), out)
        for k, row in enumerate(samples.tolist()):
            results[k] = self.evaluate(row)
        return {name: results[:, part] for name, part in self.slices.items()}

    def source(self, language: str, name: str = 'tip_motion') -> str:
        """
        Raise an error: a posture is searched for, which is no straight-line program.

        Parameters
        ----------
        language, name : str
            As for the program of a chain.

        Raises
        ------
        InvalidValueError
            Always.

        """
        raise InvalidValueError(
            'a parallel manipulator has no source text; its postures are found by iteration')

    def _evaluate(self, values: Sequence[float]) -> Sequence[float]:
        solved = self._tracker.update(values)
        n = len(self.passive_joint_names)
        self._rates = solved.passive_rates
        numbers = solved.seen
        if 'passive_position' in self.slices:
            numbers = [*numbers, *solved.passive]
        if 'passive_velocity' in self.slices:
            numbers = [*numbers, *solved.passive_rates[:n]]
        return self._machine.evaluate(numbers)


def _sizes(outputs: Sequence[str], dof: int, passive: int) -> dict[str, int]:
    """Return how many numbers each output has."""
    return {name: find_quantity(name, WITHOUT_SCREWS).size(dof, passive=passive)
            for name in outputs}


def trace_outputs(outputs: Sequence[str], order: int, dof: int, passive: int, axes: str,
                  pole: str) -> StraightLineProgram:
    """
    Return the program from solved quantities to the outputs asked for.

    It reads position and rotation of the platform, its reduced states up to an order about its
    frame's origin in base axes; then, if among the outputs, the Jacobian, and positions and
    velocities of the passive joints.
    """
    sizes = _sizes(outputs, dof, passive)
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
        else:
            values += find_quantity(name, WITHOUT_SCREWS).of(state).tolist()
    return straight_line(len(inputs), values)
