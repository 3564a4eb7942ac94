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
from xml.etree.ElementTree import parse

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


def followers(path: Path) -> dict[str, tuple[str, float, float]]:
    """Return for each joint with a ``mimic`` its source, multiplier and offset."""
    tags = {joint.get('name'): joint.find('mimic') for joint in parse(path).iterfind('joint')}
    return {name: (tag.get('joint'), float(tag.get('multiplier', 1)), float(tag.get('offset', 0)))
            for name, tag in tags.items() if tag is not None}


class Reference:
    """
    Two frames of a Pinocchio model, moved by named joints and those that follow them.

    Followers are moved here, since not all versions of Pinocchio know of them.
    """

    def __init__(self, model, base: str, tip: str, joint_names, rules=None) -> None:
        self._model, self._data = model, model.createData()
        self._frames = [model.getFrameId(name) for name in (base, tip)]
        assert max(self._frames) < model.nframes
        moved = [(name, i, 1.0, 0.0) for i, name in enumerate(joint_names)]
        moved += [(name, joint_names.index(source), multiplier, offset)
                  for name, (source, multiplier, offset) in (rules or {}).items()
                  if source in joint_names and model.existJointName(name)]
        self._joints = [(model.joints[model.getJointId(name)], *rule) for name, *rule in moved]

    def motion(self, q, qd, qdd):
        """
        Return what the base frame sees of the tip: pose, twist, reduced, classical.

        The pole is the tip, the axes are those of the base; six-vectors angular first.
        """
        neutral = pin.neutral(self._model)
        v, a = np.zeros((2, self._model.nv))
        for joint, source, multiplier, offset in self._joints:
            value = multiplier * q[source] + offset
            # Pinocchio holds the angle of a continuous joint as cosine and sine.
            neutral[joint.idx_q:joint.idx_q + joint.nq] = (
                [np.cos(value), np.sin(value)] if joint.nq == 2 else value)
            v[joint.idx_v] = multiplier * qd[source]
            a[joint.idx_v] = multiplier * qdd[source]
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
