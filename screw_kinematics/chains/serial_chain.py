# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Open chains of screws: pose, present screws, and kinematic states of the tip."""
from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from .coupling import MimicCoupling
from .joint import Joint
from .manipulator import Manipulator
from .posture import Posture
from .program import trace_chain
from ..errors import InvalidValueError
from ..programs.program import Program
from ..programs.quantities import checked_outputs, find_quantity, order_of
from ..screws.body_state import BodyState
from ..screws.reference import check_axes, resolve_pole
from ..screws.rigid import rigid_displacement
from ..screws.se3 import Array, dot, inverse, rotate
from ..screws.states import chain_states, link_states

__all__ = ['SerialChain']


class SerialChain(Manipulator):
    """
    An open chain of joints from a base frame to a tip frame; immutable.

    Parameters
    ----------
    joints : iterable of Joint
        From base to tip; axes and points in the base frame at q = 0.
    T_base_tool : array, shape (4, 4)
        Pose of the tip frame in the base frame at q = 0 [m].
    base_frame, tip_frame : str
        Frame names.
    name : str
        Name of the robot, for messages.
    warnings : iterable of str
        What its description has that the chain has not.
    fixed_frames : mapping of str to array, shape (4, 4), optional
        Poses in the tip frame of other frames that are fixed to it [m].
    fixed_to_base : mapping of str to array, shape (4, 4), optional
        Poses in the base frame of other frames that are fixed to it [m].

    Raises
    ------
    ShapeError, InvalidValueError
        The pose is no rigid displacement, or joint names are not unique.

    Examples
    --------
    >>> arm = SerialChain([Joint('q1', 'revolute', axis=(0, 0, 1))],
    ...                   [[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    >>> arm.state([0.0], [1.0]).velocity
    array([0., 0., 1., 0., 2., 0.])

    """

    def __init__(self, joints: Iterable[Joint], T_base_tool: Any = None,    # noqa: N803
                 base_frame: str = 'base', tip_frame: str = 'tool', name: str = '',
                 warnings: Iterable[str] = (),
                 fixed_frames: Mapping[str, Any] | None = None,
                 fixed_to_base: Mapping[str, Any] | None = None) -> None:
        self.joints = tuple(joints)
        for joint in self.joints:
            if not isinstance(joint, Joint):
                raise InvalidValueError(f'a chain is made of Joint objects, got {joint!r}')
        self.base_frame = base_frame
        self.tip_frame = tip_frame
        self.name = name
        self.warnings = tuple(warnings)
        self.T_base_tool = rigid_displacement('T_base_tool', T_base_tool)
        self.fixed_frames = _with_itself(tip_frame, fixed_frames)
        self.fixed_to_base = _with_itself(base_frame, fixed_to_base)
        self._coupling = coupling = MimicCoupling(self.joints, repr(self))
        # Mimic joints are folded in.
        self.joint_names, self.dof = coupling.joint_names, coupling.dof
        self.joint_kinds, self.prismatic = coupling.joint_kinds, coupling.prismatic
        self.velocity_limits = coupling.velocity_limits

    def __repr__(self) -> str:
        return (f'SerialChain({self.name or "unnamed"}: {len(self.joints)} joints, '
                f'{self.base_frame} -> {self.tip_frame})')

    def with_tool(self, T_tip_tool: Any,    # noqa: N803
                  tip_frame: str | None = None) -> SerialChain:
        tool = rigid_displacement('T_tip_tool', T_tip_tool)
        return SerialChain(
            self.joints, self.T_base_tool @ tool,
            self.base_frame, self.tip_frame if tip_frame is None else tip_frame, self.name,
            self.warnings, {frame: inverse(tool) @ pose
                            for frame, pose in self.fixed_frames.items()}, self.fixed_to_base)

    def joint_values(self, q: Any, order: int = 0) -> Array:
        """
        Return the values of all joints of the chain from those of the measured ones.

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions (order 0) or derivatives (order > 0) of the measured joints.
        order : int
            The offsets of mimic joints count only for positions.

        Returns
        -------
        array, shape (..., number of joints)
            From base to tip.

        Raises
        ------
        ShapeError, InvalidValueError
            Joint values of a wrong shape, or none of numbers or symbols.

        """
        return self._coupling.values(q, order)

    def pose(self, q: Any) -> Array:
        return self.posture(q).pose

    def posture(self, q: Any) -> Posture:
        """
        Return where the joint axes and the tip are at the joint positions q.

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions of the measured joints [rad, m].

        Returns
        -------
        Posture
            Axes, points and tip in base coordinates.

        """
        return Posture(self.joints, self.T_base_tool, self.joint_values(q))

    def skeleton(self, q: Any) -> tuple[Array, ...]:
        """
        Return points to draw the links through, in base axes [m].

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions of the measured joints [rad, m].

        Returns
        -------
        tuple of one array, shape (..., number of joints + 2, 3)
            The base frame's origin; on each joint's axis the point nearest to the point
            before; the tip. Of a prismatic joint: the point before.

        Examples
        --------
        >>> elbow = SerialChain([Joint('q1', 'revolute', (0, 0, 1), (1, 0, 0))],
        ...                     [[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
        >>> elbow.skeleton([np.pi / 2])[0].round(6).tolist()
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]

        """
        posture = self.posture(q)
        tip = posture.pose[..., :3, 3]
        line = [np.zeros_like(tip)]
        for joint, axis, point in zip(self.joints, posture.axes, posture.points):
            before = line[-1]
            along = dot(axis, before - point)[..., None] * axis
            line.append(before if joint.kind == 'prismatic'
                        else np.broadcast_to(point + along, tip.shape))
        return (np.stack([*line, tip], axis=-2),)

    def screws(self, q: Any, pole: str | Array = 'tip') -> Array:
        """
        Return the present unit screws of the joints in base axes.

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions of the measured joints [rad, m].
        pole : 'tip', 'base' or array, shape (..., 3)
            The point the moments refer to; an array is in base coordinates [m].

        Returns
        -------
        array, shape (..., number of joints, 6)
            From base to tip.

        """
        posture = self.posture(q)
        screws = posture.screws(resolve_pole(pole, posture.pose)[1])
        if not screws:
            return np.zeros(posture.pose.shape[:-2] + (0, 6))
        shape = posture.pose.shape[:-2] + (6,)
        return np.stack([np.broadcast_to(screw, shape) for screw in screws], axis=-2)

    def jacobian(self, q: Any, pole: str | Array = 'tip', axes: str = 'base') -> Array:
        check_axes(axes)
        posture = self.posture(q)
        columns = self._coupling.columns(posture.screws(resolve_pole(pole, posture.pose)[1]))
        if not columns:
            return np.zeros(posture.pose.shape[:-2] + (6, 0))
        if axes == 'tip':
            back = np.swapaxes(posture.pose[..., :3, :3], -1, -2)
            columns = [rotate(back, column) for column in columns]
        shape = posture.pose.shape[:-2] + (6,)
        return np.stack([np.broadcast_to(column, shape) for column in columns], axis=-1)

    def state(self, q: Any, *derivatives: Any) -> BodyState:
        posture, rates = self._moving(q, derivatives)
        tip = posture.pose[..., :3, 3]
        reduced = chain_states(posture.screws(tip), rates)
        return BodyState(posture.pose, tuple(reduced), tip,
                         base_frame=self.base_frame, tip_frame=self.tip_frame)

    def link_states(self, q: Any, *derivatives: Any, pole: str | Array = 'tip') -> Array:
        """
        Return the reduced states of every link: the partial sums of Theorems 3 and 4.

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions of the measured joints [rad, m].
        *derivatives : array, shape (..., dof)
            Their first to at most fourth time derivatives.
        pole : 'tip', 'base' or array, shape (..., 3)
            The point that all states refer to; an array is in base coordinates [m].

        Returns
        -------
        array, shape (number of joints, number of derivatives, ..., 6)
            ``[i, n - 1]`` is the state of order n of the link behind joint i, axes of the
            base; the last link carries the tip.

        Raises
        ------
        ShapeError, InvalidValueError, UnknownNameError
            Joint values of a wrong shape, more than four derivatives, or no such pole.

        References
        ----------
        The paper, Theorems 3 and 4.

        """
        posture, rates = self._moving(q, derivatives)
        shape = (*np.broadcast_shapes(posture.pose.shape[:-2], *(r.shape[:-1] for r in rates)), 6)
        links = link_states(posture.screws(resolve_pole(pole, posture.pose)[1]), rates)
        if not links or not rates:
            return np.zeros((len(links), len(rates), *shape))
        return np.array([[np.broadcast_to(x, shape) for x in states] for states in links])

    def _moving(self, q: Any, derivatives: tuple[Any, ...]) -> tuple[Posture, list[Array]]:
        """Return the posture, and the derivatives of all joints."""
        values = self.joint_values(q)
        rates = [self.joint_values(d, n) for n, d in enumerate(derivatives, start=1)]
        self._check_motion(values, derivatives)
        return Posture(self.joints, self.T_base_tool, values), rates

    def compile(    # noqa: A003
            self, outputs: Iterable[str] = ('pose', 'twist', 'accel'),
            axes: str = 'base', pole: str = 'tip') -> Program:
        outputs = checked_outputs(outputs, axes, pole)
        sizes = {name: find_quantity(name).size(self.dof, len(self.joints)) for name in outputs}
        return Program(trace_chain(self, outputs, axes, pole), sizes, self.joint_names,
                       order_of(outputs), axes, pole, self.base_frame, self.tip_frame)


def _with_itself(frame: str, others: Mapping[str, Any] | None) -> dict[str, Array]:
    """Return poses in a frame of others that are fixed to it, after checking, and of itself."""
    return {**{other: rigid_displacement(f'pose of {other!r}', pose)
               for other, pose in (others or {}).items()}, frame: np.eye(4)}
