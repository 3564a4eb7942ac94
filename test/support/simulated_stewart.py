# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
A simulated Gough-Stewart platform; run as a program: the node with its exact rates.

The platform swings about a skew axis while it moves, in closed form, and with it the
lengths of the legs and their derivatives, by the chain rule.
"""
import sys

import numpy as np

HEADS, FEET = (
    radius * np.array([[np.cos(a), np.sin(a), 0] for a in np.radians(degrees)])
    for radius, degrees in ((0.3, (50, 70, 170, 190, 290, 310)),
                            (0.5, (10, 110, 130, 230, 250, 350))))
AXIS = np.array([2, -1, 2]) / 3
LEGS = [f'leg_{k}' for k in range(1, 7)]


def platform(t):
    """Return rotation, position, twist [w; v] and acceleration [alpha; a] at a time [s]."""
    angle, rate, slope = 0.2 * np.sin(3 * t), 0.6 * np.cos(3 * t), -1.8 * np.sin(3 * t)
    K = np.cross(np.eye(3), AXIS)
    R = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    w = np.array([2.0, 3.0, 2.5])
    size = np.array([0.08, 0.06, 0.05])
    p = [0, 0, 0.6] + size * np.sin(w * t)
    v, a = size * w * np.cos(w * t), -size * w * w * np.sin(w * t)
    return R, p, np.concatenate([rate * AXIS, v]), np.concatenate([slope * AXIS, a])


def legs(t):
    """Return the legs' lengths, rates and accelerations, shape (3, 6)."""
    R, p, twist, accel = platform(t)
    arms = HEADS @ R.T
    d = p + arms - FEET
    around = np.cross(twist[:3], arms)
    v = twist[3:] + around
    a = accel[3:] + np.cross(accel[:3], arms) + np.cross(twist[:3], around)
    length = np.linalg.norm(d, axis=1)
    rate = np.sum(d * v, axis=1) / length
    return np.array([length, rate, (np.sum(v * v + d * a, axis=1) - rate**2) / length])


def main():
    """Run the node; its estimator 'kalman' gives the exact rates of this motion."""
    from screw_kinematics.motion import ESTIMATORS, JointMotion
    from screw_kinematics.node.main import main as node

    class ExactRates(ESTIMATORS['kalman']):
        """Give the rates at the stamp, with the position that was measured."""

        def step(self, stamp_ns, position, velocity=None):
            _, rate, slope = legs(stamp_ns * 1e-9)
            motion = JointMotion(0.0, [*position, *rate.tolist(), *slope.tolist(), *6 * [0.0]])
            motion.stamp_ns = stamp_ns
            return motion

    ESTIMATORS['kalman'] = ExactRates
    return node()


if __name__ == '__main__':
    sys.exit(main())
