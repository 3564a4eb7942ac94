# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Chains whose geometry is exact: fractions, roots and symbols instead of floats.

Results in formulas then read ``x`` and not ``1.0*x``, and a cosine that is zero leaves
nothing behind. Descriptions often write pi / 2 with eleven digits or fewer; formulas of such
numbers would be many times as long, so numbers that close to a simple one are taken as that.
Needs the extra ``symbolic``.
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
from ..chains.joint import Joint
from ..chains.serial_chain import SerialChain
from ..errors import InvalidValueError, optional_module, UnknownNameError
from ..screws.rotations import rotation_about
from ..screws.se3 import Array

sympy = optional_module('sympy', 'symbolic', 'exact geometry')

__all__ = ['DHJoint', 'NEAR', 'dh_chain', 'elementwise', 'exact_chain', 'exact_decimal',
           'sympy_array']

NEAR = 1e-9
"""Angles [rad] and coefficients this close to a simple one are that one, unless told not to."""
_ROUNDING = 4 * sys.float_info.epsilon
_PICOMETRE, _MICROMETRE = 12, 6
_TWELFTHS = 12      # of pi: the multiples of 15 degrees


def sympy_array(x: Any) -> Array:
    """
    Return an object array of SymPy objects.

    Parameters
    ----------
    x : array_like
        Numbers, symbols, or text of them.

    Returns
    -------
    array of object, shape of x
        Of SymPy objects.

    Examples
    --------
    >>> sympy_array([1, 2])
    array([1, 2], dtype=object)

    """
    return np.asarray(elementwise(sympy.sympify, np.array(x, dtype=object)))


def elementwise(function: Callable[[Any], Any], x: Any) -> Any:
    """
    Return an object array (or a single object) of a function's value for each element.

    Parameters
    ----------
    function : callable
        Of one element.
    x : array_like
        What it is applied to.

    Returns
    -------
    array of object, shape of x
        What the function gives.

    Examples
    --------
    >>> elementwise(sympy.sqrt, [4, 2])
    array([2, sqrt(2)], dtype=object)

    """
    x = np.asarray(x)
    out = np.empty(x.shape, dtype=object)
    for index in np.ndindex(x.shape):
        out[index] = function(x[index])
    return out[()]


def exact_chain(chain: SerialChain, tolerance: float = NEAR) -> SerialChain:
    """
    Return a chain whose geometry is exact numbers or expressions, never floats.

    Directions within the tolerance of square roots of simple fractions, or of angles that are
    multiples of pi / 12, are these; lengths become the decimal numbers they were written as.

    Parameters
    ----------
    chain : SerialChain
        Its geometry may be floats, SymPy expressions, or both.
    tolerance : float
        What a component of a direction, or a length [m], may be off by; 0 for no more than
        rounding errors.

    Returns
    -------
    SerialChain
        With the same names.

    Examples
    --------
    >>> chain = exact_chain(SerialChain([Joint('q1', 'revolute', axis=(1, 0, 1))]))
    >>> chain.joints[0].axis
    array([sqrt(2)/2, 0, sqrt(2)/2], dtype=object)

    """
    def length(x: Any) -> Any:
        return exact_decimal(x, tolerance)

    def exact_joint(joint: Joint) -> Joint:
        mimic = joint.mimic
        if mimic is not None:
            mimic = replace(mimic, multiplier=length(mimic.multiplier),
                            offset=length(mimic.offset))
        return replace(joint, axis=_direction(joint.axis, tolerance), mimic=mimic,
                       point=elementwise(length, joint.point), pitch=length(joint.pitch))

    T = chain.T_base_tool
    exact_T = np.concatenate([np.concatenate(
        [*(_direction(T[:3, k], tolerance)[:, None] for k in range(3)),
         elementwise(length, T[:3, 3:])], axis=1),
        sympy_array([[0, 0, 0, 1]])])
    return SerialChain([exact_joint(joint) for joint in chain.joints], exact_T,
                       chain.base_frame, chain.tip_frame, chain.name)


@dataclass(frozen=True)
class DHJoint(DHRow):
    """
    A Denavit-Hartenberg row of numbers or SymPy expressions.

    Parameters
    ----------
    a, alpha, d, theta : float or expression
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
        return _displacement([1, 0, 0], self.alpha, self.a)

    def joint(self) -> Array:
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
        With joints q1, q2, ...

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


def exact_decimal(x: Any, tolerance: float = NEAR) -> Any:
    """
    Return the decimal number a float was written as.

    Parameters
    ----------
    x : float or expression
        The floats in an expression are replaced.
    tolerance : float
        Off by less than this from a number of six decimals, it is that number.

    Returns
    -------
    expression
        A rational number, or the expression without floats.

    Raises
    ------
    InvalidValueError
        This is neither a number nor an expression.

    Examples
    --------
    >>> exact_decimal(0.25), exact_decimal(0.2999999999959), exact_decimal(0.1234567891)
    (1/4, 3/10, 1234567891/10000000000)

    """
    if isinstance(x, sympy.Basic):
        return _without_floats(x, tolerance)
    try:
        x = float(x)
    except (TypeError, ValueError):
        raise InvalidValueError(f'{x!r} is neither a number nor an expression') from None
    short = round(x, _MICROMETRE)
    return sympy.Rational(repr(
        short if abs(x - short) <= tolerance else round(x, _PICOMETRE)))


def _without_floats(x: Any, tolerance: float) -> Any:
    """Return an expression whose coefficients are roots of fractions, or decimal numbers."""
    exact = {}
    for f in x.atoms(sympy.Float):
        root = _root(float(f), tolerance)
        exact[f] = exact_decimal(float(f), tolerance) if root is None else root
    return x.xreplace(exact)


def _root(x: float, tolerance: float) -> Any:
    """Return the root of a simple fraction that a float is within a tolerance, or None."""
    square = Fraction(x * x).limit_denominator(100)
    if abs(math.sqrt(square) - abs(x)) > max(tolerance, _ROUNDING):
        return None
    root = sympy.sqrt(sympy.Rational(square.numerator, square.denominator))
    return -root if x < 0 else root


def _turn(angle: float, tolerance: float) -> Any:
    """Return the multiple of pi / 12 that an angle is within a tolerance, or None."""
    twelfths = round(angle * _TWELFTHS / math.pi)
    if abs(angle - twelfths * math.pi / _TWELFTHS) > max(tolerance, _ROUNDING):
        return None
    return sympy.pi * sympy.Rational(twelfths, _TWELFTHS)


def _direction(vector: Array, tolerance: float) -> Array:
    """Return a unit vector by roots of fractions, or by two angles, or as it is."""
    if vector.dtype == object:
        return sympy_array([_without_floats(sympy.sympify(x), tolerance) for x in vector])
    x, y, z = vector.tolist()
    roots = [_root(c, tolerance) for c in (x, y, z)]
    if None not in roots and sum(root ** 2 for root in roots) == 1:
        return sympy_array(roots)
    level = math.hypot(x, y)
    azimuth = _turn(math.atan2(y, x), tolerance) if level > tolerance else sympy.Integer(0)
    height = _turn(math.atan2(z, level), tolerance)
    if azimuth is None or height is None:
        return sympy_array([sympy.Rational(repr(c)) for c in (x, y, z)])
    return sympy_array([sympy.cos(azimuth) * sympy.cos(height),
                        sympy.sin(azimuth) * sympy.cos(height), sympy.sin(height)])


def _angle(x: Any) -> Any:
    """Return a float as a fraction of pi, if it is one."""
    if isinstance(x, sympy.Basic):
        return x
    if not isinstance(x, (int, float)):
        raise InvalidValueError(f'{x!r} is neither a number nor an expression')
    share = Fraction(x / math.pi).limit_denominator(180)
    if abs(float(share) * math.pi - x) <= _ROUNDING * max(1, abs(x)):
        return sympy.pi * sympy.Rational(share.numerator, share.denominator)
    return sympy.Rational(repr(float(x)))


def _displacement(axis: Sequence[int], angle: Any, distance: Any) -> Array:
    direction = sympy_array(axis)
    T = sympy_array(np.eye(4, dtype=int))
    T[:3, :3] = sympy_array(rotation_about(direction, sympy_array(_angle(angle))))
    T[:3, 3] = direction * exact_decimal(distance, 0.0)
    return T
