# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Where the joint axes and the tip of a chain are at given joint values.

References
----------
The paper, sections 2.1 (screws of joints) and 2.4.1 (Theorem 3).

"""
from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .joint import Joint
from ..screws.screw import prismatic_screw, unit_screw
from ..screws.se3 import Array, matvec, rotation_about

__all__ = ['Posture']


class Posture:
    """
    A posture of a chain, in base coordinates.

    Parameters
    ----------
    joints : sequence of Joint
        From base to tip.
    T_home : array, shape (4, 4)
        Pose of the tip at joint values 0 [m].
    values : array, shape (..., number of joints)
        Joint values [rad, m].

    Attributes
    ----------
    pose : array, shape (..., 4, 4)
        T_base_tool.
    axes, points : list of array, shape (..., 3)
        Present direction of each joint's axis and a point of it [m]; the point of a
        prismatic joint has no meaning.

    """

    def __init__(self, joints: Sequence[Joint], T_home: Array,    # noqa: N803
                 values: Array) -> None:
        # Integer identity and zero keep symbolic results free of factors 1.0 and terms 0.0.
        rotation: Array = np.eye(3, dtype=int)
        point: Array = np.zeros(3, dtype=int)
        home: Array = np.zeros(3, dtype=int)
        self._joints = joints
        self.axes: list[Array] = []
        self.points: list[Array] = []
        for i, joint in enumerate(joints):
            value = np.asarray(values[..., i])
            axis = matvec(rotation, joint.axis)
            if joint.kind == 'prismatic':
                point = point + value[..., None] * axis
            else:
                # The point travels from axis to axis, so no offset is rotated twice.
                point = point + matvec(rotation, joint.point - home)
                home = joint.point
            self.axes.append(axis)
            self.points.append(point)
            if joint.kind != 'prismatic':
                rotation = rotation @ rotation_about(joint.axis, value)
            if joint.kind == 'helical':
                point = point + np.asarray(joint.pitch * value)[..., None] * axis
        position = point + matvec(rotation, T_home[:3, 3] - home)
        orientation = rotation @ T_home[:3, :3]
        batch = np.shape(values)[:-1]
        upper = np.concatenate([
            np.broadcast_to(orientation, batch + (3, 3)),
            np.broadcast_to(position, batch + (3,))[..., None]], axis=-1)
        last = np.broadcast_to(np.array([[0, 0, 0, 1]]), batch + (1, 4))
        self.pose: Array = np.concatenate([upper, last], axis=-2)

    def screws(self, pole: Array) -> list[Array]:
        """
        Return the present unit screws of the joints in base axes.

        Parameters
        ----------
        pole : array, shape (..., 3)
            The point the moments refer to, in base coordinates [m].

        Returns
        -------
        list of array, shape (..., 6)
            One for each joint, from base to tip.

        """
        return [
            prismatic_screw(axis) if joint.kind == 'prismatic'
            else unit_screw(axis, point - pole, joint.pitch)
            for joint, axis, point in zip(self._joints, self.axes, self.points)]
