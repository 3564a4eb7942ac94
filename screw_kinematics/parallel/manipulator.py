# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Parallel manipulators: a platform carried by several limbs.

Construction finds the home posture, in which it learns the structure: which screws depend on
each other, how many freedoms there are, and whether the actuators hold the platform.
"""
from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from .closed_posture import ClosedPosture, posture_of
from .continuation import check_same_mode, follow
from .limbs import Limbs
from .loop_closure import close_at_pose, close_loops
from .program import ParallelProgram
from .rates import joint_rates, platform_states
from .screw_system import SINGULAR
from ..chains.manipulator import Manipulator
from ..chains.serial_chain import SerialChain
from ..errors import InvalidValueError
from ..screws.body_state import BodyState
from ..screws.reference import check_axes, resolve_pole
from ..screws.rigid import checked_pose
from ..screws.se3 import Array, rotate, shift_pole
from ..screws.vectors import finite_array

__all__ = ['ParallelManipulator']


class ParallelManipulator(Manipulator):
    """
    A platform carried by limbs, some of whose joints are measured; immutable.

    States and Jacobians are those of home's assembly mode; of many samples each posture is found
    from the one before. :class:`ClosureError`, :class:`AssemblyModeError` and
    :class:`SingularityError` say why and where there is none. Postures of other branches have
    :meth:`rates`. Where actuators are redundant and their rates contradict each other, all is in
    the sense of least squares.

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

    Attributes
    ----------
    limbs : tuple of SerialChain
        Each an open chain from base to platform.
    joints : tuple of Joint
        Those of all limbs.
    passive_joint_names : tuple of str
        Of the joints that are not measured, limb by limb.
    mobility : int
        Number of freedoms of the platform and the actuated joints together.
    home : ClosedPosture
        Where the assembly mode is found.

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
        self.limbs = self._limbs.chains
        self.joints = tuple(joint for chain in self.limbs for joint in chain.joints)
        self.characteristic_length = self._limbs.length
        self.fixed_frames = {**self.limbs[0].fixed_frames, tip_frame: np.eye(4)}
        self.fixed_to_base = self.limbs[0].fixed_to_base
        self.joint_names = self._limbs.actuated
        self.passive_joint_names = self._limbs.passive
        self.dof = dof = len(self.joint_names)
        self.joint_kinds = self._limbs.joint_kinds[:dof]
        self.prismatic = ~self._limbs.turning[:dof]
        self.velocity_limits = self._limbs.velocity_limits[:dof]
        solution = close_loops(self._limbs, self._limbs.positions(home or {}))
        self.mobility = solution.system.mobility()
        if solution.system.direct_conditioning < SINGULAR:
            raise InvalidValueError(
                f'with the actuated joints {", ".join(self.joint_names)} locked the platform '
                f'can still move at home: {self.dof} of them for mobility {self.mobility}, or '
                'a singular home posture')
        if closure_tolerance is None:
            closure_tolerance = 1e-2 if self.dof > self.mobility else 1e-8
        self.closure_tolerance = closure_tolerance
        self.home = posture_of(self._limbs, solution, np.ones(self.dof, dtype=int),
                               self.closure_tolerance)

    def __repr__(self) -> str:
        return (f'ParallelManipulator({self.name or "unnamed"}: {len(self.limbs)} limbs, '
                f'{self.dof} actuated and {len(self.passive_joint_names)} passive joints, '
                f'{self.base_frame} -> {self.tip_frame})')

    def with_tool(self, T_tip_tool: Any,    # noqa: N803
                  tip_frame: str | None = None) -> ParallelManipulator:
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
        return follow(self._limbs, start or self.home, self._joint_vector('q', q),
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
            On the branches of ``start``.

        Raises
        ------
        ClosureError
            A limb does not reach there.
        ShapeError, InvalidValueError
            The pose is no rigid displacement within 1e-6.

        """
        start = start or self.home
        pose = checked_pose('pose', finite_array('pose', pose, (4, 4)))
        solution = close_at_pose(self._limbs, start.joints, pose, self.home.system.ranks)
        signs = solution.system.working_signs(start.system)
        return posture_of(self._limbs, solution, start.working_mode * signs,
                          self.closure_tolerance)

    def check_assembly_mode(self, posture: ClosedPosture) -> None:
        """
        Raise an error unless a posture is in the home's assembly mode.

        Parameters
        ----------
        posture : ClosedPosture
            However it was found.

        Raises
        ------
        AssemblyModeError
            From home, its actuated joints lead to another posture.
        ClosureError, SingularityError
            There is no way from home.

        """
        check_same_mode(self._limbs, posture, self.posture(posture.actuated))

    def state(self, q: Any, *derivatives: Any) -> BodyState:
        q, *rates = self._motion(q, derivatives)
        postures, pose = self._along(q)
        given = [d.reshape(-1, self.dof) for d in rates]
        found = [platform_states(self._limbs, posture, [d[k] for d in given])[0]
                 for k, posture in enumerate(postures)]
        states = [np.array([x[n] for x in found]).reshape(*q.shape[:-1], 6)
                  for n in range(len(rates))]
        return BodyState(pose, tuple(states), pose[..., :3, 3],
                         base_frame=self.base_frame, tip_frame=self.tip_frame)

    def jacobian(self, q: Any, pole: str | Array = 'tip', axes: str = 'base') -> Array:
        check_axes(axes)
        (q,) = self._motion(q, ())
        postures, poses = self._along(q)
        columns = np.array([posture.system.jacobian.T for posture in postures])
        columns = columns.reshape(*q.shape, 6)
        offset = resolve_pole(pole, poses)[1] - poses[..., :3, 3]
        columns = shift_pole(columns, offset[..., None, :])
        if axes == 'tip':
            columns = rotate(np.swapaxes(poses[..., None, :3, :3], -1, -2), columns)
        return np.swapaxes(columns, -1, -2)

    def rates(self, posture: ClosedPosture, *derivatives: Any) -> tuple[list[Array], list[Array]]:
        """
        Return the platform's states and the passive joints' rates.

        Parameters
        ----------
        posture : ClosedPosture
            Where the manipulator is.
        *derivatives : array, shape (dof,)
            First to at most fourth time derivatives of the actuated joints.

        Returns
        -------
        states : list of array, shape (6,)
            Reduced states of order 1, 2, ..., pole at the platform frame's origin, axes of
            the base.
        passive : list of array, shape (passive joints,)
            First, second, ... time derivatives.

        Raises
        ------
        ShapeError, InvalidValueError
            Derivatives of a wrong shape, or more than four.

        """
        self._check_motion(posture.actuated, derivatives)
        return platform_states(self._limbs, posture, [
            self._joint_vector(f'derivative {n} of q', d) for n, d in enumerate(derivatives, 1)])

    def inverse_rates(self, posture: ClosedPosture, *states: Any,
                      ) -> tuple[list[Array], list[Array]]:
        """
        Return the rates of actuated and passive joints for given platform states.

        In closed form by reciprocal screws; where the actuators are redundant, the ones of
        least squares.

        Parameters
        ----------
        posture : ClosedPosture
            Where the manipulator is.
        *states : array, shape (6,)
            Reduced states of order 1 to at most 4, pole at the platform frame's origin,
            axes of the base.

        Returns
        -------
        actuated, passive : list of array, shapes (dof,), (passive joints,)
            First, second, ... time derivatives.

        Raises
        ------
        SingularityError
            An actuator can move with the platform at rest.
        ShapeError, InvalidValueError
            States of a wrong shape, or more than four; or the limbs do not allow such a
            motion: the message names one that does not.

        """
        self._check_motion(np.zeros(6), states)
        return joint_rates(self._limbs, posture, [
            finite_array(f'state of order {n}', x, (6,)) for n, x in enumerate(states, 1)])

    def wrenches(self, posture: ClosedPosture) -> tuple[list[Array], list[Array]]:
        """
        Return the wrenches that each limb puts on the platform, as screws.

        Parameters
        ----------
        posture : ClosedPosture
            Where the manipulator is.

        Returns
        -------
        actuation : list of array, shape (n, 6)
            Per limb, ``(force; moment)`` about the platform frame's origin, base axes:
            what its locked actuators hold.
        constraint : list of array, shape (m, 6)
            Per limb, reciprocal to all its joints: what it holds without any actuator.

        """
        return posture.system.limb_wrenches()

    def points(self, posture: ClosedPosture) -> dict[str, Array]:
        """
        Return the points to draw each limb through, in base axes [m].

        Parameters
        ----------
        posture : ClosedPosture
            Where the manipulator is.

        Returns
        -------
        dict from limb name to array, shape (joints + 1, 3)
            A point on each joint's axis, then the platform frame's origin.

        """
        return dict(zip(self._limbs.names, self._limbs.points(posture.joints)))

    def skeleton(self, q: Any) -> tuple[Array, ...]:
        (q,) = self._motion(q, ())
        samples = [self._limbs.points(posture.joints) for posture in self._along(q)[0]]
        return tuple(np.array(limb).reshape(q.shape[:-1] + limb[0].shape)
                     for limb in zip(*samples))

    def compile(self, outputs: Iterable[str] = ('pose', 'twist', 'accel'),    # noqa: A003
                axes: str = 'base', pole: str = 'tip') -> ParallelProgram:
        return ParallelProgram(self, outputs, axes, pole)

    def _joint_vector(self, name: str, value: Any) -> Array:
        return finite_array(f'{name} of {self!r}', value, (self.dof,))

    def _along(self, q: Array) -> tuple[list[ClosedPosture], Array]:
        """Return the posture of each sample, found from the one before, and all their poses."""
        postures: list[ClosedPosture] = []
        for sample in q.reshape(-1, self.dof):
            postures.append(self.posture(sample, postures[-1] if postures else None))
        poses = np.array([posture.pose for posture in postures])
        return postures, poses.reshape(*q.shape[:-1], 4, 4)

    def _motion(self, q: Any, derivatives: tuple[Any, ...]) -> list[Array]:
        """Return positions and derivatives of the actuated joints, all of one shape."""
        names = ['q', *(f'derivative {n} of q' for n in range(1, len(derivatives) + 1))]
        motion = [finite_array(f'{name} of {self!r}', value, (..., self.dof))
                  for name, value in zip(names, (q, *derivatives))]
        self._check_motion(motion[0], tuple(motion[1:]))
        return [np.asarray(x) for x in np.broadcast_arrays(*motion)]
