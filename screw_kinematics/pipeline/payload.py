# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
What hangs on a force sensor, and the wrench by which it makes itself felt there.

Everything is about the origin of the sensor's frame and in its axes. Formulas take numbers or
arrays alike, component by component; all of them are linear in the ten inertial parameters.
"""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Union

import numpy as np

from ..screws.se3 import Array

Vector = Union[Sequence[Any], Array]
"""Components x, y, z: numbers, or arrays of many instants."""

INERTIAL = ('m', 'm c_x', 'm c_y', 'm c_z', 'I_xx', 'I_xy', 'I_xz', 'I_yy', 'I_yz', 'I_zz')
"""Names of the inertial parameters: mass, first moments, inertia about the sensor's origin."""

_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Payload:
    """
    A rigid body: its mass [kg], centre of mass [m], and inertia about that [kg m^2].

    Inertia is ixx, ixy, ixz, iyy, iyz, izz.

    Examples
    --------
    >>> Payload(2.0, (0.0, 0.0, 0.5)).parameters
    (2.0, 0.0, 0.0, 1.0, 0.5, 0.0, 0.0, 0.5, 0.0, 0.0)

    """

    mass: float = 0.0
    center: tuple[float, ...] = (0.0, 0.0, 0.0)
    inertia: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    @property
    def parameters(self) -> tuple[float, ...]:
        """Return the inertial parameters, as :data:`INERTIAL` names them."""
        m, c = self.mass, np.array(self.center)
        about = inertia_matrix(self.inertia) + m * (c @ c * np.eye(3) - np.outer(c, c))
        return (m, *(m * c).tolist(), *about[np.triu_indices(3)].tolist())

    @classmethod
    def of(cls, parameters: Sequence[float] | Array) -> Payload:
        """Return the body of some inertial parameters with a mass that is not zero."""
        m, h = parameters[0], np.array(parameters[1:4])
        c = h / m
        inertia = inertia_matrix(parameters[4:]) - m * (c @ c * np.eye(3) - np.outer(c, c))
        return cls(float(m), tuple(c.tolist()), tuple(inertia[np.triu_indices(3)].tolist()))


def is_inertia(six: Sequence[float]) -> bool:
    """
    Return whether six numbers are the inertia of a body.

    Its principal moments are not negative, and none is larger than the two others together.

    Examples
    --------
    >>> is_inertia((1, 0, 0, 1, 0, 2)), is_inertia((1, 0, 0, 1, 0, 2.1)), is_inertia([0] * 6)
    (True, False, True)

    """
    low, middle, high = np.linalg.eigvalsh(inertia_matrix(six)).tolist()
    slack = _TOLERANCE * abs(high)
    return bool(low >= -slack and high <= low + middle + slack)


def felt_wrench(parameters: Sequence[Any], force: Vector, omega: Vector, alpha: Vector,
                ) -> tuple[Any, ...]:
    """
    Return the wrench that a body exerts on the sensor by its weight and its inertia [N, N m].

    The parameters are as :data:`INERTIAL` names them; the force is the specific one at the
    sensor's origin: its acceleration less that of free fall [m/s^2].

    Examples
    --------
    >>> body = Payload(2.0, (0.0, 0.0, 0.1)).parameters
    >>> [round(x, 3) + 0.0 for x in felt_wrench(body, (9.81, 0, 0), (0, 0, 0), (0, 0, 0))]
    [-19.62, 0.0, 0.0, 0.0, -1.962, 0.0]

    """
    m, hx, hy, hz, ixx, ixy, ixz, iyy, iyz, izz = parameters
    h = hx, hy, hz
    swept = cross(omega, cross(omega, h))
    f = [m * a + b + c for a, b, c in zip(force, cross(alpha, h), swept)]

    def inertia(v: Vector) -> Vector:
        x, y, z = v
        return (ixx * x + ixy * y + ixz * z, ixy * x + iyy * y + iyz * z,
                ixz * x + iyz * y + izz * z)

    t = [a + b + c for a, b, c in zip(
        cross(h, force), inertia(alpha), cross(omega, inertia(omega)))]
    return tuple(-x for x in (*f, *t))


def cross(a: Vector, b: Vector) -> tuple[Any, Any, Any]:
    """Return the vector product, component by component."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def inertia_matrix(six: Sequence[float] | Array) -> Array:
    """Return the matrix of six numbers ixx, ixy, ixz, iyy, iyz, izz."""
    xx, xy, xz, yy, yz, zz = six
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=float)
