# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Sine, cosine and transposition of the compiled batches."""
import numpy as np
import pytest

numba = pytest.importorskip('numba')
mpmath = pytest.importorskip('mpmath')
vector_math = pytest.importorskip('screw_kinematics.programs.vector_math')


@pytest.fixture(scope='module')
def sincos():
    function = vector_math.sincos

    @numba.njit(fastmath={'contract'}, error_model='numpy')
    def all_of(angles):
        out = np.empty((2, len(angles)))
        for i in range(len(angles)):
            out[0, i], out[1, i] = function(angles[i])
        return out

    return all_of


@pytest.mark.parametrize('size', [1e-300, 1e-8, 0.5, 2.0, 30.0, 1e3, 1e5])
def test_sine_and_cosine_are_right_to_a_rounding(sincos, size):
    rng = np.random.default_rng(int(size) % 1000)
    angles = rng.uniform(-size, size, 300)
    # Right beside multiples of pi/2 one of the two is nearly zero.
    beside = np.round(angles[:100] / (np.pi / 2)) * (np.pi / 2)
    angles = np.concatenate([angles, beside, np.nextafter(beside, 1e9), [0.0]])
    with mpmath.workprec(200):
        exact = [[mpmath.sin(mpmath.mpf(float(x))) for x in angles],
                 [mpmath.cos(mpmath.mpf(float(x))) for x in angles]]
        values = sincos(angles)
        error = [[abs(mpmath.mpf(float(v)) - e) for v, e in zip(*rows)]
                 for rows in zip(values, exact)]
        assert max(map(max, error)) < 1.2e-16


def test_not_finite_angles_give_nan(sincos):
    assert np.isnan(sincos(np.array([np.nan, np.inf, -np.inf]))).all()


@pytest.mark.parametrize('angle', [2e5, -3.7e9, 1e22])
def test_programs_turn_to_the_library_for_large_angles(angle):
    from screw_kinematics import Joint, SerialChain
    program = SerialChain([Joint('q', 'revolute', (0, 0, 1))]).compile('pose', 'numba')
    angles = np.linspace(0.5, 1.0, 9)[:, None]
    angles[4] = angle
    rotation = program.batch(angles)['pose'][:, 3:]
    np.testing.assert_allclose(rotation[:, 0], np.cos(angles[:, 0]), atol=2e-16)
    np.testing.assert_allclose(rotation[:, 3], np.sin(angles[:, 0]), atol=2e-16)


@pytest.mark.parametrize('rows, columns', [
    (4, 4), (8, 12), (1, 9), (9, 1), (3, 3), (5, 7), (7, 6), (64, 24), (0, 5), (13, 4)])
def test_transposition_writes_the_matrix_and_nothing_else(rows, columns):
    source = np.random.default_rng(rows).normal(size=(rows + 2, columns + 3))
    target = np.full((columns + 2, rows + 5), 7.0)
    expected = target.copy()
    expected[1:columns + 1, 2:rows + 2] = source[1:rows + 1, 3:].T
    vector_math.transpose(target.reshape(-1), (rows + 5) + 2, rows + 5, source.reshape(-1),
                          (columns + 3) + 3, columns + 3, rows, columns, False)
    assert np.array_equal(target, expected)


@pytest.mark.parametrize('rows, columns', [(4, 4), (6, 64), (24, 64), (24, 7), (30, 3), (2, 9)])
def test_transposition_past_the_cache(rows, columns):
    source = np.random.default_rng(rows).normal(size=(rows, columns))
    memory = np.full(rows * columns + 4, 7.0)
    start = 1 + (memory.ctypes.data // 8 + 1) % 2
    target = memory[start:start + rows * columns]
    vector_math.transpose(target, 0, rows, source.reshape(-1), 0, columns, rows, columns, True)
    assert np.array_equal(target.reshape(columns, rows), source.T)
    assert np.all(memory[:start] == 7.0) and np.all(memory[start + rows * columns:] == 7.0)
