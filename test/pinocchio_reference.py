# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Relative motion of two frames by Pinocchio, as an independent reference.

Nothing here uses the package under test. Pinocchio gives the spatial velocity and
acceleration of both frames in the world; the motion seen from the base frame follows by
composition, with Pinocchio's own cross product of motions.
"""
from importlib.metadata import distribution, PackageNotFoundError
from pathlib import Path

import numpy as np
import pytest

pin = pytest.importorskip('pinocchio')


def example_robot(name: str) -> Path:
    """Return the path of a URDF of example-robot-data, by the end of its path."""
    try:
        data = distribution('example-robot-data')
    except PackageNotFoundError:
        pytest.skip('example-robot-data is not installed')
    return next(Path(data.locate_file(f)) for f in data.files or ()
                if f.as_posix().endswith(f'/{name}.urdf'))


class Reference:
    """Two frames of a Pinocchio model, moved by named joints."""

    def __init__(self, model, base: str, tip: str, joint_names) -> None:
        self._model, self._data = model, model.createData()
        self._frames = [model.getFrameId(name) for name in (base, tip)]
        assert max(self._frames) < model.nframes
        self._joints = [model.joints[model.getJointId(name)] for name in joint_names]

    def motion(self, q, qd, qdd):
        """
        Return what the base frame sees of the tip: pose, twist, reduced, classical.

        The pole is the tip, the axes are those of the base; six-vectors angular first.
        """
        neutral = pin.neutral(self._model)
        v, a = np.zeros((2, self._model.nv))
        for joint, *values in zip(self._joints, q, qd, qdd):
            # Pinocchio holds the angle of a continuous joint as cosine and sine.
            turns = joint.nq == 2
            neutral[joint.idx_q:joint.idx_q + joint.nq] = (
                [np.cos(values[0]), np.sin(values[0])] if turns else values[0])
            v[joint.idx_v], a[joint.idx_v] = values[1:]
        pin.forwardKinematics(self._model, self._data, neutral, v, a)
        pin.updateFramePlacements(self._model, self._data)
        (T1, V1, A1), (T2, V2, A2) = (self._state(frame) for frame in self._frames)
        T = T1.actInv(T2)
        at_tip = pin.SE3(np.eye(3), T.translation)
        twist = at_tip.actInv(T1.actInv(V2 - V1))
        reduced = at_tip.actInv(T1.actInv(A2 - A1 - V1.cross(V2 - V1)))
        classical = angular_first(reduced)
        classical[3:] += np.cross(twist.angular, twist.linear)
        return T.homogeneous, angular_first(twist), angular_first(reduced), classical

    def _state(self, frame):
        world = pin.ReferenceFrame.WORLD
        return (self._data.oMf[frame],
                pin.getFrameVelocity(self._model, self._data, frame, world),
                pin.getFrameAcceleration(self._model, self._data, frame, world))


def angular_first(motion):
    """Return a Pinocchio motion in the order of this package."""
    return np.concatenate([motion.angular, motion.linear])
