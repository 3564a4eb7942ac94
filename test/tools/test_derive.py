# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What is derived is the chain: formulas, programs in Python, compiled C."""
from contextlib import redirect_stdout
import ctypes
from functools import cache
from io import StringIO
from pathlib import Path
import re
import subprocess

import numpy as np
import pytest

from screw_kinematics import Joint, models, SerialChain
from screw_kinematics.programs.quantities import find_quantity, NAMES
from screw_kinematics.screws import se3
from screw_kinematics.tools import console
from screw_kinematics.tools.derive import main as derive
from screw_kinematics.tools.derive.request import function_name, heading, Request
from support.c_compiler import COMPILER, needs_compiler

pytest.importorskip('sympy')
ROBOTS = Path(__file__).parents[2] / 'config' / 'robots'
RPR = str(ROBOTS / 'rpr.yaml')
QUANTITIES = ['pose', 'screws', 'jacobian', 'twist', 'coriolis_lie', 'accel', 'reduced_jerk',
              'snap']


def expected(robot, motion, axes='base', pole='tip'):
    """Return what each quantity is, by the recursion on numbers."""
    state = robot.state(*motion)
    screws = robot.screws(motion[0], pole)
    if axes == 'tip':
        screws = se3.rotate(state.pose[:3, :3].T, screws)
    values = {'pose': np.concatenate([state.pose[:3, 3], state.pose[:3, :3].ravel()]),
              'screws': screws.ravel(),
              'jacobian': robot.jacobian(motion[0], pole, axes).ravel(),
              'coriolis_lie': robot.coriolis_lie(motion[0], motion[1], pole, axes)}
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
    assert 'p_x = a*cos(q1 + q3) + q2*cos(q1)' in lines
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
    arguments = [RPR, '--format', 'python', '--quantity', ','.join(QUANTITIES[:-1]),
                 '--axes', axes, '--pole', pole, *form]
    assert derive.main(arguments) == console.OK
    namespace = {}
    exec(capsys.readouterr().out, namespace)
    robot = models.load(RPR)
    motion = random_motion(robot)
    exact = expected(robot, motion, axes, pole)
    # Both forms take q, qd, ... and return a dictionary.
    found = namespace['rpr'](*motion[:4])
    assert list(found) == QUANTITIES[:-1]
    for name, values in found.items():
        close(values, exact[name])


@needs_compiler
@pytest.mark.parametrize('robot, form', [
    ('rpr', 'straight'), ('rpr', 'closed'), ('puma560', 'straight'), ('panda', 'straight')])
def test_c_compiles_without_a_warning_and_is_the_chain(robot, form, tmp_path):
    """Whatever the file is called, it includes the header beside it; both forms are alike."""
    source, library = tmp_path / 'other.c', tmp_path / 'arm.so'
    file = ROBOTS / f'{robot}.yaml'
    assert derive.main([str(file), '--format', 'c', '--quantity', ','.join(QUANTITIES),
                        '--form', form, '--name', 'arm', '--output', str(source)]) == console.OK
    run = subprocess.run(
        [COMPILER, '-std=c99', '-Wall', '-Wextra', '-Wpedantic', '-O2', '-ffp-contract=off',
         '-shared', '-fPIC', '-o', library, source, '-lm'], capture_output=True, text=True)
    assert run.returncode == 0 and run.stderr == ''
    chain = models.load(file)
    header = (tmp_path / 'other.h').read_text()
    assert f'const double qdd[{chain.dof}]' in header
    assert f'motion of {chain.tip_frame} relative to {chain.base_frame}' in header
    motion = random_motion(chain)
    sizes = [find_quantity(name).size(chain.dof, len(chain.joints)) for name in QUANTITIES]
    results = [(ctypes.c_double * size)() for size in sizes]
    ctypes.CDLL(str(library)).arm(*((ctypes.c_double * chain.dof)(*row) for row in motion),
                                  *results)
    for name, result in zip(QUANTITIES, results):
        close(np.array(result), expected(chain, motion)[name])


@needs_compiler
def test_c_without_some_inputs_has_no_warning_either(tmp_path):
    source = tmp_path / 'made' / 'rpr.c'
    assert derive.main([RPR, '--format', 'c', '--quantity', 'pose', '--output',
                        str(source)]) == console.OK
    run = subprocess.run(
        [COMPILER, '-std=c99', '-Wall', '-Wextra', '-Wpedantic', '-Werror', '-c',
         '-o', tmp_path / 'rpr.o', source], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr


@pytest.mark.parametrize('there', ['rpr.c', 'rpr.h'])
def test_what_is_there_is_only_overwritten_by_force(there, tmp_path, capsys):
    (tmp_path / there).write_text('mine')
    arguments = [RPR, '--format', 'c', '--quantity', 'pose', '--output', str(tmp_path / 'rpr.c')]
    assert derive.main(arguments) == console.FAILED
    assert f'{tmp_path / there} exists already; choose another output, or --force\n' in (
        capsys.readouterr().err)
    assert [file.name for file in tmp_path.iterdir()] == [there]
    assert derive.main([*arguments, '--force']) == console.OK
    assert 'mine' not in (tmp_path / there).read_text()


def test_a_header_does_not_take_the_place_of_its_source(tmp_path, capsys):
    assert derive.main([RPR, '--format', 'c', '--quantity', 'pose', '--output',
                        str(tmp_path / 'rpr.h')]) == console.FAILED
    assert 'allowed: the source, as FILE.c' in capsys.readouterr().err


def test_straight_line_text_is_the_function(capsys):
    assert derive.main([RPR, '--quantity', 'twist', '--form', 'straight']) == console.OK
    assert capsys.readouterr().out.startswith('def rpr(q, qd):')


def test_names_cannot_end_the_comment_they_stand_in():
    robot = SerialChain([Joint('q*/\n"""', 'revolute', axis=(0, 0, 1))], base_frame='a"""\nb')
    request = Request((), 'text', 'closed', 'robot', 'robot', 'base', 'tip', True, 0.0)
    text = '\n'.join(heading(robot, request))
    assert text.count('\n') == 2 and '"' not in text and '*/' not in text


@pytest.mark.parametrize('name', NAMES)
def test_each_quantity_is_derived(name, capsys):
    assert derive.main([RPR, '--quantity', name, '--no-simplify']) == console.OK
    assert find_quantity(name).described() in capsys.readouterr().out


@pytest.mark.parametrize('arguments, message', [
    ([RPR, '--quantity', 'twist,force'], "unknown quantity 'force'; known: 'pose', 'twist'"),
    ([RPR, '--name', '2x', '--format', 'c'], "parameter 'name' is '2x'; allowed: letters"),
    ([RPR, '--name', 'class', '--format', 'python'], "parameter 'name' is 'class'; allowed:"),
    ([str(ROBOTS / 'delta.yaml'), '--quantity', 'snap'],
     'delta: snap: for parallel robots there are screws, jacobian, twist'),
    ([str(ROBOTS / 'delta.yaml'), '--axes', 'tip'], "parameter 'axes' is 'tip'; allowed: 'base'"),
    ([str(ROBOTS / 'delta.yaml'), '--format', 'c'], 'delta: a parallel robot has no closed form'),
    ([str(ROBOTS / 'delta.yaml'), '--format', 'c', '--form', 'closed'],
     'delta: a parallel robot has no closed form'),
])
def test_errors_are_one_line(arguments, message, capsys):
    assert derive.main(arguments) == console.FAILED
    error = capsys.readouterr().err
    assert message in error and error.count('\n') == 1


@pytest.mark.parametrize('robot, name', [
    ('panda', 'panda'), ('Löffel 3', 'Loffel_3'), ('2fg7_outwards', 'tip_motion'),
    ('class', 'tip_motion'), ('double', 'tip_motion'), ('日本', 'tip_motion'), ('', 'tip_motion')])
@pytest.mark.parametrize('language', ['text', 'latex', 'python', 'c'])
def test_no_name_of_a_robot_is_an_obstacle(robot, name, language, tmp_path, capsys):
    file = tmp_path / 'arm.urdf'
    file.write_text(f'''<robot name="{robot or 'x'}"><link name="a"/><link name="b"/>
        <joint name="j" type="revolute"><parent link="a"/><child link="b"/>
        <origin xyz="0.2 0 0"/><axis xyz="0 0 1"/><limit velocity="1"/></joint></robot>''')
    assert derive.main([str(file), '--quantity', 'twist', '--format', language]) == console.OK
    out, error = capsys.readouterr()
    if language == 'text':
        assert 'w_z = qd1\n' in out and 'v_x = 0\n' in out
    elif language == 'latex':
        assert r'\omega_{z} &= \dot{q}_{1} ' in out
    elif robot:
        assert f'{"def" if language == "python" else "void"} {name}(' in out
        assert (f'the function is called {name}' in error) == (name != robot)
    assert function_name(robot, None) == name


ROUNDED = """<robot name="arm">
<link name="base"/><link name="a"/><link name="b"/><link name="tip"/>
<joint name="j1" type="revolute"><parent link="base"/><child link="a"/>
<origin xyz="0 0 0.4" rpy="0 {0} 0"/><axis xyz="1 0 0"/><limit velocity="1"/></joint>
<joint name="j2" type="revolute"><parent link="a"/><child link="b"/>
<origin xyz="0.3 0 0" rpy="0 0 {0}"/><axis xyz="0 1 0"/><limit velocity="1"/></joint>
<joint name="j3" type="revolute"><parent link="b"/><child link="tip"/>
<origin xyz="0.2 0 0" rpy="-{0} 0 0"/><axis xyz="0 0 1"/><limit velocity="1"/></joint></robot>"""


def derived_text(tmp_path, capsys, text, *options):
    """Return the formulas of a description's twist, and what heads them."""
    file = tmp_path / 'arm.urdf'
    file.write_text(text)
    assert derive.main([str(file), '--quantity', 'twist', *options]) == console.OK
    head, _, formulas = capsys.readouterr().out.partition('\nangular velocity')
    return head, formulas


@pytest.mark.parametrize('quarter', ['1.57079632679', '1.5707963268', '1.570796327'])
def test_rounded_quarter_turns_are_quarter_turns_in_formulas(quarter, tmp_path, capsys):
    note = 'angles within 1e-9 rad of a multiple of pi/12'
    head, exact = derived_text(tmp_path, capsys, ROUNDED.format('1.5707963267948966'))
    assert note not in head and 'w_z = -qd1 + qd2 + qd3' in exact
    head, rounded = derived_text(tmp_path, capsys, ROUNDED.format(quarter))
    assert rounded == exact and note in head
    head, longer = derived_text(tmp_path, capsys, ROUNDED.format(quarter), '--exact')
    assert note not in head and len(longer) > 3 * len(exact)


@pytest.mark.parametrize('twelfths', range(1, 12))
def test_multiples_of_fifteen_degrees_are_exact(twelfths, tmp_path, capsys):
    """Written with eleven digits, they are found again."""
    import sympy
    angle = f'{np.pi * twelfths / 12:.10f}'
    text = f'''<robot name="arm"><link name="a"/><link name="b"/><joint name="j"
        type="revolute"><parent link="a"/><child link="b"/><origin rpy="{angle} 0 0"/>
        <axis xyz="0 0 1"/><limit velocity="1"/></joint></robot>'''
    _, formulas = derived_text(tmp_path, capsys, text)
    found = dict(re.findall(r'^(w_[yz]) = (.*)$', formulas, re.MULTILINE))
    angle = sympy.pi * twelfths / 12
    for name, value in (('w_y', -sympy.sin(angle)), ('w_z', sympy.cos(angle))):
        assert sympy.simplify(sympy.sympify(found[name]) - value * sympy.Symbol('qd1')) == 0


def test_straight_latex_names_its_terms_and_is_the_chain(capsys):
    """Read back line by line, it gives the numbers of the chain."""
    file = str(ROBOTS / 'panda.yaml')
    assert derive.main([file, '--quantity', 'accel', '--format', 'latex',
                        '--form', 'straight']) == console.OK
    text = capsys.readouterr().out
    assert len(text) < 30_000
    rows = re.findall(r'^  (\S+) &= (.*?)(?: \\\\)?$', text, re.MULTILINE)
    robot = models.load(file)
    motion = random_motion(robot)[:3]
    known = {'sin': np.sin, 'cos': np.cos}
    for dot, values in zip(('q', r'\dot{q}', r'\ddot{q}'), motion):
        known |= {plain(f'{dot}_{{{k}}}'): x for k, x in enumerate(values, start=1)}
    for left, right in rows:
        known[plain(left)] = eval(plain(right), {}, known)
    labels = [plain(f'{part}_{{{axis}}}') for part in (r'\alpha', 'a') for axis in 'xyz']
    close(np.array([known[label] for label in labels]), robot.state(*motion).classical(2))


def plain(latex):
    """Return LaTeX of a straight-line program as Python."""
    latex = re.sub(r'\\(d*)ot\{q\}', r'\1q', latex).replace(r'\left(', '(')
    latex = latex.replace(r'\right)', ')').replace(r'\,', '*').replace(r'\cdot 10^', '* 10.0**')
    return re.sub(r'[{}\\]', '', latex)


def test_long_closed_forms_are_announced(capsys):
    file = str(ROBOTS / 'panda.yaml')
    assert derive.main([file, '--quantity', 'twist', '--no-simplify']) == console.OK
    assert '--form straight gives named terms instead' in capsys.readouterr().err


def test_six_joints_are_simplified_where_it_takes_seconds(capsys):
    assert derive.main([str(ROBOTS / 'puma560.yaml'), '--quantity', 'twist']) == console.OK
    text = capsys.readouterr().out
    assert 'w_z = qd1' in text and len(text) < 4000 and '4/5' not in text


@cache
def printed(robot):
    """Return what is printed of a parallel robot."""
    text = StringIO()
    with redirect_stdout(text):
        assert derive.main([str(ROBOTS / f'{robot}.yaml'), '--quantity', 'velocity,jerk']) == (
            console.OK)
    return text.getvalue()


def printed_equations(text):
    """Return the equations of the platform, and the vectors d of the forces' lines."""
    equations = re.findall(r'^  (.*[wv]_[xyz].*) = (.*)$', text, re.MULTILINE)
    return equations, re.findall(r'^  d = \[(.*)\]$', text, re.MULTILINE)


@pytest.mark.parametrize('robot, rows', [('planar_3rrr', 3), ('stewart_6ups', 6), ('delta', 3)])
def test_printed_equations_of_a_parallel_robot_give_its_twist(robot, rows):
    """Read back as they stand, at a random posture, they are solved by the platform's twist."""
    equations, lines = printed_equations(printed(robot))
    manipulator, rng = models.load(ROBOTS / f'{robot}.yaml'), np.random.default_rng(2)
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
        return float(eval(text, {'sin': np.sin, 'cos': np.cos, 'sqrt': np.sqrt}, known))

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
    assert r'\dot{q}_{1} \dot{\theta}_{1} \left[\$_{1}, \$_{2}\right]' in text
    assert '% limb_3, actuation: force on the line from elbow_3 to wrist_3' in text


@pytest.mark.parametrize('robot', ['planar_3rrr', 'stewart_6ups', 'delta'])
def test_printed_equations_of_the_jerk(robot):
    """Read back as they stand: what the limbs contribute is what the manipulator computes."""
    text = printed(robot)
    assert '{W; K}' in text
    manipulator, rng = models.load(ROBOTS / f'{robot}.yaml'), np.random.default_rng(3)
    posture = manipulator.posture(
        manipulator.home.actuated + rng.uniform(-0.1, 0.1, manipulator.dof))
    rates = rng.normal(size=(2, manipulator.dof))
    (_, _, jerk), passive = manipulator.rates(posture, *rates, np.zeros(manipulator.dof))
    motion = {}
    for letter, values in (('q', (posture.actuated, *rates)), ('theta', (
            posture.passive, *passive[:2]))):
        for dots, numbers in zip(('', 'd', 'dd'), values):
            motion |= {f'{letter}{dots}{k}': x for k, x in enumerate(numbers, start=1)}
    joints = dict(zip(manipulator.joint_names + manipulator.passive_joint_names,
                      posture.joints))
    third = dict(zip(manipulator.joint_names + manipulator.passive_joint_names,
                     [*np.zeros(manipulator.dof), *passive[2]]))
    for limb in manipulator.limbs:
        section = text.partition(f'{limb.name}: unit screws')[2]
        screws = limb.screws([joints[name] for name in limb.joint_names])
        known = {**motion, 'lie': se3.lie_product,
                 **{f'S{k}': screw for k, screw in enumerate(screws, start=1)}}
        for left, right in re.findall(r'^  ([VAK]\d*) = (.*)$', section, re.MULTILINE):
            known[left] = eval(with_brackets(right), {}, known)
            if left == 'K':
                break
        # The limb's tip has the platform's jerk: K, and what its joints' third derivatives add.
        derivatives = limb.joint_values([third[name] for name in limb.joint_names], 3)
        np.testing.assert_allclose(known['K'] + derivatives @ screws, jerk, rtol=0,
                                   atol=1e-9 * np.abs(jerk).max())


def with_brackets(text):
    """Return printed Lie products as calls."""
    text, before = text.replace('$', 'S'), None
    while text != before:
        before, text = text, re.sub(r'\[([^\[\]]+), ([^\[\]]+)\]', r'lie(\1, \2)', text)
    return text
