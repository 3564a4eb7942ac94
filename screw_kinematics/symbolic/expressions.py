# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Formulas instead of numbers: chains and states on SymPy expressions.

There is no second implementation. A chain whose geometry and joint values are SymPy
expressions goes through the same :mod:`~screw_kinematics.screws.states` as one of floats; this
module makes geometry exact, names the coordinates, and simplifies results. Needs the extra
``symbolic``.

References
----------
The paper, section 3 (its four Maple sheets) and section 4.

"""
from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import sympy
from sympy.simplify.fu import TR10i, TR5, TR6

from .exact import elementwise, exact_chain, NEAR, sympy_array
from ..chains.serial_chain import SerialChain
from ..screws.body_state import BodyState
from ..screws.se3 import Array

__all__ = ['joint_symbols', 'parameter', 'simplify', 'six_vector', 'symbolic_state']

_POWERS = 16     # of sines and cosines; a state of order 4 of six joints stays below


def six_vector(name: str) -> Array:
    """
    Return a six-vector of real symbols, angular part first.

    Parameters
    ----------
    name : str
        The components are called ``<name>_w1 ... <name>_w3, <name>_v1 ... <name>_v3``.

    Returns
    -------
    array, shape (6,)
        Angular part first.

    Examples
    --------
    >>> from screw_kinematics.screws.se3 import lie_product, klein_form
    >>> X, Y = six_vector('X'), six_vector('Y')
    >>> lie_product(X, Y)[0]
    X_w2*Y_w3 - X_w3*Y_w2
    >>> sympy.expand(klein_form(X, lie_product(X, Y)))
    0

    """
    names = [f'{name}_{part}{k}' for part in 'wv' for k in (1, 2, 3)]
    return sympy_array(sympy.symbols(names, real=True))


def parameter(name: str) -> Any:
    """
    Return the real symbol of a parameter, such as a length.

    Parameters
    ----------
    name : str
        What it is called.

    Returns
    -------
    symbol
        The same for the same name.

    Examples
    --------
    >>> parameter('a').is_real
    True

    """
    return sympy.Symbol(name, real=True)


def joint_symbols(count: int, order: int = 2) -> list[Array]:
    """
    Return symbols for joint positions and their derivatives.

    Parameters
    ----------
    count : int
        Number of joints.
    order : int
        Highest derivative.

    Returns
    -------
    list of ``order + 1`` arrays, shape (count,)
        ``q1 ...``, ``qd1 ...``, ``qdd1 ...`` and so on: the arguments of
        :meth:`.SerialChain.state`.

    Examples
    --------
    >>> joint_symbols(2, order=1)
    [array([q1, q2], dtype=object), array([qd1, qd2], dtype=object)]

    """
    return [sympy_array([sympy.Symbol(f'q{"d" * k}{i + 1}', real=True) for i in range(count)])
            for k in range(order + 1)]


def symbolic_state(chain: SerialChain, order: int = 2, simplified: bool = True,
                   tolerance: float = NEAR) -> BodyState:
    """
    Return the state of a chain in the symbols of :func:`joint_symbols`.

    Parameters
    ----------
    chain : SerialChain
        Made exact first.
    order : int
        Highest order, 1 (velocity) to 4 (jounce).
    simplified : bool
        See :func:`simplify`; the formulas of long arms simplify slowly and little.
    tolerance : float
        As of :func:`.exact.exact_chain`.

    Returns
    -------
    BodyState
        Of SymPy expressions; everything but its numbers works as usual.

    Examples
    --------
    >>> from screw_kinematics import Joint
    >>> crank = SerialChain([Joint('q1', 'revolute', axis=(0, 0, 1))],
    ...                     [[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    >>> symbolic_state(crank).classical(2)[3]
    -2*qd1**2*cos(q1) - 2*qdd1*sin(q1)

    """
    q, *rates = joint_symbols(chain.dof, order)
    found = exact_chain(chain, tolerance).state(q, *rates)
    pose, tip = sympy_array(found.pose), sympy_array(found.pole_in_base)
    reduced = [sympy_array(x) for x in found.reduced]
    if simplified:
        pose, tip = simplify(pose), simplify(tip)
        reduced = [simplify(x, rates) for x in reduced]
    return replace(found, pose=pose, pole_in_base=tip, reduced=tuple(reduced))


def simplify(x: Any, rates: Iterable[Any] = ()) -> Any:
    """
    Return expressions as sums over products of joint rates, with simple coefficients.

    Parameters
    ----------
    x : array or expression
        What to simplify, element by element.
    rates : iterable of symbols, or of arrays of symbols
        Joint rates and higher derivatives, in which the expressions are polynomials.

    Returns
    -------
    array or expression
        Equal to what was given.

    Examples
    --------
    >>> a, b, u = sympy.symbols('a b u')
    >>> simplify(u * (sympy.sin(a) * sympy.cos(b) + sympy.sin(b) * sympy.cos(a)), [u])
    u*sin(a + b)

    """
    symbols = [s for group in rates for s in np.ravel(group)]

    def one(expression: Any) -> Any:
        expression = sympy.expand(expression)
        present = [s for s in symbols if expression.has(s)]
        if not present:
            return _trigonometric(expression)
        terms = sympy.Poly(expression, *present).terms()
        return sum(_trigonometric(c) * sympy.prod([s ** n for s, n in zip(present, powers)])
                   for powers, c in terms)

    return elementwise(one, x)


def _trigonometric(expression: Any) -> Any:
    """Use cos^2 + sin^2 = 1, then gather products into sines and cosines of sums."""
    expression = sympy.expand(expression)
    reduced = [sympy.expand(rule(expression, max=_POWERS)) for rule in (TR5, TR6)]
    return TR10i(min([expression, *reduced], key=sympy.count_ops))
