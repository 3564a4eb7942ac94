# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Open chains of screws: pose, present screws, and kinematic states of the tip."""
from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TYPE_CHECKING

import numpy as np

from .body_state import BodyState
from .errors import InvalidValueError, ShapeError, UnknownNameError
from .joint import Joint
from .screws import prismatic_screw, unit_screw
from .se3 import Array, matvec, rotation_about
from .states import chain_states

if TYPE_CHECKING:
    from .program import Program

MAX_ORDER = 4


class SerialChain:
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
                 base_frame: str = 'base', tip_frame: str = 'tool', name: str = '') -> None:
        self.joints = tuple(joints)
        self.base_frame = base_frame
        self.tip_frame = tip_frame
        self.name = name
        self.T_base_tool = _rigid_displacement(
            np.eye(4) if T_base_tool is None else T_base_tool)
        names = [joint.name for joint in self.joints]
        if len(set(names)) != len(names):
            twice = next(n for n in names if names.count(n) > 1)
            raise InvalidValueError(f'joint {twice!r} occurs more than once in the chain')
        following = {joint.name for joint in self.joints if joint.mimic is not None}
        for joint in self.joints:
            if joint.mimic is not None and joint.source in following:
                raise InvalidValueError(
                    f'joint {joint.name!r} follows {joint.source!r}, which follows another '
                    'joint itself; a followed joint must be a measured one')
        self.joint_names = tuple(dict.fromkeys(joint.source for joint in self.joints))
        self._columns = tuple(self.joint_names.index(j.source) for j in self.joints)

    def __repr__(self) -> str:
        return (f'SerialChain({self.name or "unnamed"}: {len(self.joints)} joints, '
                f'{self.base_frame} -> {self.tip_frame})')

    @property
    def dof(self) -> int:
        """Return the number of measured joints."""
        return len(self.joint_names)

    def with_tool(self, T_tip_tool: Any,    # noqa: N803
                  tip_frame: str | None = None) -> SerialChain:
        """
        Return the chain with a tool mounted on its tip.

        Parameters
        ----------
        T_tip_tool : array, shape (4, 4)
            Pose of the tool in the present tip frame [m].
        tip_frame : str, optional
            Name of the new tip frame.

        """
        return SerialChain(
            self.joints, self.T_base_tool @ _rigid_displacement(T_tip_tool),
            self.base_frame, self.tip_frame if tip_frame is None else tip_frame, self.name)

    def joint_values(self, q: Any, order: int = 0) -> Array:
        """
        Return the values of all joints of the chain from those of the measured ones.

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions (order 0) or derivatives (order > 0) of the measured joints.
        order : int
            The mimic offset counts only for positions.

        Returns
        -------
        array, shape (..., number of joints)

        """
        q = np.asarray(q)
        if q.shape[-1:] != (self.dof,):
            what = 'q' if order == 0 else f'derivative {order} of q'
            raise ShapeError(f'{what} of {self!r}', f'(..., {self.dof})', q.shape)
        values = q[..., list(self._columns)]
        if all(joint.mimic is None for joint in self.joints):
            return values
        mimics = [joint.mimic for joint in self.joints]
        values = values * np.array([1 if m is None else m.multiplier for m in mimics])
        if order == 0:
            values = values + np.array([0 if m is None else m.offset for m in mimics])
        return values

    def pose(self, q: Any) -> Array:
        """
        Return T_base_tool at the joint positions q.

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions of the measured joints [rad, m].

        Returns
        -------
        array, shape (..., 4, 4)

        """
        return self._kinematics(q)[0]

    def screws(self, q: Any, pole: str = 'tip') -> Array:
        """
        Return the present unit screws of the joints in base axes.

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions of the measured joints [rad, m].
        pole : {'tip', 'base'}
            The point the moments refer to.

        Returns
        -------
        array, shape (..., number of joints, 6)

        """
        pose, axes, points = self._kinematics(q)
        screws = self._screws(axes, points, _pole_point(pose, pole))
        shape = pose.shape[:-2] + (6,)
        return np.stack([np.broadcast_to(screw, shape) for screw in screws], axis=-2) \
            if screws else np.zeros(pose.shape[:-2] + (0, 6))

    def state(self, q: Any, *derivatives: Any) -> BodyState:
        """
        Return pose and reduced states of the tip, pole at the tip, axes of the base.

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions of the measured joints [rad, m].
        *derivatives : array, shape (..., dof)
            Their first to at most fourth time derivatives.

        Returns
        -------
        BodyState

        References
        ----------
        The paper, sections 3.1 and 3.2.

        """
        if len(derivatives) > MAX_ORDER:
            raise InvalidValueError(
                f'derivatives up to order {MAX_ORDER} are supported, got {len(derivatives)}')
        pose, axes, points = self._kinematics(q)
        tip = pose[..., :3, 3]
        rates = [self.joint_values(d, n) for n, d in enumerate(derivatives, start=1)]
        reduced = chain_states(self._screws(axes, points, tip), rates)
        return BodyState(pose, tuple(reduced), tip,
                         base_frame=self.base_frame, tip_frame=self.tip_frame)

    def compile(    # noqa: A003
            self, outputs: Iterable[str] = ('pose', 'twist', 'accel'),
            backend: str = 'auto', axes: str = 'base', pole: str = 'tip') -> Program:
        """
        Return a straight-line program of this chain, which is much faster than the chain.

        Parameters
        ----------
        outputs : iterable of str
            Any of 'pose' (position, then rotation by rows), 'twist', 'accel', 'jerk',
            'snap' (classical), 'reduced_accel', 'reduced_jerk', 'reduced_snap' and
            'jacobian' (6 x dof by rows).
        backend : {'auto', 'python', 'numba'}
            'auto' is 'numba' where Numba is installed.
        axes, pole : {'base', 'tip'}
            Whose axes all but the pose are in, and the point they refer to.

        Raises
        ------
        UnknownNameError, InvalidValueError
            An argument is none of the allowed ones.

        """
        from .compile import compile_chain
        return compile_chain(self, outputs, backend, axes, pole)

    def _kinematics(self, q: Any) -> tuple[Array, list[Array], list[Array]]:
        """Return pose, and each joint's present axis direction and point on it."""
        values = self.joint_values(q)
        # Integer identity and zero keep symbolic results free of factors 1.0 and terms 0.0.
        rotation: Array = np.eye(3, dtype=int)
        point: Array = np.zeros(3, dtype=int)
        home: Array = np.zeros(3, dtype=int)
        axes, points = [], []
        for i, joint in enumerate(self.joints):
            value = np.asarray(values[..., i])
            axis = matvec(rotation, joint.axis)
            if joint.kind == 'prismatic':
                point = point + value[..., None] * axis
            else:
                # The point travels from axis to axis, so no offset is rotated twice.
                point = point + matvec(rotation, joint.point - home)
                home = joint.point
            axes.append(axis)
            points.append(point)
            if joint.kind != 'prismatic':
                rotation = rotation @ rotation_about(joint.axis, value)
            if joint.kind == 'helical':
                point = point + np.asarray(joint.pitch * value)[..., None] * axis
        tool = self.T_base_tool
        position = point + matvec(rotation, tool[:3, 3] - home)
        orientation = rotation @ tool[:3, :3]
        batch = np.shape(values)[:-1]
        upper = np.concatenate([
            np.broadcast_to(orientation, batch + (3, 3)),
            np.broadcast_to(position, batch + (3,))[..., None]], axis=-1)
        last = np.broadcast_to(np.array([[0, 0, 0, 1]]), batch + (1, 4))
        return np.concatenate([upper, last], axis=-2), axes, points

    def _screws(self, axes: list[Array], points: list[Array], pole: Array) -> list[Array]:
        return [
            prismatic_screw(axis) if joint.kind == 'prismatic'
            else unit_screw(axis, point - pole, joint.pitch)
            for joint, axis, point in zip(self.joints, axes, points)]


def _pole_point(pose: Array, pole: str) -> Array:
    if pole not in ('tip', 'base'):
        raise UnknownNameError('pole', pole, ('tip', 'base'))
    tip = pose[..., :3, 3]
    return tip if pole == 'tip' else 0 * tip


def _rigid_displacement(T: Any) -> Array:    # noqa: N803
    """Return a read-only copy, after checking that it is a rigid displacement."""
    T = np.array(T)
    if T.shape != (4, 4):
        raise ShapeError('T_base_tool', '(4, 4)', T.shape)
    if T.dtype != object:
        T = T.astype(float)
        R = T[:3, :3]
        rigid = (np.allclose(R.T @ R, np.eye(3), atol=1e-9) and np.linalg.det(R) > 0
                 and np.array_equal(T[3], [0, 0, 0, 1]) and np.all(np.isfinite(T)))
        if not rigid:
            raise InvalidValueError(
                'T_base_tool is no rigid displacement: the upper left 3x3 block must be a '
                f'rotation and the last row (0, 0, 0, 1), got {T.tolist()}')
    T.setflags(write=False)
    return T
