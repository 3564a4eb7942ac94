# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The interpreter of straight-line programs: the same bits however it runs; no other memory."""
from array import array
import math
import random

import numpy as np
import pytest

from screw_kinematics.core import interpreted, interpreter
from screw_kinematics.programs import layout
from screw_kinematics.programs.machine import machine, TextMachine
from screw_kinematics.programs.straight_line_program import Operation, StraightLineProgram

TEXT = interpreted('interpreter')
SPECIAL = 0.0, -0.0, 1.0, -1.0, 1e-300, 1e300, math.inf, -math.inf, math.nan, 1e5, 1e7, -3e9
BINARY = 'add', 'sub', 'mul', 'mul', 'div'
UNARY = 'neg', 'sin', 'cos', 'sqrt'


def some_program(seed, length=300):
    """Return a program of all kinds of operations, with constants and inputs among the outputs."""
    rng = random.Random(seed)

    def operand(k):
        return rng.choice([rng.randrange(6 + k), rng.randrange(6 + k), rng.uniform(-2, 2),
                           rng.choice(SPECIAL[:6])])

    operations = []
    for k in range(length):
        if rng.random() < 0.7:
            # Tracing folds what is made of constants only, and divides by none.
            pair = [operand(k), rng.randrange(6 + k)]
            kind = rng.choice(BINARY)
            if kind != 'div':
                rng.shuffle(pair)
            operations.append(Operation(kind, *pair))
        else:
            operations.append(Operation(rng.choice(UNARY), rng.randrange(6 + k)))
    outputs = [rng.randrange(6 + length) for _ in range(40)]
    return StraightLineProgram(6, tuple(operations), (*outputs, 2.5, -0.0, 0, 3))


PLAIN = {'add': np.add, 'sub': np.subtract, 'mul': np.multiply, 'div': np.divide,
         'neg': lambda a, _: -a, 'sqrt': lambda a, _: np.sqrt(a),
         'sin': lambda a, _: np.array([TEXT.sine(x) for x in a.tolist()]),
         'cos': lambda a, _: np.array([TEXT.cosine(x) for x in a.tolist()])}


def plainly(line, samples):
    """Return what a program gives for each sample, one operation after the other."""
    given = [*np.array(samples).T]

    def value(x):
        return given[x] if isinstance(x, int) else np.full(len(samples), x, float)

    with np.errstate(all='ignore'):
        for kind, left, right in line.operations:
            given.append(PLAIN[kind](value(left), None if right is None else value(right)))
    return np.array([value(x) for x in line.outputs]).T.tolist()


def bits(values):
    """Return numbers as text that tells all bits apart but those of NaN."""
    return [float(x).hex() for x in values]


@pytest.fixture(params=range(25))
def case(request):
    """Return a program, and samples of which some have special values."""
    rng = random.Random(request.param)
    samples = [[rng.choice([1.0, 10.0, 1e6]) * rng.gauss(0, 1) for _ in range(6)]
               for _ in range(131)]
    for k in range(0, 131, 10):
        samples[k][rng.randrange(6)] = rng.choice(SPECIAL)
    return some_program(request.param), samples


def test_all_ways_of_running_have_the_same_bits(case):
    """Operation by operation; interpreter compiled and as text; Python text; one or many."""
    line, samples = case
    expected = [bits(row) for row in plainly(line, samples)]
    batch, out = np.array(samples), np.empty((len(samples), len(line.outputs)))
    parts = batch[:, :2], batch[:, 2:4], batch[:, 4:]
    slices = {'all': slice(0, len(line.outputs))}
    for made in (machine(line, 2, slices), TextMachine(line, 2, slices)):
        assert [bits(made.evaluate(sample)) for sample in samples] == expected
        made.batch(parts, out, 2)
        assert [bits(row) for row in out] == expected
        found = made.sample(tuple(part[7].copy() for part in parts))
        assert bits(found['all']) == expected[7]


def test_the_text_of_the_interpreter_has_the_same_bits(case, monkeypatch):
    line, samples = case
    expected = [bits(row) for row in plainly(line, samples[:30])]
    monkeypatch.setattr(layout, 'Interpreter', TEXT.Interpreter)
    text = layout.interpreter(line, 6, {'all': slice(0, len(line.outputs))})
    assert [bits(text.evaluate(sample)) for sample in samples[:30]] == expected
    batch, out = np.array(samples[:30]), np.empty((30, len(line.outputs)))
    none = np.empty((30, 0))
    assert text.batch(0, 30, out, batch[:, :5], batch[:, 5:], none, none, none)
    assert [bits(row) for row in out] == expected
    assert bits(text.sample((batch[3],))['all']) == expected[3]


@pytest.mark.parametrize('module', [interpreter, TEXT])
def test_sine_and_cosine_are_right_within_one_unit_of_one(module):
    rng = random.Random(0)
    for _ in range(20_000):
        x = rng.choice([1.0, 10.0, 1e5, 1e9]) * rng.uniform(-1, 1)
        assert abs(module.sine(x) - math.sin(x)) < 2.3e-16
        assert abs(module.cosine(x) - math.cos(x)) < 2.3e-16
    assert math.isnan(module.sine(math.inf)) and math.isnan(module.cosine(math.nan))


def made(module, code=(), n_rows=4, n_inputs=2, constants=(1.0,), outputs=(0,)):
    return module.Interpreter(array('Q', code), n_rows, n_inputs, array('d', constants),
                              array('Q', outputs), 1, [], np.empty)


def word(*rows):
    return sum(row << 16 * k for k, row in enumerate(rows))


@pytest.mark.parametrize('module', [interpreter, TEXT])
@pytest.mark.parametrize('arguments', [
    {'code': [1 << 16]}, {'code': [word(0, 2), word(3, 0, 1, 2)]},     # ends before its run does
    {'code': [word(6, 1), word(3, 0, 1, 2)]},                          # a kind that is not there
    {'code': [word(0, 1), word(3, 0, 1, 4)]}, {'code': [word(0, 1), word(4, 0, 1, 2)]},
    {'code': [word(0, 1), word(1, 0, 1, 2)]}, {'code': [word(0, 1), word(2, 0, 1, 2)]},
    {'code': [word(5, 1), word(3, 0, 1)]},                             # cosine into an input
    {'code': [(1 << 64) - 1]}, {'outputs': [4]}, {'outputs': [1 << 63]},
    {'n_rows': 2}, {'n_rows': 1 << 17}, {'n_inputs': -1}])
def test_code_beyond_its_rows_is_refused(module, arguments):
    with pytest.raises(ValueError, match='rows'):
        made(module, **arguments)


@pytest.mark.parametrize('module', [interpreter, TEXT])
def test_arrays_that_do_not_fit_are_refused(module):
    good = made(module, [word(0, 1), word(3, 0, 1, 2)], outputs=[3])
    assert good.evaluate([2.0, 3.0]) == (7.0,)
    for values in ([], [1.0], [1.0] * 3):
        with pytest.raises(ValueError, match='2 numbers are needed'):
            good.evaluate(values)
    one = np.ones(1)
    assert good.sample((one, one)) == {}
    for parts in ((), (one,), (one, np.ones(2)), (one, np.ones((1, 1))), (one, one.astype('f4')),
                  (one, one.astype('>f8')), (one, np.ones(1, dtype=int))):
        assert good.sample(parts) is None
    many, out, none = np.ones((5, 1)), np.zeros((5, 1)), np.empty((5, 0))
    assert good.batch(1, 4, out, many, many, none, none, none)
    assert out.ravel().tolist() == [0, 2, 2, 2, 0]
    for start, stop, target, q, qd in [
            (0, 5, out, many, none), (0, 6, out, many, many), (-1, 5, out, many, many),
            (3, 2, out, many, many), (0, 5, out, many, many[:4]), (0, 4, out, many[:4], many[:4]),
            (0, 5, np.zeros((5, 2)), many, many), (0, 4, np.zeros((4, 1)), many, many)]:
        assert not good.batch(start, stop, target, q, qd, none, none, none)
    assert not good.batch(0, 5, out, many, many, many, none, none)


def test_a_sequence_that_shrinks_while_it_is_read_is_no_danger():
    class Shrinks:
        def __float__(self):
            values.clear()
            return 1.0

    values = [Shrinks(), 2.0]
    with pytest.raises(IndexError):
        made(interpreter, outputs=[0]).evaluate(values)
