# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Exact differentiation of rigid motions, to compare with; it knows no screws.

A pose is a 4 x 4 matrix of truncated Taylor series in time with 40 digits, a chain the
product of its joints' homogeneous matrices, and the kinematic state is read off by its
definition: derivatives of R R^T and of positions.
"""
from __future__ import annotations

from dataclasses import dataclass
from math import factorial
from typing import Any

import mpmath
import numpy as np

Array = np.ndarray
CONTEXT = mpmath.MPContext()
CONTEXT.dps = 40


class Taylor:
    """
    A truncated power series in time; results are as long as the shorter operand.

    In products with arrays the array comes first, so that NumPy goes element by element.
    """

    def __init__(self, coefficients: list[Any]) -> None:
        self.coefficients = list(coefficients)

    def _other(self, other: Any) -> list[Any]:
        if isinstance(other, Taylor):
            return other.coefficients
        return [other] + [0] * (len(self.coefficients) - 1)

    def __add__(self, other: Any) -> Taylor:
        return Taylor([a + b for a, b in zip(self.coefficients, self._other(other))])

    def __mul__(self, other: Any) -> Taylor:
        a, b = self.coefficients, self._other(other)
        return Taylor([sum(a[j] * b[k - j] for j in range(k + 1))
                       for k in range(min(len(a), len(b)))])

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self) -> Taylor:
        return self * -1

    def __sub__(self, other: Any) -> Taylor:
        return self + -1 * other

    def __rsub__(self, other: Any) -> Taylor:
        return -self + other

    def rate(self) -> Taylor:
        """Return the time derivative, one order shorter."""
        return Taylor([k * c for k, c in enumerate(self.coefficients)][1:])

    def derivative(self, n: int) -> Any:
        """Return the n-th derivative at time 0."""
        return factorial(n) * self.coefficients[n]


def sine_cosine(x: Taylor) -> tuple[Taylor, Taylor]:
    """Return sine and cosine, by s' = c x' and c' = -s x'."""
    s, c = [CONTEXT.sin(x.coefficients[0])], [CONTEXT.cos(x.coefficients[0])]
    rate = x.rate().coefficients
    for k in range(len(rate)):
        s.append(sum(c[j] * rate[k - j] for j in range(k + 1)) / (k + 1))
        c.append(-sum(s[j] * rate[k - j] for j in range(k + 1)) / (k + 1))
    return Taylor(s), Taylor(c)


def exact(x: Any) -> Array:
    """Return floats as 40-digit numbers."""
    return np.vectorize(CONTEXT.mpf, otypes=[object])(np.asarray(x, dtype=float))


def joint_matrix(joint: Any, value: Taylor) -> Array:
    """Return the homogeneous matrix of a joint: rotation about its axis, slide along it."""
    axis, point = exact(joint.axis), exact(joint.point)
    axis = axis / CONTEXT.sqrt(sum(axis * axis))
    zero = 0 * value
    s, c = (zero, zero + 1) if joint.kind == 'prismatic' else sine_cosine(value)
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=object)
    R = np.eye(3, dtype=int) + K * s + (K @ K) * (1 - c)
    slide = value if joint.kind == 'prismatic' else exact(joint.pitch)[()] * value
    T = np.full((4, 4), zero, dtype=object) + np.eye(4, dtype=int)
    T[:3, :3] = R
    T[:3, 3] = point - R @ point + axis * slide
    return T


def chain_pose(chain: Any, q: Array, *derivatives: Array) -> Array:
    """Return the tip's pose as Taylor series, from the chain's joints and home pose."""
    columns = [chain.joint_names.index(joint.source) for joint in chain.joints]
    T = np.eye(4, dtype=int)
    for joint, column in zip(chain.joints, columns):
        factor, offset = (1, 0) if joint.mimic is None else \
            (joint.mimic.multiplier, joint.mimic.offset)
        series = [CONTEXT.mpf(float(d[column])) * factor / factorial(k)
                  for k, d in enumerate((q, *derivatives))]
        T = T @ joint_matrix(joint, Taylor(series) + offset)
    return T @ exact(chain.T_base_tool)


def inverse(T: Array) -> Array:
    """Return the inverse of a pose."""
    out = T.copy()
    out[:3, :3] = T[:3, :3].T
    out[:3, 3] = -(T[:3, :3].T @ T[:3, 3])
    return out


@dataclass
class ExactMotion:
    """What a pose's Taylor series says, as floats; lists start at order 1."""

    pose: Array             # (4, 4)
    classical: list[Array]  # [w; v], [alpha; a], ... of the tip
    reduced: list[Array]    # derivatives of the twist at the space-fixed pole now at the tip
    body: list[Array]       # derivatives of the components of the twist in tip axes


def motion_of(T: Array) -> ExactMotion:
    """Return the derivatives of a moving frame's orientation and position."""
    R, p = T[:3, :3], T[:3, 3]
    rate = np.vectorize(Taylor.rate, otypes=[object])
    w, v = _vector(rate(R) @ R.T), rate(p)
    lever = np.array([x - x.coefficients[0] for x in p])
    at_fixed_pole = v - np.cross(w, lever)
    body_w, body_v = _vector(R.T @ rate(R)), R.T @ v
    order = len(v[0].coefficients)

    def derivatives(angular: Array, linear: Array) -> list[Array]:
        return [np.array([float(x.derivative(n)) for x in (*angular, *linear)])
                for n in range(order)]

    pose = np.array([[float(x.coefficients[0]) for x in row] for row in T])
    return ExactMotion(pose, derivatives(w, v), derivatives(w, at_fixed_pole),
                       derivatives(body_w, body_v))


def tip_motion(chain: Any, q: Array, *derivatives: Array) -> ExactMotion:
    """Return the exact motion of a chain's tip, to the order of the derivatives given."""
    return motion_of(chain_pose(chain, q, *derivatives))


def _vector(W: Array) -> Array:
    return np.array([W[2, 1], W[0, 2], W[1, 0]])
