# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Parallel manipulators: a platform carried by several limbs."""
from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from .closed_posture import closed_posture, ClosedPosture
from .continuation import check_same_mode, follow
from .home import close_at_home, mobility_at_home
from .limb_motion import LimbMotion
from .limbs import Limbs
from .loop_closure import reach
from .program import ParallelProgram
from ..chains.joint import Joint
from ..chains.serial_chain import SerialChain
from ..screws.body_state import BodyState
from ..screws.rigid import rigid_displacement
from ..screws.se3 import Array


class ParallelManipulator(LimbMotion):
    """
    A platform carried by limbs, some of whose joints are measured; immutable.

    Parameters
    ----------
    limbs : iterable of SerialChain
        At least two, with different names, from the base frame to the platform frame.
        The loops need not be closed at q = 0.
    actuated : sequence of str
        Names of the measured joints; all others are passive. They must hold the platform
        when locked. More than that are used in the sense of least squares.
    home : mapping from str to float, optional
        Joint positions [rad, m] near which the loops close in the assembly mode that is
        meant; joints not named start from 0.
    base_frame, tip_frame : str
        Frame names.
    name : str
        Name of the robot, for messages.
    characteristic_length : float, optional
        What makes angles and lengths comparable [m]. Default: mean distance of the
        limbs' last joints from the platform frame's origin.
    closure_tolerance : float, optional
        Largest misfit of a closed loop (rad, or lengths by the characteristic length).
        Default: 1e-8, and 1e-2 if the measurements are redundant, since real ones
        contradict each other.

    Raises
    ------
    InvalidValueError
        The limbs do not make a parallel manipulator, or the actuated joints do not hold
        the platform.
    ClosureError
        The loops do not close near ``home``.

    Examples
    --------
    A four-bar linkage, whose coupler is the platform:

    >>> from screw_kinematics import Joint
    >>> def crank(name, x):
    ...     return SerialChain([Joint(f'{name}_base', 'revolute', (0, 0, 1), (x, 0, 0)),
    ...                         Joint(f'{name}_tip', 'revolute', (0, 0, 1), (x, 1, 0))],
    ...                        [[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1]],
    ...                        name=name)
    >>> linkage = ParallelManipulator([crank('left', 0), crank('right', 2)], ['left_base'])
    >>> linkage.state([0.0], [1.0]).velocity.round(12) + 0.0
    array([ 0.,  0.,  0., -1.,  0.,  0.])

    """

    def __init__(self, limbs: Iterable[SerialChain], actuated: Sequence[str],
                 home: Mapping[str, float] | None = None, base_frame: str = 'base',
                 tip_frame: str = 'platform', name: str = '',
                 characteristic_length: float | None = None,
                 closure_tolerance: float | None = None) -> None:
        self.base_frame = base_frame
        self.tip_frame = tip_frame
        self.name = name
        self._limbs = Limbs(tuple(limbs), tuple(actuated), length=characteristic_length)
        self.joint_names = self._limbs.actuated
        self.passive_joint_names = self._limbs.passive
        solution = close_at_home(self._limbs, home or {})
        self.mobility = mobility_at_home(self._limbs, solution.system)
        if closure_tolerance is None:
            closure_tolerance = 1e-2 if self.dof > self.mobility else 1e-8
        self.closure_tolerance = closure_tolerance
        self.home = closed_posture(self._limbs, solution, np.ones(self.dof, dtype=int),
                                   self.closure_tolerance)

    def __repr__(self) -> str:
        return (f'ParallelManipulator({self.name or "unnamed"}: {len(self.limbs)} limbs, '
                f'{self.dof} actuated and {len(self.passive_joint_names)} passive joints, '
                f'{self.base_frame} -> {self.tip_frame})')

    @property
    def limbs(self) -> tuple[SerialChain, ...]:
        """Return the limbs, each an open chain from base to platform."""
        return self._limbs.chains

    @property
    def joint_kinds(self) -> tuple[str, ...]:
        """Return the kinds of the actuated joints: 'revolute', 'continuous' or another."""
        return self._limbs.joint_kinds[:self.dof]

    @property
    def velocity_limits(self) -> Array:
        """Return their largest speeds [rad/s, m/s], infinite if unknown; shape (dof,)."""
        return self._limbs.velocity_limits[:self.dof]

    @property
    def characteristic_length(self) -> float:
        """Return the length by which angles and lengths are made comparable [m]."""
        return self._limbs.length

    @property
    def joints(self) -> tuple[Joint, ...]:
        """Return the joints of all limbs."""
        return tuple(joint for chain in self.limbs for joint in chain.joints)

    def with_tool(self, T_tip_tool: Any,    # noqa: N803
                  tip_frame: str | None = None) -> ParallelManipulator:
        """
        Return the manipulator with a tool mounted on its platform.

        Parameters
        ----------
        T_tip_tool : array, shape (4, 4)
            Pose of the tool in the present platform frame [m].
        tip_frame : str, optional
            Name of the new tip frame.

        """
        return ParallelManipulator(
            [chain.with_tool(T_tip_tool, tip_frame) for chain in self.limbs], self.joint_names,
            dict(zip(self._limbs.joint_names, self.home.joints)), self.base_frame,
            self.tip_frame if tip_frame is None else tip_frame, self.name,
            self.characteristic_length, self.closure_tolerance)

    def posture(self, q: Any, start: ClosedPosture | None = None) -> ClosedPosture:
        """
        Return the posture for given actuated joints.

        Parameters
        ----------
        q : array, shape (dof,)
            Positions of the actuated joints [rad, m].
        start : ClosedPosture, optional
            A posture on the same branch, best one nearby. Default: home.

        Returns
        -------
        ClosedPosture
            In the assembly mode of ``start``.

        Raises
        ------
        ClosureError, AssemblyModeError, SingularityError
            The way from ``start`` does not lead there; the message says why and where.

        """
        return follow(self._limbs, start or self.home, self._vector('q', q),
                      self.closure_tolerance)

    def posture_at(self, pose: Any, start: ClosedPosture | None = None) -> ClosedPosture:
        """
        Return the posture with the platform at a given pose: the inverse problem.

        Parameters
        ----------
        pose : array, shape (4, 4)
            Of the platform frame in the base frame [m].
        start : ClosedPosture, optional
            Where to start, which settles the limbs' branches. Default: home.

        Returns
        -------
        ClosedPosture

        Raises
        ------
        ClosureError
            A limb does not reach there.

        """
        start = start or self.home
        solution = reach(self._limbs, start.joints, rigid_displacement('pose', pose),
                         self.home.system.ranks)
        signs = solution.system.working_signs(start.system)
        return closed_posture(self._limbs, solution, start.working_mode * signs,
                              self.closure_tolerance)

    def check_assembly_mode(self, posture: ClosedPosture) -> None:
        """
        Raise an error unless a posture is in the home's assembly mode.

        Raises
        ------
        AssemblyModeError
            From home, its actuated joints lead to another posture.
        ClosureError, SingularityError
            There is no way from home.

        """
        check_same_mode(self._limbs, posture, self.posture(posture.actuated))

    def state(self, q: Any, *derivatives: Any, start: ClosedPosture | None = None) -> BodyState:
        """
        Return pose and reduced states of the platform, pole at its frame's origin.

        Parameters
        ----------
        q : array, shape (dof,) or (N, dof)
            Positions of the actuated joints [rad, m]; of many samples each starts from
            the one before.
        *derivatives : array, shape as q
            Their first to at most fourth time derivatives.
        start : ClosedPosture, optional
            As in :meth:`posture`.

        Returns
        -------
        BodyState
            In base axes.

        """
        if np.ndim(q) == 1:
            posture = self.posture(q, start)
            states, _ = self.rates(posture, *derivatives)
            return self._body_state(posture.pose, states)
        samples = []
        for sample in zip(np.asarray(q), *map(np.asarray, derivatives)):
            start = self.posture(sample[0], start)
            samples.append((start.pose, self.rates(start, *sample[1:])[0]))
        return self._body_state(np.array([pose for pose, _ in samples]),
                                list(np.stack([x for _, x in samples], axis=1)))

    def compile(self, outputs: Iterable[str] = ('pose', 'twist', 'accel'),    # noqa: A003
                backend: str = 'auto', axes: str = 'base', pole: str = 'tip',
                ) -> ParallelProgram:
        """
        Return the program for a stream of samples, as :meth:`SerialChain.compile` does.

        It keeps the last posture, from which the next one is found.

        Parameters
        ----------
        outputs : iterable of str
            As for a serial chain.
        backend : {'auto', 'python', 'numba'}
            What runs the traced steps from sample to sample; searches are NumPy's.
        axes, pole : {'base', 'tip'}
            Whose axes, and about which point, the six-vectors are.

        """
        return ParallelProgram(self, outputs, backend, axes, pole)

    def _body_state(self, pose: Array, states: Sequence[Array]) -> BodyState:
        return BodyState(pose, tuple(states), pose[..., :3, 3],
                         base_frame=self.base_frame, tip_frame=self.tip_frame)
