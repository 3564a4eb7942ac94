# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Closed forms: the paper's RPR manipulator, DH chains with symbols, exactness."""
import subprocess
import sys

import numpy as np
import pytest

from screw_kinematics import Joint, Mimic, models, SerialChain
from screw_kinematics.errors import InvalidValueError, UnknownNameError
from screw_kinematics.screws import se3, states
from support import robots

sympy = pytest.importorskip('sympy')
symbolic = pytest.importorskip('screw_kinematics.symbolic')
DHJoint = symbolic.DHJoint

A = symbolic.parameter('a')
(Q1, Q2, Q3), (U1, U2, U3), (W1, W2, W3) = symbolic.joint_symbols(3)
S1, C1, S13, C13 = sympy.sin(Q1), sympy.cos(Q1), sympy.sin(Q1 + Q3), sympy.cos(Q1 + Q3)


def rpr():
    """Return the planar arm of the paper's section 4.1, its last link a symbol."""
    return models.load('package://screw_kinematics/config/robots/rpr.yaml',
                       symbol=symbolic.parameter)


def floats_in(*arrays):
    """Return the entries that are not exact."""
    return [e for x in arrays for e in np.ravel(x)
            if not isinstance(e, sympy.Basic) or e.has(sympy.Float)]


def test_rpr_position_and_velocity_in_closed_form():
    """The paper's example with its errors corrected: a c13 q3' in v_y, no q2 in 2$3."""
    state = symbolic.symbolic_state(rpr())
    assert list(state.pose[:3, 3]) == [Q2 * C1 + A * C13, Q2 * S1 + A * S13, 0]
    assert list(state.velocity) == [
        0, 0, U1 + U3,
        (-Q2 * S1 - A * S13) * U1 + C1 * U2 - A * S13 * U3,
        (Q2 * C1 + A * C13) * U1 + S1 * U2 + A * C13 * U3,
        0]


def test_rpr_acceleration_in_closed_form():
    """Screws times accelerations plus the Coriolis-Lie term, and nothing else."""
    acceleration = symbolic.symbolic_state(rpr()).reduced_acceleration
    coriolis = [
        -S1 * U1 * U2 + Q2 * C1 * U1 * U3 + S1 * U2 * U3,
        C1 * U1 * U2 + Q2 * S1 * U1 * U3 - C1 * U2 * U3]
    assert list(acceleration[:3]) == [0, 0, W1 + W3]
    assert acceleration[3] == (
        (-Q2 * S1 - A * S13) * W1 + C1 * W2 - A * S13 * W3 + coriolis[0])
    assert acceleration[4] == (
        (Q2 * C1 + A * C13) * W1 + S1 * W2 + A * C13 * W3 + coriolis[1])
    assert acceleration[5] == 0


def test_rpr_to_jounce_is_the_derivative_of_the_position():
    t = sympy.Symbol('t')
    functions = [sympy.Function(f'f{i}')(t) for i in (1, 2, 3)]
    coordinates = symbolic.joint_symbols(3, 4)
    back = {f.diff(t, k): c[i] for k, c in enumerate(coordinates)
            for i, f in enumerate(functions)}
    state = symbolic.symbolic_state(rpr(), 4)
    assert not floats_in(*state.reduced)
    position = sympy.Matrix([functions[1] * sympy.cos(functions[0])
                             + A * sympy.cos(functions[0] + functions[2]),
                             functions[1] * sympy.sin(functions[0])
                             + A * sympy.sin(functions[0] + functions[2])])
    for n in range(1, 5):
        exact = position.diff(t, n)
        # Highest derivatives first, so that f' inside f'' is not replaced.
        exact = exact.subs(sorted(back.items(), key=lambda p: -_order(p[0])))
        found = symbolic.simplify(state.classical(n)[3:5], coordinates[1:])
        difference = found - np.array(symbolic.simplify(list(exact), coordinates[1:]))
        assert [sympy.expand(x) for x in difference] == [0, 0]


def _order(expression):
    return expression.derivative_count if isinstance(expression, sympy.Derivative) else 0


def test_lie_algebra_identities_hold_for_symbols():
    x, y, z = (symbolic.six_vector(name) for name in 'XYZ')
    bracket = se3.lie_product
    jacobi = bracket(x, bracket(y, z)) + bracket(y, bracket(z, x)) + bracket(z, bracket(x, y))
    assert [sympy.expand(e) for e in jacobi] == [0] * 6
    assert sympy.expand(se3.klein_form(bracket(x, y), z) - se3.klein_form(x, bracket(y, z))) == 0
    assert sympy.expand(se3.killing_form(x, y) - se3.killing_form(y, x)) == 0


def test_composition_on_symbols_is_the_paper_s_theorem():
    V1, A1, V2, A2 = (symbolic.six_vector(name) for name in ('V1', 'A1', 'V2', 'A2'))
    velocity, acceleration = states.compose([V1, A1], [V2, A2])
    assert list(velocity) == list(V1 + V2)
    difference = acceleration - (A1 + A2 + se3.lie_product(V1, V2))
    assert [sympy.expand(e) for e in difference] == [0] * 6


@pytest.mark.parametrize('convention', ['standard', 'modified'])
def test_dh_chain_with_symbols_has_the_pose_of_the_dh_product(convention):
    d, a, b, alpha = sympy.symbols('d a b alpha', real=True)
    rows = [DHJoint(d=d, a=a, alpha=sympy.pi / 2), DHJoint(a=b, alpha=alpha, theta=0.5),
            DHJoint(kind='prismatic', theta=np.pi / 3, alpha=-np.pi / 2)]
    chain = symbolic.dh_chain(rows, convention)
    assert not floats_in(chain.T_base_tool)
    q = symbolic.joint_symbols(3, 0)[0]
    product = np.eye(4, dtype=int)
    for row, value in zip(rows, q):
        angle, shift = (row.theta, row.d + value) if row.kind == 'prismatic' else \
            (row.theta + value, row.d)
        about_z, about_x = matrix('z', angle, shift), matrix('x', row.alpha, row.a)
        product = product @ (about_z @ about_x if convention == 'standard'
                             else about_x @ about_z)
    numbers = {d: 0.3, a: -0.2, b: 0.7, alpha: 1.1, **dict(zip(q, (0.4, -0.8, 1.7)))}
    np.testing.assert_allclose(values(chain.pose(q), numbers), values(product, numbers),
                               rtol=0, atol=1e-14)


def matrix(axis, angle, shift):
    """Return a textbook homogeneous matrix: turn about and shift along an axis."""
    c, s = sympy.cos(angle), sympy.sin(angle)
    if axis == 'z':
        rows = [[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, shift], [0, 0, 0, 1]]
    else:
        rows = [[1, 0, 0, shift], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]]
    return np.array(rows, dtype=object)


def values(x, numbers):
    return np.vectorize(lambda e: float(sympy.sympify(e).subs(numbers)))(x)


def test_puma_from_symbolic_rows_is_the_puma_of_the_model_file():
    mm = sympy.Rational(1, 1000)
    half = sympy.pi / 2
    rows = [DHJoint(alpha=-half), DHJoint(d=sympy.Rational('144.09') * mm, a=0.4318),
            DHJoint(a=-0.02032, alpha=half), DHJoint(d=0.43307, alpha=-half),
            DHJoint(alpha=half), DHJoint(d=0.05625)]
    ours, file = symbolic.dh_chain(rows), symbolic.exact_chain(robots.robot('puma560'))
    for mine, other in zip(ours.joints, file.joints):
        assert list(mine.axis) == list(other.axis)
        line = [se3.cross(j.point, j.axis) for j in (mine, other)]
        assert list(line[0]) == list(line[1])
    assert np.array_equal(ours.T_base_tool, file.T_base_tool)


@pytest.mark.parametrize('name', ['puma560', 'panda'])
def test_formulas_of_robots_are_exact_and_give_the_numbers_of_the_chain(name):
    chain = robots.robot(name)
    motion = robots.random_motion(3, chain.dof, order=2)
    state = symbolic.symbolic_state(chain, simplified=False)
    assert not floats_in(state.pose, *state.reduced)
    symbols = np.concatenate(symbolic.joint_symbols(chain.dof, 2))
    function = sympy.lambdify(list(symbols), [*state.velocity, *state.reduced_acceleration],
                              cse=True)
    expected = chain.state(*motion)
    np.testing.assert_allclose(
        function(*np.concatenate(motion)), [*expected.velocity, *expected.reduced_acceleration],
        rtol=0, atol=1e-12 * np.abs(expected.reduced_acceleration).max())


def test_simplified_formulas_of_the_puma_gather_parallel_axes():
    state = symbolic.symbolic_state(robots.robot('puma560'), 1)
    q, qd = symbolic.joint_symbols(6, 1)
    assert state.velocity[2] == (
        qd[0] + qd[3] * sympy.cos(q[1] + q[2])
        + qd[4] * sympy.sin(q[3]) * sympy.sin(q[1] + q[2])
        + qd[5] * (sympy.cos(q[4]) * sympy.cos(q[1] + q[2])
                   - sympy.sin(q[4]) * sympy.sin(q[1] + q[2]) * sympy.cos(q[3])))


def test_helical_and_mimic_joints_stay_exact():
    h = sympy.Symbol('h')
    chain = SerialChain([
        Joint('q1', 'helical', axis=(0, 0, 1), pitch=h),
        Joint('q2', 'revolute', axis=(1, 0, 1), point=(0.1, 0, 0), mimic=Mimic('q1', -2, 0.5))])
    state = symbolic.symbolic_state(chain, 2)
    assert not floats_in(state.pose, *state.reduced)
    values = {h: 0.2, **dict(zip(np.ravel(symbolic.joint_symbols(1)), (0.3, 0.7, -1.1)))}
    numeric = SerialChain([
        Joint('q1', 'helical', axis=(0, 0, 1), pitch=0.2), chain.joints[1]])
    expected = numeric.state([0.3], [0.7], [-1.1])
    np.testing.assert_allclose([float(e.subs(values)) for e in state.reduced_acceleration],
                               expected.reduced_acceleration, rtol=0, atol=1e-14)


def test_directions_are_recognised_and_lengths_are_decimals():
    third = 1 / np.sqrt(3)
    chain = SerialChain([Joint('q', 'helical', axis=(third, -third, third),
                               point=(0.1 + 0.2, 1 / 3, -0.0825), pitch=0.1)])
    joint = symbolic.exact_chain(chain).joints[0]
    root, number = sympy.sqrt(3) / 3, sympy.Rational
    assert list(joint.axis) == [root, -root, root]
    assert list(joint.point) == [number(3, 10), number('0.333333333333'), number('-0.0825')]
    assert joint.pitch == number(1, 10)


def test_integers_and_default_pose_stay_exact_without_being_made_so():
    zero, one = sympy.Integer(0), sympy.Integer(1)
    chain = SerialChain([Joint('q1', 'revolute', axis=np.array([zero, zero, one]),
                               point=np.array([A, zero, zero]))])
    assert not any(e.has(sympy.Float) for e in map(sympy.sympify, chain.pose([Q1]).ravel()))
    assert chain.pose([sympy.pi / 2])[0, 3] == A


def test_wrong_rows_are_refused():
    with pytest.raises(UnknownNameError, match="unknown DH convention 'craig'; known: 'standa"):
        symbolic.dh_chain([DHJoint()], 'craig')
    with pytest.raises(InvalidValueError, match="joint q2: kind must be 'revolute' or"):
        symbolic.dh_chain([DHJoint(), DHJoint(kind='helical')])
    for row in (DHJoint(a='x'), DHJoint(alpha='x')):
        with pytest.raises(InvalidValueError, match="'x' is neither a number nor an expression"):
            symbolic.dh_chain([row])


@pytest.mark.parametrize('module', ['symbolic', 'symbolic.printing', 'symbolic.exact'])
def test_without_sympy_the_extra_is_named(module):
    code = ("import sys; sys.modules['sympy'] = None\n"
            f'import screw_kinematics.{module}')
    run = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)
    assert "pip install 'screw_kinematics[symbolic]'" in run.stderr
