# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The algebra of traced scalars, against the same arithmetic on floats."""
import math

import numpy as np
import pytest

from screw_kinematics.programs.machine import machine
from screw_kinematics.programs.tracing import Graph, Scalar, straight_line


def run(line, values):
    return machine(line).evaluate(values)


def test_equal_expressions_are_one_operation():
    x, y = Graph().inputs(2)
    line = straight_line(2, [x * y, y * x, (-x) * (-y), x * y + y * x])
    assert line.count() == {'mul': 2}      # x * y, and twice that


@pytest.mark.parametrize('expression, value', [
    (lambda x: 0 * x, 0.0), (lambda x: x - x, 0.0), (lambda x: x ** 0, 1.0),
    (lambda x: 0 / x, 0.0), (lambda x: (x * 1e-16), 0.0)])
def test_constants_are_folded(expression, value):
    x, = Graph().inputs(1)
    assert expression(x) == value


@pytest.mark.parametrize('expression', [
    lambda x: x * 1, lambda x: x + 0, lambda x: x * (1 + 5e-16), lambda x: -(-x),
    lambda x: x + 2 - 2, lambda x: 2 * x * 0.5, lambda x: x / 1, lambda x: +x])
def test_neutral_elements_vanish(expression):
    x, = Graph().inputs(1)
    line = straight_line(1, [expression(x)])
    assert line.operations == () and line.outputs == (0,)


def test_differences_of_both_signs_are_one_operation():
    x, y = Graph().inputs(2)
    assert straight_line(2, [(x - y) * (y - x)]).count() == {'mul': 1, 'neg': 1, 'sub': 1}


def test_outputs_may_be_constants_inputs_and_repeated():
    x, y = Graph().inputs(2)
    line = straight_line(2, [1.5, y, x + y, x + y])
    assert run(line, [2.0, 3.0]) == (1.5, 3.0, 5.0, 5.0)


def test_only_what_the_outputs_need_is_emitted():
    x, y = Graph().inputs(2)
    unused = x.sin() * y
    assert isinstance(unused, Scalar)
    assert straight_line(2, [x + y]).count() == {'add': 1}


def test_nested_expressions_of_any_depth():
    x, y = Graph().inputs(2)
    value, expected = x, 0.7
    for _ in range(500):
        value, expected = y * (value + x).sin(), 0.9 * math.sin(expected + 0.7)
    assert run(straight_line(2, [value]), [0.7, 0.9])[0] == pytest.approx(expected, rel=1e-12)


def test_a_traced_value_takes_no_decisions():
    x, = Graph().inputs(1)
    with pytest.raises(TypeError, match='not known yet'):
        bool(x)


def test_inputs_come_first():
    graph = Graph()
    graph.inputs(1)
    with pytest.raises(RuntimeError, match='made once'):
        graph.inputs(1)


@pytest.mark.parametrize('foreign', ['text', None, 1j])
def test_foreign_operands_are_refused(foreign):
    x, = Graph().inputs(1)
    for operation in (lambda: x + foreign, lambda: foreign - x, lambda: x * foreign,
                      lambda: x / foreign, lambda: foreign / x, lambda: x ** foreign):
        with pytest.raises(TypeError):
            operation()


def _random_expression(rng, leaves, depth):
    """Return a function of the leaves, built at random from all operations."""
    if depth == 0:
        k = rng.integers(len(leaves) + 1)
        constant = float(rng.choice([0, 1, -1, 2, 0.5, -0.75]))
        return (lambda v: v[k]) if k < len(leaves) else (lambda v: constant)
    a = _random_expression(rng, leaves, depth - 1)
    b = _random_expression(rng, leaves, depth - 1)
    return [
        lambda v: a(v) + b(v), lambda v: a(v) - b(v), lambda v: a(v) * b(v),
        lambda v: -a(v), lambda v: a(v) / (b(v) * b(v) + 1.0),
        lambda v: _call('sin', a(v)), lambda v: _call('cos', a(v)),
        lambda v: _call('sqrt', b(v) * b(v) + 0.5),
    ][rng.integers(8)]


def _call(name, value):
    return getattr(value, name)() if isinstance(value, Scalar) else getattr(math, name)(value)


@pytest.mark.parametrize('seed', range(20))
def test_a_traced_expression_has_the_value_of_the_expression(seed):
    rng = np.random.default_rng(seed)
    values = rng.normal(size=4)
    expressions = [_random_expression(rng, values, depth=6) for _ in range(30)]
    inputs = Graph().inputs(4)
    line = straight_line(4, [f(inputs) for f in expressions])
    expected = [f(values) for f in expressions]
    np.testing.assert_allclose(run(line, values.tolist()), expected, rtol=1e-12, atol=1e-13)
