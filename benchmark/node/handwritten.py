# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The kinematics of a Panda as it is commonly written for one robot: with small arrays."""
import numpy as np
from sensor_msgs.msg import JointState

from .robot import JOINTS

# a, alpha, d of the modified Denavit-Hartenberg convention
DH = [(0, 0, 0.333), (0, -np.pi / 2, 0), (0, np.pi / 2, 0.316), (0.0825, np.pi / 2, 0),
      (-0.0825, -np.pi / 2, 0.384), (0, np.pi / 2, 0), (0.088, np.pi / 2, 0)]
FLANGE = 0.107


def transform(a: float, alpha: float, d: float, theta: float) -> np.ndarray:
    """Return the pose of a link in the one before, shape (4, 4)."""
    return np.array([
        [np.cos(theta), -np.sin(theta), 0, a],
        [np.sin(theta) * np.cos(alpha), np.cos(theta) * np.cos(alpha),
         -np.sin(alpha), -d * np.sin(alpha)],
        [np.sin(theta) * np.sin(alpha), np.cos(theta) * np.sin(alpha),
         np.cos(alpha), d * np.cos(alpha)],
        [0, 0, 0, 1]])


def jacobian(q: np.ndarray) -> np.ndarray:
    """Return the geometric Jacobian at the flange, linear first, shape (6, 7)."""
    T = np.eye(4)
    axes, origins = [], []
    for (a, alpha, d), theta in zip(DH, q):
        T = T @ transform(a, alpha, d, theta)
        axes.append(T[:3, 2])
        origins.append(T[:3, 3])
    tip = T[:3, 3] + FLANGE * T[:3, 2]
    J = np.zeros((6, len(q)))
    for i, (axis, origin) in enumerate(zip(axes, origins)):
        J[:3, i] = np.cross(axis, tip - origin)
        J[3:, i] = axis
    return J


class HandwrittenKinematics:
    """Twist and acceleration; accelerations by differences of two twists."""

    def __init__(self) -> None:
        self._last: tuple[float, np.ndarray] | None = None

    def update(self, message: JointState) -> tuple[np.ndarray, np.ndarray]:
        """Return twist and acceleration, linear first."""
        index = [message.name.index(name) for name in JOINTS]
        q = np.array(message.position)[index]
        qd = np.array(message.velocity)[index]
        stamp = message.header.stamp.sec + message.header.stamp.nanosec * 1e-9
        twist = jacobian(q) @ qd
        accel = np.zeros(6)
        if self._last is not None:
            accel = (twist - self._last[1]) / (stamp - self._last[0])
        self._last = stamp, twist
        return twist, accel
