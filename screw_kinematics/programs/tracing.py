# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
# flake8: noqa: A005
"""
Scalar expressions, and the straight-line program they amount to.

A :class:`Scalar` stands for a number that is not known yet. Arithmetic on it records a
graph: equal expressions are one node, constants are folded, zeros and ones vanish, and
signs travel outwards so that ``-x * y`` and ``x * y`` share their product. The functions
of this package run on object arrays of such scalars unchanged; what they computed can
then be written out as a flat list of operations, without loops and branches, in any
language.
"""
from __future__ import annotations

from collections.abc import Iterable
from numbers import Real
from typing import Any, Union

import numpy as np

from .checkpoint import checkpoint, NODES_BETWEEN
from .straight_line_program import Operation, StraightLineProgram
from ..screws.se3 import Array

SNAP = 1e-15
"""Constants this close to -1, 0 or 1 are these: rounding of cosines of right angles."""


class Graph:
    """
    The expressions traced so far, each once.

    Examples
    --------
    >>> x, y = Graph().inputs(2)
    >>> straight_line(2, [x * y - 1 * y * x, x * y, -x * y]).count()
    {'mul': 1, 'neg': 1}

    """

    def __init__(self) -> None:
        self.nodes: list[Operation] = []
        self._known: dict[object, int] = {}

    def inputs(self, n: int) -> Array:
        """Return an object array of n unknowns; they come before all expressions."""
        if self.nodes:
            raise RuntimeError('the inputs of a graph are made once, before its expressions')
        out = np.empty(n, dtype=object)
        for k in range(n):
            out[k] = self._node('input', k)
        return out

    def _node(self, kind: str, left: int | float, right: int | float | None = None,
              negative: bool = False) -> Scalar:
        # The value of index 2 and the constant 2.0 are equal and hash alike.
        key = kind, left, right, type(left), type(right)
        index = self._known.get(key)
        if index is None:
            index = self._known[key] = len(self.nodes)
            self.nodes.append(Operation(kind, left, right))
            if not index % NODES_BETWEEN:
                checkpoint()
        return Scalar(self, index, negative)

    def add(self, x: Scalar, y: Scalar) -> Scalar | float:
        """Return x + y."""
        if x.node == y.node:
            return self.scale(x, 2.0) if x.negative == y.negative else 0.0
        a, b = (x, y) if x.node < y.node else (y, x)
        # Both signs of a difference are one node: the earlier value comes first.
        kind = 'add' if a.negative == b.negative else 'sub'
        return self._node(kind, a.node, b.node, a.negative)

    def offset(self, x: Scalar, constant: float) -> Scalar | float:
        """Return x + constant."""
        inner = self.nodes[x.node]
        node, constant = x.node, -constant if x.negative else constant
        if inner.kind == 'add' and isinstance(inner.right, float):
            node, constant = int(inner.left), _snap(inner.right + constant)
        if constant == 0.0:
            return Scalar(self, node, x.negative)
        return self._node('add', node, constant, x.negative)

    def multiply(self, x: Scalar, y: Scalar) -> Scalar | float:
        """Return x * y."""
        a, b = x.node, y.node
        return self._node('mul', min(a, b), max(a, b), x.negative != y.negative)

    def scale(self, x: Scalar, constant: float) -> Scalar | float:
        """Return x * constant."""
        inner = self.nodes[x.node]
        node, negative = x.node, x.negative != (constant < 0)
        constant = abs(constant)
        if inner.kind == 'mul' and isinstance(inner.right, float):
            node, constant = int(inner.left), _snap(inner.right * constant)
        if constant == 0.0:
            return 0.0
        if constant == 1.0:
            return Scalar(self, node, negative)
        return self._node('mul', node, constant, negative)

    def divide(self, x: Scalar | float, y: Scalar) -> Scalar | float:
        """Return x / y."""
        if isinstance(x, float):
            return 0.0 if x == 0 else self._node('div', abs(x), y.node,
                                                 negative=y.negative != (x < 0))
        return self._node('div', x.node, y.node, x.negative != y.negative)

    def call(self, kind: str, x: Scalar) -> Scalar:
        """Return sin, cos or sqrt of x."""
        if kind == 'sqrt' and x.negative:
            x = self._node('neg', x.node)
        return self._node(kind, x.node, negative=kind == 'sin' and x.negative)


class Scalar:
    """A number not known yet: a node of a graph, or its negative."""

    __slots__ = ('graph', 'node', 'negative')

    def __init__(self, graph: Graph, node: int, negative: bool = False) -> None:
        self.graph = graph
        self.node = node
        self.negative = negative

    def __repr__(self) -> str:
        return f'{"-" if self.negative else ""}<value {self.node}>'

    def __bool__(self) -> bool:
        raise TypeError('a traced value is not known yet, so no decision can depend on it')

    def __neg__(self) -> Scalar:
        return Scalar(self.graph, self.node, not self.negative)

    def __pos__(self) -> Scalar:
        return self

    def __add__(self, other: Any) -> Any:
        if isinstance(other, Scalar):
            return self.graph.add(self, other)
        return self.graph.offset(self, _snap(other)) if isinstance(other, Real) \
            else NotImplemented

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        return self + -other if isinstance(other, (Scalar, Real)) else NotImplemented

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, Scalar):
            return self.graph.multiply(self, other)
        return self.graph.scale(self, _snap(other)) if isinstance(other, Real) \
            else NotImplemented

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        if isinstance(other, Scalar):
            return self.graph.divide(self, other)
        return self * (1.0 / float(other)) if isinstance(other, Real) else NotImplemented

    def __rtruediv__(self, other: Any) -> Any:
        return self.graph.divide(float(other), self) if isinstance(other, Real) \
            else NotImplemented

    def __pow__(self, exponent: Any) -> Any:
        if not isinstance(exponent, int) or exponent < 0:
            return NotImplemented
        power: Any = 1.0
        for _ in range(exponent):
            power = power * self
        return power

    def sin(self) -> Scalar:
        """Return the sine."""
        return self.graph.call('sin', self)

    def cos(self) -> Scalar:
        """Return the cosine."""
        return self.graph.call('cos', self)

    def sqrt(self) -> Scalar:
        """Return the square root."""
        return self.graph.call('sqrt', self)


def straight_line(n_inputs: int, outputs: Iterable[Any]) -> StraightLineProgram:
    """
    Return the program that computes the given expressions, and nothing else.

    Parameters
    ----------
    n_inputs : int
        Number of inputs of the graph, used or not.
    outputs : iterable of Scalar or float
        Expressions of one graph.

    Returns
    -------
    StraightLineProgram
        What leads to no output is left out.

    """
    outputs = list(outputs)
    operations: list[Operation] = []
    index_of: dict[int, int] = {k: k for k in range(n_inputs)}

    def emit(operation: Operation) -> int:
        operations.append(operation)
        if not len(operations) % NODES_BETWEEN:
            checkpoint()
        return n_inputs + len(operations) - 1

    def place(root: Scalar) -> int:
        """Emit the operations a value needs, depth first, and return its index."""
        nodes, pending = root.graph.nodes, [root.node]
        while pending:
            node = pending[-1]
            if node in index_of:
                pending.pop()
                continue
            missing = [n for n in nodes[node].operands if n not in index_of]
            if missing:
                pending.extend(reversed(missing))
                continue
            kind, left, right = nodes[node]
            index_of[node] = emit(Operation(
                kind, index_of[left] if isinstance(left, int) else left,
                index_of[right] if isinstance(right, int) else right))
            pending.pop()
        return index_of[root.node]

    values: list[Union[int, float]] = []
    negatives: dict[int, int] = {}
    for output in outputs:
        if not isinstance(output, Scalar):
            values.append(float(output))
            continue
        index = place(output)
        if output.negative:
            if index not in negatives:
                negatives[index] = emit(Operation('neg', index))
            index = negatives[index]
        values.append(index)
    return StraightLineProgram(n_inputs, tuple(operations), tuple(values))


def _snap(constant: Any) -> float:
    value = float(constant)
    nearest = round(value) if abs(value) < 2 else 0
    return float(nearest) if abs(value - nearest) <= SNAP else value
