# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What is derived is the chain: formulas, programs in Python, compiled C."""
import ctypes
from pathlib import Path
import re
import shutil
import subprocess

import numpy as np
import pytest

from screw_kinematics import Joint, models, SerialChain
from screw_kinematics.programs.quantities import find_quantity, NAMES
from screw_kinematics.tools import console
from screw_kinematics.tools.derive import main as derive
from screw_kinematics.tools.derive.closed_form import heading

pytest.importorskip('sympy')
ROBOTS = Path(__file__).parents[2] / 'config' / 'robots'
RPR = str(ROBOTS / 'rpr.yaml')
QUANTITIES = ['pose', 'twist', 'accel', 'reduced_jerk', 'snap']


def expected(robot, motion, axes='base', pole='tip'):
    """Return what each quantity is, by the recursion on numbers."""
    state = robot.state(*motion)
    values = {'pose': np.concatenate([state.pose[:3, 3], state.pose[:3, :3].ravel()])}
    state = state.about(pole).expressed_in(axes)
    for order, (name, reduced) in enumerate((('twist', 'twist'), ('accel', 'reduced_accel'),
                                             ('jerk', 'reduced_jerk'),
                                             ('snap', 'reduced_snap')), 1):
        values[reduced] = state.reduced[order - 1]
        values[name] = state.classical(order)
    return values


def random_motion(robot):
    """Return joint positions and four derivatives."""
    return np.random.default_rng(1).normal(size=(5, robot.dof))


def close(found, exact):
    """Compare to 1e-13 of the largest number."""
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-13 * max(1, np.abs(exact).max()))


def test_text_of_the_planar_arm(capsys):
    assert derive.main([RPR, '--quantity', 'pose,velocity,acceleration']) == console.OK
    lines = capsys.readouterr().out.splitlines()
    assert 'p_x = q2*cos(q1) + cos(q1 + q3)/4' in lines
    assert 'w_z = qd1 + qd3' in lines
    assert 'rpr: motion of tool relative to base' in lines
    assert sum(' = ' in line for line in lines[3:]) == 12 + 6 + 6


def test_latex_is_a_line_for_each_component(capsys):
    assert derive.main([RPR, '--quantity', 'acceleration', '--format', 'latex']) == console.OK
    text = capsys.readouterr().out
    assert text.count('&=') == 6 and r'\begin{aligned}' in text
    assert r'\alpha_{z} &= \ddot{q}_{1} + \ddot{q}_{3}' in text


@pytest.mark.parametrize('axes', ['base', 'tip'])
@pytest.mark.parametrize('pole', ['base', 'tip'])
@pytest.mark.parametrize('form', [['--form', 'straight'], ['--form', 'closed'],
                                  ['--form', 'closed', '--no-simplify']])
def test_python_is_the_chain(axes, pole, form, capsys):
    arguments = [RPR, '--format', 'python', '--quantity', 'pose,twist,accel,reduced_jerk',
                 '--axes', axes, '--pole', pole, *form]
    assert derive.main(arguments) == console.OK
    namespace = {}
    exec(capsys.readouterr().out, namespace)
    robot = models.load(RPR)
    motion = random_motion(robot)
    exact = expected(robot, motion, axes, pole)
    if 'straight' in form:
        found = namespace['rpr'](motion[:4].ravel().tolist())
        found = dict(zip(('pose', 'twist', 'accel', 'reduced_jerk'),
                         np.split(np.array(found), [12, 18, 24])))
    else:
        found = namespace['rpr'](*motion[:4].ravel())
    for name, values in found.items():
        close(values, exact[name])


@pytest.mark.parametrize('robot', ['rpr', 'puma560', 'panda'])
def test_c_compiles_without_a_warning_and_is_the_chain(robot, tmp_path):
    compiler = shutil.which('cc') or shutil.which('gcc')
    assert compiler, 'a C compiler is needed'
    source, library = tmp_path / 'arm.c', tmp_path / 'arm.so'
    file = ROBOTS / f'{robot}.yaml'
    assert derive.main([str(file), '--format', 'c', '--quantity', ','.join(QUANTITIES),
                        '--name', 'arm', '--output', str(source)]) == console.OK
    run = subprocess.run(
        [compiler, '-std=c99', '-Wall', '-Wextra', '-Wpedantic', '-O2', '-ffp-contract=off',
         '-shared', '-fPIC', '-o', library, source, '-lm'], capture_output=True, text=True)
    assert run.returncode == 0 and run.stderr == ''
    chain = models.load(file)
    header = (tmp_path / 'arm.h').read_text()
    assert f'const double qdd[{chain.dof}]' in header
    assert f'motion of {chain.tip_frame} relative to {chain.base_frame}' in header
    motion = random_motion(chain)
    sizes = [12 if name == 'pose' else 6 for name in QUANTITIES]
    results = [(ctypes.c_double * size)() for size in sizes]
    ctypes.CDLL(str(library)).arm(*((ctypes.c_double * chain.dof)(*row) for row in motion),
                                  *results)
    for name, result in zip(QUANTITIES, results):
        close(np.array(result), expected(chain, motion)[name])


def test_c_without_some_inputs_has_no_warning_either(tmp_path):
    source = tmp_path / 'rpr.c'
    assert derive.main([RPR, '--format', 'c', '--quantity', 'pose', '--output',
                        str(source)]) == console.OK
    run = subprocess.run(['cc', '-std=c99', '-Wall', '-Wextra', '-Wpedantic', '-Werror', '-c',
                          '-o', tmp_path / 'rpr.o', source], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr


def test_straight_line_text_is_the_function(capsys):
    assert derive.main([RPR, '--quantity', 'twist', '--form', 'straight']) == console.OK
    assert capsys.readouterr().out.startswith('def rpr(values')


def test_names_cannot_end_the_comment_they_stand_in():
    robot = SerialChain([Joint('q*/\n"""', 'revolute', axis=(0, 0, 1))], base_frame='a"""\nb')
    text = '\n'.join(heading(robot, 'robot', 'base', 'tip'))
    assert text.count('\n') == 2 and '"' not in text and '*/' not in text


@pytest.mark.parametrize('name', NAMES)
def test_each_quantity_is_derived(name, capsys):
    assert derive.main([RPR, '--quantity', name, '--no-simplify']) == console.OK
    assert find_quantity(name).described() in capsys.readouterr().out


@pytest.mark.parametrize('arguments, message', [
    ([RPR, '--quantity', 'twist,force'], "unknown quantity 'force'; known: 'pose', 'twist'"),
    ([RPR, '--form', 'straight', '--format', 'latex'], "'form' is 'straight'; allowed: 'closed'"),
    ([RPR, '--name', '2x'], "parameter 'name' is '2x'; allowed: letters"),
    ([str(ROBOTS / 'delta.yaml'), '--quantity', 'jerk'],
     'delta: jerk: for parallel robots there are the equations of twist, accel'),
    ([str(ROBOTS / 'delta.yaml'), '--axes', 'tip'], "parameter 'axes' is 'tip'; allowed: 'base'"),
    ([str(ROBOTS / 'delta.yaml'), '--format', 'c'], 'straight-line programs of open chains'),
    ([str(ROBOTS / 'delta.yaml'), '--format', 'c', '--form', 'closed'],
     'delta: there are closed forms of open chains only'),
])
def test_errors_are_one_line(arguments, message, capsys):
    assert derive.main(arguments) == console.FAILED
    error = capsys.readouterr().err
    assert message in error and error.count('\n') == 1


def printed_equations(text):
    """Return the equations of the platform, and the vectors d of the forces' lines."""
    equations = re.findall(r'^  (.*[wv]_[xyz].*) = (.*)$', text, re.MULTILINE)
    return equations, re.findall(r'^  d = \[(.*)\]$', text, re.MULTILINE)


@pytest.mark.parametrize('robot, rows', [('planar_3rrr', 3), ('stewart_6ups', 6), ('delta', 3)])
def test_printed_equations_of_a_parallel_robot_give_its_twist(robot, rows, capsys):
    """Read back as they stand, at a random posture, they are solved by the platform's twist."""
    import sympy
    file = ROBOTS / f'{robot}.yaml'
    assert derive.main([str(file), '--quantity', 'velocity']) == console.OK
    equations, lines = printed_equations(capsys.readouterr().out)
    manipulator, rng = models.load(file), np.random.default_rng(2)
    posture = manipulator.posture(
        manipulator.home.actuated + rng.uniform(-0.1, 0.1, manipulator.dof))
    rates = rng.normal(size=manipulator.dof)
    (twist,), _ = manipulator.rates(posture, rates)
    R = posture.pose[:3, :3]
    known = {**dict(zip(('w_x', 'w_y', 'w_z', 'v_x', 'v_y', 'v_z'), twist)),
             **{f'p_{axis}': x for axis, x in zip('xyz', posture.pose[:3, 3])},
             **{f'r{i + 1}{j + 1}': R[i, j] for i in range(3) for j in range(3)},
             'phi': np.arctan2(R[1, 0], R[0, 0])}
    for k, (q, qd) in enumerate(zip(posture.actuated, rates), start=1):
        known |= {f'q{k}': q, f'qd{k}': qd}

    def number(text):
        return float(sympy.sympify(text).subs(known))

    for k, line in enumerate(lines, start=1):
        d = np.array([number(part) for part in line.split(', ')])
        known |= {f'f{k}_{axis}': x for axis, x in zip('xyz', d / np.linalg.norm(d))}
    assert len(equations) == len(lines) == rows
    for left, right in equations:
        assert number(left) == pytest.approx(number(right), abs=1e-10)


def test_parallel_robot_in_latex(capsys):
    file = str(ROBOTS / 'planar_3rrr.yaml')
    assert derive.main([file, '--format', 'latex']) == console.OK
    text = capsys.readouterr().out
    assert text.count(r'\begin{aligned}') == text.count(r'\end{aligned}') == 3 * 6
    assert r'\dot{q}_{1} \dot{\theta}_{1} \left[\$_1, \$_2\right]' in text
    assert '% limb_3, actuation: force on the line from elbow_3 to wrist_3' in text
