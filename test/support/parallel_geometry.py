# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The shipped parallel robots by elementary geometry, to compare with; it knows no screws.

The dimensions are those of the comments in the model files, not their numbers. A platform
moves along functions of time; the actuated joints follow in closed form, and all time
derivatives are those of 40-digit numbers.
"""
from dataclasses import dataclass
from functools import cache
from math import factorial

import numpy as np
from support.exact import CONTEXT, ExactMotion, motion_of, Taylor

ORDER = 4
acos, atan2, cos, sin, sqrt = (
    getattr(CONTEXT, name) for name in ('acos', 'atan2', 'cos', 'sin', 'sqrt'))


def polar(radius, degrees):
    """Return a point of a circle."""
    angle = CONTEXT.mpf(degrees) * CONTEXT.pi / 180
    return np.array([radius * cos(angle), radius * sin(angle), 0 * angle])


def rotation(roll, pitch, yaw):
    """Return the matrix of turns about the fixed axes x, y, z, in this order."""
    (a, b, c), (d, e, f) = [cos(x) for x in (roll, pitch, yaw)], [
        sin(x) for x in (roll, pitch, yaw)]
    return np.array([[c * b, c * e * d - f * a, c * e * a + f * d],
                     [f * b, f * e * d + c * a, f * e * a - c * d],
                     [-e, b * d, b * a]])


def stewart_6ups(R, p):
    """Return the lengths of the legs."""
    feet = [polar(0.5, a) for a in (10, 110, 130, 230, 250, 350)]
    heads = [polar(0.3, a) for a in (50, 70, 170, 190, 290, 310)]
    return [sqrt(sum((p + R @ head - foot) ** 2)) for foot, head in zip(feet, heads)]


def delta(R, p):
    """Return the angles of the arms below the horizontal, elbows outward."""
    arm, forearm = CONTEXT.mpf('0.3'), CONTEXT.mpf('0.7')
    angles = []
    for k in range(3):
        u = polar(1, 120 * k)
        out, side, up = u @ p - 0.15, u[0] * p[1] - u[1] * p[0], p[2]
        # arm * (out * cos - up * sin) = c, the elbow being one forearm from the wrist
        c = (out ** 2 + side ** 2 + up ** 2 + arm ** 2 - forearm ** 2) / 2
        angles.append(atan2(-up, out) - acos(c / (arm * sqrt(out ** 2 + up ** 2))))
    return angles


def planar_3rrr(R, p):
    """Return the angles of the first links from the x axis, elbows to the left."""
    first, second = CONTEXT.mpf('0.3'), CONTEXT.mpf('0.25')
    angles = []
    for degrees in (-150, -30, 90):
        x, y, _ = p + R @ polar(CONTEXT.mpf('0.15'), degrees) - polar(0.5, degrees)
        reach = sqrt(x ** 2 + y ** 2)
        angles.append(atan2(y, x) + acos(
            (first ** 2 + reach ** 2 - second ** 2) / (2 * first * reach)))
    return angles


# Inverse kinematics; home; amplitudes of x, y, z and roll, pitch, yaw.
ROBOTS = {
    'stewart_6ups': (stewart_6ups, ('0', '0', '0.6'), (.08, .07, .06, .2, .15, .3)),
    'delta': (delta, ('0', '0', sqrt(CONTEXT.mpf('0.2875')) * -1), (.1, .12, .05, 0, 0, 0)),
    'planar_3rrr': (planar_3rrr, ('0', '0', '0'), (.05, .04, 0, 0, 0, .3)),
}


@dataclass
class Moment:
    """A robot at one instant: its platform's motion and its actuated joints'."""

    platform: ExactMotion
    joints: np.ndarray      # positions, then derivatives of order 1 to 4


@cache
def moment(name, seed):
    """Return an instant of a motion, of random phases and frequencies."""
    inverse, home, amplitudes = ROBOTS[name]
    rng = np.random.default_rng(seed)
    phases, rates = rng.uniform(0, 2 * np.pi, 6), rng.uniform(0.5, 2, 6)

    def pose(t):
        x = [a * sin(w * t + phase) for a, w, phase in zip(amplitudes, rates, phases)]
        return rotation(*x[3:]), np.array([CONTEXT.mpf(h) for h in home]) + x[:3]

    def series(entry):
        return CONTEXT.taylor(entry, 0, ORDER)

    T = np.array([[Taylor([float(i == j)] + [0] * ORDER) for j in range(4)] for i in range(4)])
    for i in range(3):
        T[i, 3] = Taylor(series(lambda t: pose(t)[1][i]))
        for j in range(3):
            T[i, j] = Taylor(series(lambda t: pose(t)[0][i, j]))
    joints = [series(lambda t: inverse(*pose(t))[k]) for k in range(len(inverse(*pose(0))))]
    derivatives = [[float(factorial(n) * c[n]) for c in joints] for n in range(ORDER + 1)]
    return Moment(motion_of(T), np.array(derivatives))
