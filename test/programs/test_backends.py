# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Compiled programs against the chain itself: all outputs, axes, poles and backends."""
import numpy as np
import pytest

from screw_kinematics import Joint, SerialChain
from screw_kinematics.errors import (
    InvalidValueError, MissingExtraError, ShapeError, UnknownNameError)
from support.program_cases import assert_close, CHAINS, motion, OUTPUTS, reference


@pytest.fixture(scope='module', autouse=True)
def own_cache(tmp_path_factory):
    """Keep machine code out of the user's cache."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('XDG_CACHE_HOME', str(tmp_path_factory.mktemp('cache')))
        yield


@pytest.fixture(params=['python', 'numba'])
def backend(request):
    if request.param == 'numba':
        pytest.importorskip('numba')
    return request.param


@pytest.mark.parametrize('axes', ['base', 'tip'])
@pytest.mark.parametrize('pole', ['base', 'tip'])
@pytest.mark.parametrize('name', CHAINS)
def test_all_outputs_agree_with_the_recursion(name, axes, pole):
    chain = CHAINS[name]
    program = chain.compile(OUTPUTS, 'python', axes, pole)
    samples = motion(chain, 20)
    expected = reference(chain, samples, axes, pole)
    batch = program.batch(*samples)
    assert tuple(batch) == OUTPUTS
    for output in OUTPUTS:
        assert_close(batch[output], expected[output])
    single = program(*[part[3] for part in samples])
    for output in OUTPUTS:
        assert_close(single[output], batch[output][3])


# Machine code takes seconds to make, so every chain has a part of the outputs here.
@pytest.mark.parametrize('name, outputs, axes, pole', [
    ('panda', ('pose', 'twist', 'accel'), 'base', 'tip'), ('puma', ('jerk',), 'base', 'base'),
    ('rpr', OUTPUTS, 'tip', 'base'), ('skew4', ('snap', 'jacobian'), 'tip', 'tip'),
    ('mimic', ('reduced_jerk', 'accel', 'pose'), 'base', 'base'),
    ('scara', ('twist', 'reduced_accel', 'jacobian'), 'tip', 'tip'),
    ('slide', OUTPUTS, 'base', 'tip'), ('fixed', ('pose', 'twist'), 'base', 'tip')])
def test_machine_code_agrees_with_plain_python(name, outputs, axes, pole):
    pytest.importorskip('numba')
    chain = CHAINS[name]
    fast = chain.compile(outputs, 'numba', axes, pole)
    plain = chain.compile(outputs, 'python', axes, pole)
    samples = motion(chain, 201, order=fast.order)
    expected = plain.batch(*samples)
    for output, values in fast.batch(*samples).items():
        assert_close(values, expected[output])
    for output, values in fast(*[part[7] for part in samples]).items():
        assert_close(values, expected[output][7])


@pytest.mark.parametrize('n', [1, 2, 3, 4, 5, 63, 64, 65])
def test_results_go_where_they_are_wanted(n, backend):
    chain = CHAINS['rpr']
    program = chain.compile(backend=backend)
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


def test_inputs_need_not_be_contiguous(backend):
    chain = CHAINS['rpr']
    q, qd = motion(chain, 30, order=1)
    program = chain.compile('twist', backend)
    expected = program.batch(q[::3].copy(), qd[::3].copy())['twist']
    assert np.array_equal(program.batch(q[::3], np.asfortranarray(qd)[::3])['twist'], expected)


@pytest.mark.parametrize('n', [0, 1, 7, 2000, 2001])
def test_batches_of_any_length(n, backend):
    chain = CHAINS['rpr']
    program = chain.compile(backend=backend)
    samples = motion(chain, n, order=2)
    expected = chain.state(*samples)
    results = program.batch(*samples)
    assert_close(results['twist'], expected.velocity)
    assert_close(results['accel'], expected.classical(2))


def test_evaluate_is_flat_and_in_the_order_asked(backend):
    chain = CHAINS['panda']
    program = chain.compile(('twist', 'pose'), backend)
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


def test_not_finite_inputs_do_not_raise_in_batches(backend):
    chain = CHAINS['panda']
    samples = motion(chain, 5, order=2)
    samples[0][1, 2] = np.nan
    samples[0][2, 2] = np.inf
    results = chain.compile(backend=backend).batch(*samples)['twist']
    assert np.isnan(results[1:3]).any(axis=1).all()
    assert np.isfinite(results[[0, 3, 4]]).all()


def test_nan_goes_through_a_single_sample(backend):
    chain = CHAINS['panda']
    program = chain.compile(backend=backend)
    assert np.isnan(program.evaluate([float('nan')] * program.inputs)).any()


@pytest.mark.parametrize('arguments, error, match', [
    ({'outputs': ('pose', 'speed')}, UnknownNameError, "output 'speed'; known: 'pose'"),
    ({'outputs': ()}, InvalidValueError, 'no outputs asked for; known: pose'),
    ({'outputs': ('pose', 'pose')}, InvalidValueError, "'pose' is asked for more than once"),
    ({'backend': 'cuda'}, UnknownNameError, "backend 'cuda'; known: 'auto', 'python'"),
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


def test_the_workspace_takes_inputs_and_gives_outputs(backend):
    chain = CHAINS['rpr']
    program = chain.compile(('pose', 'twist'), backend)
    samples = [part[0] for part in motion(chain, 1, order=1)]
    program.warm_up()
    program.workspace[:program.inputs] = np.concatenate(samples)
    program.run()
    outputs = program.workspace[program.inputs:]
    assert_close(outputs[program.slices['twist']], chain.state(*samples).velocity)


def test_machine_code_is_found_again(tmp_path, monkeypatch):
    pytest.importorskip('numba')
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    chain = CHAINS['slide']
    samples = [0.3], [0.2]
    first = chain.compile('twist', 'numba')(*samples)['twist']
    files = {path: path.stat().st_mtime_ns for path in tmp_path.rglob('*.nb*')}
    assert files
    second = chain.compile('twist', 'numba')(*samples)['twist']
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob('*.nb*')} == files
    assert np.array_equal(first, second)


def test_a_cache_that_cannot_be_written_is_done_without(tmp_path, monkeypatch):
    pytest.importorskip('numba')
    (tmp_path / 'file').write_text('not a directory')
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'file'))
    program = CHAINS['slide'].compile('twist', 'numba')
    assert np.array_equal(program([0.3], [0.2])['twist'], [0, 0, 0, 0, 0.2, 0])


def test_without_numba_the_extra_is_named(monkeypatch):
    monkeypatch.setattr('screw_kinematics.programs.backends.find_spec', lambda name: None)
    with pytest.raises(MissingExtraError, match=r"'numba'.*screw_kinematics\[fast\]"):
        CHAINS['rpr'].compile(backend='numba')
    assert CHAINS['rpr'].compile(backend='auto').backend == 'python'


@pytest.mark.parametrize('shift', [0, 1])
def test_results_larger_than_the_cache(shift, monkeypatch):
    numba_jit = pytest.importorskip('screw_kinematics.programs.numba_jit')
    monkeypatch.setattr(numba_jit, 'CACHE', 0)
    chain = CHAINS['rpr']
    samples = motion(chain, 131, order=1)
    memory = np.zeros(131 * 18 + 1)
    out = memory[shift:shift + 131 * 18].reshape(131, 18)
    chain.compile(('pose', 'twist'), 'numba').batch(*samples, out=out)
    assert_close(out[:, 12:], chain.state(*samples).velocity)
