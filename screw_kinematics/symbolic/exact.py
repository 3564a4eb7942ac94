# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Chains whose geometry is exact: fractions, roots and symbols instead of floats.

Results in formulas then read ``x`` and not ``1.0*x``, and a cosine that is zero leaves
nothing behind. Needs the extra ``symbolic``.
"""
from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
import math
import sys
from typing import Any

import numpy as np

from ..chains.dh import CONVENTIONS, DHRow, place_rows
from ..chains.joint import Joint, Mimic
from ..chains.serial_chain import SerialChain
from ..errors import InvalidValueError, MissingExtraError, UnknownNameError
from ..screws.se3 import Array, rotation_about

try:
    import sympy
except ImportError as error:
    raise MissingExtraError('sympy', 'symbolic', 'exact geometry') from error

_ROUNDING = 4 * sys.float_info.epsilon
_PICOMETRE = 12


def sympy_array(x: Any) -> Array:
    """
    Return an object array of SymPy objects.

    Examples
    --------
    >>> sympy_array([1, 2])
    array([1, 2], dtype=object)

    """
    return np.asarray(each(sympy.sympify, np.array(x, dtype=object)))


def each(function: Callable[[Any], Any], x: Any) -> Any:
    """
    Return an object array (or a single object) of a function's value for each element.

    Examples
    --------
    >>> each(sympy.sqrt, [4, 2])
    array([2, sqrt(2)], dtype=object)

    """
    x = np.asarray(x)
    out = np.empty(x.shape, dtype=object)
    for index in np.ndindex(x.shape):
        out[index] = function(x[index])
    return out[()]


def exact_chain(chain: SerialChain) -> SerialChain:
    """
    Return a chain whose geometry is exact numbers or expressions, never floats.

    Lengths become the decimal numbers they were written as, to 1e-12 m; components of
    directions that are square roots of simple fractions are recognised as such.

    Parameters
    ----------
    chain : SerialChain
        Its geometry may be floats, SymPy expressions, or both.

    Returns
    -------
    SerialChain

    Examples
    --------
    >>> chain = exact_chain(SerialChain([Joint('q1', 'revolute', axis=(1, 0, 1))]))
    >>> chain.joints[0].axis
    array([sqrt(2)/2, 0, sqrt(2)/2], dtype=object)

    """
    def exact_joint(joint: Joint) -> Joint:
        mimic = joint.mimic
        if mimic is not None:
            mimic = Mimic(mimic.joint, exact_length(mimic.multiplier), exact_length(mimic.offset))
        return replace(joint, axis=each(_cosine, joint.axis), mimic=mimic,
                       point=each(exact_length, joint.point), pitch=exact_length(joint.pitch))

    T = chain.T_base_tool
    exact_T = np.concatenate([np.concatenate(
        [each(_cosine, T[:3, :3]), each(exact_length, T[:3, 3:])], axis=1),
        sympy_array([[0, 0, 0, 1]])])
    return SerialChain([exact_joint(joint) for joint in chain.joints], exact_T,
                       chain.base_frame, chain.tip_frame, chain.name)


@dataclass(frozen=True)
class DHJoint(DHRow):
    """
    A Denavit-Hartenberg row of numbers or SymPy expressions.

    Parameters
    ----------
    a, alpha, d, theta
        As in :class:`~screw_kinematics.chains.dh.DHRow`; floats are taken as the exact
        number they stand for, angles as the fraction of pi.
    kind : {'revolute', 'prismatic'}
        Whether the joint's coordinate adds to theta or to d.

    """

    a: Any = 0
    alpha: Any = 0
    d: Any = 0
    theta: Any = 0
    kind: str = 'revolute'

    def link(self) -> Array:
        """Return the displacement along and about x, shape (4, 4)."""
        return _displacement([1, 0, 0], self.alpha, self.a)

    def joint(self) -> Array:
        """Return the displacement along and about z at q = 0, shape (4, 4)."""
        return _displacement([0, 0, 1], self.theta, self.d)


def dh_chain(rows: Sequence[DHJoint], convention: str = 'standard',
             name: str = '') -> SerialChain:
    """
    Return an exact chain from Denavit-Hartenberg rows with symbolic parameters.

    Parameters
    ----------
    rows : sequence of DHJoint
        From base to tip; the joints are called ``q1``, ``q2``, ...
    convention : {'standard', 'modified'}
        ``Rz(theta + q) Tz(d) Tx(a) Rx(alpha)``, or Craig's
        ``Rx(alpha) Tx(a) Rz(theta + q) Tz(d)``.
    name : str
        Name of the robot.

    Returns
    -------
    SerialChain

    Raises
    ------
    UnknownNameError, InvalidValueError
        There is no such convention; a kind is neither revolute nor prismatic.

    Examples
    --------
    A planar arm with two links.

    >>> a, b = sympy.symbols('a b')
    >>> arm = dh_chain([DHJoint(a=a), DHJoint(a=b)])
    >>> arm.pose([sympy.pi / 2, 0])[:3, 3]
    array([0, a + b, 0], dtype=object)

    """
    if convention not in CONVENTIONS:
        raise UnknownNameError('DH convention', convention, CONVENTIONS)
    for i, row in enumerate(rows, start=1):
        if row.kind not in ('revolute', 'prismatic'):
            raise InvalidValueError(
                f"joint q{i}: kind must be 'revolute' or 'prismatic', got {row.kind!r}")
    frames, last = place_rows(list(rows), convention, sympy_array(np.eye(4, dtype=int)))
    joints = [Joint(f'q{i}', row.kind, axis=T[:3, 2], point=T[:3, 3])
              for i, (row, T) in enumerate(zip(rows, frames), start=1)]
    return SerialChain(joints, last, name=name)


def exact_length(x: Any) -> Any:
    """Return the decimal number a float was written as."""
    if isinstance(x, sympy.Basic):
        return x
    return sympy.Rational(repr(round(float(x), _PICOMETRE)))


def _cosine(x: Any) -> Any:
    """Return a float of a direction or rotation as a root of a simple fraction, if it is."""
    if isinstance(x, sympy.Basic):
        return x
    x = float(x)
    square = Fraction(x * x).limit_denominator(100)
    if abs(math.sqrt(square) - abs(x)) <= _ROUNDING:
        root = sympy.sqrt(sympy.Rational(square.numerator, square.denominator))
        return -root if x < 0 else root
    return sympy.Rational(repr(x))


def _angle(x: Any) -> Any:
    """Return a float as a fraction of pi, if it is one."""
    if isinstance(x, sympy.Basic):
        return x
    share = Fraction(x / math.pi).limit_denominator(180)
    if abs(float(share) * math.pi - x) <= _ROUNDING * max(1, abs(x)):
        return sympy.pi * sympy.Rational(share.numerator, share.denominator)
    return sympy.Rational(repr(float(x)))


def _displacement(axis: Sequence[int], angle: Any, distance: Any) -> Array:
    direction = sympy_array(axis)
    T = sympy_array(np.eye(4, dtype=int))
    T[:3, :3] = sympy_array(rotation_about(direction, sympy_array(_angle(angle))))
    T[:3, 3] = direction * exact_length(distance)
    return T
