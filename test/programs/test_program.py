# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Compiled programs against the chain itself: all outputs, axes, and poles."""
from threading import Thread

import numpy as np
import pytest

from screw_kinematics import Joint, SerialChain
from screw_kinematics.errors import InvalidValueError, ShapeError, UnknownNameError
from screw_kinematics.programs.machine import TextMachine, WORTH_A_THREAD
from support.program_cases import assert_close, CHAINS, motion, OUTPUTS, reference


@pytest.mark.parametrize('axes', ['base', 'tip'])
@pytest.mark.parametrize('pole', ['base', 'tip'])
@pytest.mark.parametrize('name', CHAINS)
def test_all_outputs_agree_with_the_recursion(name, axes, pole):
    chain = CHAINS[name]
    program = chain.compile(OUTPUTS, axes, pole)
    samples = motion(chain, 20)
    expected = reference(chain, samples, axes, pole)
    batch = program.batch(*samples)
    assert tuple(batch) == OUTPUTS
    for output in OUTPUTS:
        assert_close(batch[output], expected[output])
    single = program(*[part[3] for part in samples])
    for output in OUTPUTS:
        assert_close(single[output], batch[output][3])


@pytest.mark.parametrize('n', [1, 2, 3, 4, 5, 63, 64, 65])
def test_results_go_where_they_are_wanted(n):
    chain = CHAINS['rpr']
    program = chain.compile()
    samples = motion(chain, n, order=2)
    guarded = np.full((n + 2, 24), 77.0)
    results = program.batch(*samples, out=guarded[1:-1])
    assert np.shares_memory(results['pose'], guarded)
    assert_close(results['accel'], chain.state(*samples).classical(2))
    assert np.all(guarded[[0, -1]] == 77.0)


@pytest.mark.parametrize('out, error, match', [
    (np.zeros((5, 23)), ShapeError, r'out: expected shape \(5, 24\), got \(5, 23\)'),
    (np.zeros((5, 24), dtype=np.float32), InvalidValueError, 'contiguous array of float64'),
    (np.zeros((24, 5)).T, InvalidValueError, 'contiguous array of float64')])
def test_unsuitable_memory_for_results_is_refused(out, error, match):
    chain = CHAINS['rpr']
    with pytest.raises(error, match=match):
        chain.compile().batch(*motion(chain, 5, order=2), out=out)


def test_inputs_need_not_be_contiguous():
    chain = CHAINS['rpr']
    q, qd = motion(chain, 30, order=1)
    program = chain.compile('twist')
    expected = program.batch(q[::3].copy(), qd[::3].copy())['twist']
    assert np.array_equal(program.batch(q[::3], np.asfortranarray(qd)[::3])['twist'], expected)


@pytest.mark.parametrize('n', [0, 1, 7, 2000, 2001])
def test_batches_of_any_length(n):
    chain = CHAINS['rpr']
    program = chain.compile()
    samples = motion(chain, n, order=2)
    expected = chain.state(*samples)
    results = program.batch(*samples)
    assert_close(results['twist'], expected.velocity)
    assert_close(results['accel'], expected.classical(2))


def test_evaluate_is_flat_and_in_the_order_asked():
    chain = CHAINS['panda']
    program = chain.compile(('twist', 'pose'))
    q, qd = motion(chain, 1, order=1)
    assert program.order == 1 and program.inputs == 14
    flat = np.array(program.evaluate([*q[0], *qd[0]]))
    assert program.slices == {'twist': slice(0, 6), 'pose': slice(6, 18)}
    assert_close(flat[:6], chain.state(q[0], qd[0]).velocity)
    assert_close(flat[6:9], chain.pose(q[0])[:3, 3])


@pytest.mark.parametrize('outputs, order', [
    ('pose', 0), (('jacobian',), 0), (('pose', 'twist'), 1), (('reduced_accel',), 2),
    (('jerk', 'twist'), 3), (('reduced_snap',), 4)])
def test_inputs_go_as_far_as_the_outputs_need(outputs, order):
    program = CHAINS['rpr'].compile(outputs)
    assert program.order == order
    assert program.inputs == 3 * (order + 1)


def test_nan_goes_through_a_single_sample():
    chain = CHAINS['panda']
    program = chain.compile()
    assert np.isnan(program.evaluate([float('nan')] * program.inputs)).any()
    assert np.isnan(program.evaluate(np.full(program.inputs, np.nan, np.float32))).any()


@pytest.mark.parametrize('kind', ['as it is', TextMachine])
def test_a_symbol_that_reads_as_nan_is_refused_by_name(kind):
    class Symbol(str):      # as those of CasADi

        def __float__(self):
            return float('nan')

    program = CHAINS['panda'].compile(('twist',))
    run = program if kind == 'as it is' else kind(program.line, program.dof, program.slices)
    with pytest.raises(ValueError, match=r"'q_3' is no number; .* Program.source\('python'\)"):
        run.evaluate([*[0.1] * 3, Symbol('q_3'), *[0.2] * (program.inputs - 4)])


@pytest.mark.parametrize('arguments, error, match', [
    ({'outputs': ('pose', 'speed')}, UnknownNameError, "output 'speed'; known: 'pose'"),
    ({'outputs': ()}, InvalidValueError, 'no outputs asked for; known: pose'),
    ({'outputs': ('pose', 'pose')}, InvalidValueError, "'pose' is asked for more than once"),
    ({'axes': 'world'}, UnknownNameError, "axes 'world'; known: 'base', 'tip'"),
    ({'pole': 'hand'}, UnknownNameError, "pole 'hand'; known: 'base', 'tip'")])
def test_what_is_unknown_is_refused_with_the_alternatives(arguments, error, match):
    with pytest.raises(error, match=match):
        CHAINS['rpr'].compile(**arguments)


def test_missing_derivatives_are_named():
    program = CHAINS['rpr'].compile('accel')
    with pytest.raises(InvalidValueError, match='needs q, qd, qdd; got 2 of them'):
        program([0, 0, 0], [0, 0, 0])


@pytest.mark.parametrize('call, shapes, match', [
    ('__call__', [(3,), (4,)], r'qd: expected shape \(3,\), all alike, got \(4,\)'),
    ('__call__', [(2, 3), (2, 3)], r'q: expected shape \(3,\), all alike, got'),
    ('batch', [(5, 3), (4, 3)], r'qd: expected shape \(N, 3\), all alike, got \(4, 3\)'),
    ('batch', [(3,), (3,)], r'q: expected shape \(N, 3\), all alike, got \(3,\)')])
def test_wrong_shapes_are_refused(call, shapes, match):
    program = CHAINS['rpr'].compile('twist')
    with pytest.raises(ShapeError, match=match):
        getattr(program, call)(*[np.zeros(shape) for shape in shapes])


def test_symbolic_chains_are_refused():
    sympy = pytest.importorskip('sympy')
    chain = SerialChain([Joint('q', 'helical', (0, 0, 1), pitch=sympy.Symbol('h'))])
    with pytest.raises(InvalidValueError, match='symbolic parameters'):
        chain.compile()


@pytest.mark.parametrize('kind', [list, tuple, np.float32, np.int64, np.asfortranarray])
def test_a_sample_may_be_any_kind_of_numbers(kind):
    program = CHAINS['rpr'].compile('twist')
    q, qd = np.array([[0.5, 1.0, -2.0], [1.0, 0.25, 3.0]])
    convert = kind if kind in (list, tuple, np.asfortranarray) else (lambda x: x.astype(kind))
    expected = program(convert(q).astype(float), convert(qd).astype(float))['twist'] \
        if kind is np.int64 else program(q, qd)['twist']
    assert np.array_equal(program(convert(q), convert(qd))['twist'], expected)
    assert np.array_equal(program(q[::-1][::-1], np.repeat(qd, 2)[::2])['twist'],
                          program(q, qd)['twist'])


def test_derivatives_beyond_the_order_are_passed_over():
    program = CHAINS['rpr'].compile('twist')
    q, qd, qdd = np.random.default_rng(0).normal(size=(3, 3))
    assert np.array_equal(program(q, qd, qdd)['twist'], program(q, qd)['twist'])


def test_long_batches_are_samples_one_by_one_to_the_bit():
    """As long as to be worth two threads, with rest blocks in both."""
    chain = CHAINS['panda']
    program = chain.compile()
    samples = motion(chain, 2 * WORTH_A_THREAD + 77, order=2)
    samples[0][5, 1], samples[0][70, 2], samples[0][71, 3] = np.nan, 1e7, np.inf
    results = program.batch(*samples)
    rng = np.random.default_rng(0)
    joint = [WORTH_A_THREAD + 38, WORTH_A_THREAD + 39]      # where the threads' parts meet
    for k in [5, 63, 64, 70, 71, *joint, *rng.integers(len(samples[0]), size=300)]:
        for name, values in program(*[part[k] for part in samples]).items():
            assert values.tobytes() == results[name][k].tobytes() or np.isnan(values).any()
            np.testing.assert_array_equal(values, results[name][k])


def test_other_threads_run_while_a_batch_does():
    chain = CHAINS['panda']
    program, samples = chain.compile(), motion(chain, 20_000, order=2)
    expected = program.batch(*samples)['accel']
    found = []
    threads = [Thread(target=lambda: found.append(program.batch(*samples)['accel']))
               for _ in range(4)]
    for thread in threads:
        thread.start()
    for k in range(0, 20_000, 1000):
        single = program(*[part[k] for part in samples])['accel']
        assert np.array_equal(single, expected[k])
    for thread in threads:
        thread.join()
    assert len(found) == 4 and all(np.array_equal(values, expected) for values in found)
