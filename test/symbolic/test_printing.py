# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What is printed runs and gives the numbers of the chain."""
import ctypes
import subprocess

import numpy as np
import pytest

from screw_kinematics.errors import InvalidValueError
from support import robots
from support.c_compiler import COMPILER, needs_compiler

sympy = pytest.importorskip('sympy')
formulas = pytest.importorskip('screw_kinematics.symbolic.printing')
symbolic = pytest.importorskip('screw_kinematics.symbolic')

RPR = robots.robot('rpr')
STATE = symbolic.symbolic_state(RPR)
COORDINATES = symbolic.joint_symbols(3, 2)
OUTPUTS = {'height': STATE.pose[1, 3], 'twist': STATE.velocity, 'accel': STATE.classical(2)}
MOTION = robots.random_motion(1, 3, order=2)
EXPECTED = RPR.state(*MOTION)


def check(height, twist, accel):
    np.testing.assert_allclose(height, EXPECTED.pose[1, 3], rtol=1e-14)
    np.testing.assert_allclose(twist, EXPECTED.velocity, rtol=0, atol=1e-14)
    np.testing.assert_allclose(accel, EXPECTED.classical(2), rtol=0, atol=1e-13)


def test_python_source_runs():
    namespace = {}
    exec(formulas.python_source('rpr', OUTPUTS, COORDINATES), namespace)
    check(**namespace['rpr'](*MOTION.ravel()))


@needs_compiler
def test_c_source_compiles_without_warnings_and_runs(tmp_path):
    source, library = tmp_path / 'rpr.c', tmp_path / 'rpr.so'
    source.write_text(formulas.c_source('rpr', OUTPUTS, COORDINATES))
    subprocess.run([COMPILER, '-std=c99', '-Wall', '-Werror', '-shared', '-fPIC', '-o', library,
                    source, '-lm'], check=True)
    results = [(ctypes.c_double * n)() for n in (1, 6, 6)]
    ctypes.CDLL(str(library)).rpr(*map(ctypes.c_double, MOTION.ravel()), *results)
    check(results[0][0], *results[1:])


def test_arguments_are_sorted_naturally():
    symbols = sympy.symbols('q10 q2 a')
    assert 'def f(a, q2, q10):' in formulas.python_source('f', {'x': sum(symbols)})


def test_matrices_are_written_row_by_row():
    namespace = {}
    exec(formulas.python_source('f', {'R': STATE.pose[:3, :3]}, COORDINATES[:1]), namespace)
    np.testing.assert_allclose(np.reshape(namespace['f'](*MOTION[0])['R'], (3, 3)),
                               EXPECTED.pose[:3, :3], rtol=0, atol=1e-15)


def test_shared_expressions_do_not_shadow_arguments():
    t0, x = sympy.symbols('t0 x')
    namespace = {}
    outputs = {'a': sympy.sin(x) + t0, 'b': sympy.sin(x) * t0}
    exec(formulas.python_source('f', outputs, [t0, x]), namespace)
    assert namespace['f'](2.0, 0.5) == {'a': np.sin(0.5) + 2, 'b': np.sin(0.5) * 2}


@pytest.mark.parametrize('name, text', [
    ('q1', 'q_{1}'), ('qd2', r'\dot{q}_{2}'), ('qdd10', r'\ddot{q}_{10}'),
    ('qddd1', r'\dddot{q}_{1}'), ('qdddd1', r'\ddddot{q}_{1}'), ('alpha', r'\alpha')])
def test_latex_of_symbols(name, text):
    assert formulas.latex(sympy.Symbol(name)) == text


def test_latex_of_arrays():
    text = formulas.latex(STATE.pose[:3, :3])
    assert text.startswith(r'\begin{bmatrix}') and text.count(r'\\') == 2


def test_missing_arguments_and_odd_names_are_refused():
    x, odd = sympy.Symbol('x'), sympy.Symbol('lambda')
    with pytest.raises(InvalidValueError, match=r"f: the outputs contain the symbols \['x'\]"):
        formulas.c_source('f', {'y': x}, [sympy.Symbol('z')])
    with pytest.raises(InvalidValueError, match="'lambda' is no identifier"):
        formulas.python_source('f', {'y': odd})
    with pytest.raises(InvalidValueError, match="'my-f' is no identifier"):
        formulas.python_source('my-f', {'y': x})
