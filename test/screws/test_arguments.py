# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Six-vectors, points and poses of a wrong kind are refused by name, never computed with."""
import numpy as np
import pytest

from screw_kinematics import screws
from screw_kinematics.errors import InvalidValueError, ShapeError
from screw_kinematics.screws import lines, rigid, rotations, se3, states

sympy = pytest.importorskip('sympy')
X, Y = np.random.default_rng(1).normal(size=(2, 6))
OF_TWO = [se3.lie_product, se3.klein_form, se3.killing_form, screws.are_reciprocal]
MIRROR, SCALED = np.diag([1.0, 1, -1, 1]), 2 * np.eye(4)
LAST_ROW = np.eye(4)
LAST_ROW[3, 3] = 2
OF_POSES = [se3.log, screws.screw_of_displacement, se3.adjoint, se3.coadjoint, se3.inverse,
            lambda T: screws.BodyState.at_rest(T, 1), lambda T: screws.BodyState(T, (), X[:3]),
            lambda T: screws.BodyState.at_rest(np.eye(4), 1).with_tool(T)]


@pytest.mark.parametrize('function', OF_TWO)
@pytest.mark.parametrize('x, y', [(X[:, None], Y[:, None]), (X, Y[:5]), (np.ones(7), np.ones(7))])
def test_columns_and_other_lengths_are_refused(function, x, y):
    with pytest.raises(ShapeError, match=r'[xy]: expected shape \(\.\.\., 6\), got'):
        function(x, y)


@pytest.mark.parametrize('function', OF_TWO[:3])
def test_sympy_columns_are_six_vectors(function):
    found = function(sympy.Matrix(X), sympy.Matrix(Y))
    np.testing.assert_allclose(np.array(found, dtype=float), function(X, Y), rtol=1e-14)


def test_sympy_columns_elsewhere():
    point, axis = sympy.Matrix([1, 2, 3]), sympy.Matrix([0, 0, 1])
    assert list(screws.unit_screw(axis, point)) == [0, 0, 1, 2, -1, 0]
    assert list(lines.line(point, axis)) == [0, 0, 1, 2, -1, 0]
    moved = se3.shift_pole(sympy.Matrix([0, 0, 1, 0, 0, 0]), sympy.Matrix([2, 0, 0]))
    assert list(moved) == [0, 0, 1, 0, 2, 0]
    (twist,) = states.chain_states([sympy.Matrix([0, 0, 1, 0, 0, 0])], [[sympy.Symbol('u')]])
    assert twist[2] == sympy.Symbol('u')


@pytest.mark.parametrize('call', [
    lambda: se3.ad(X[:5]), lambda: se3.shift_pole(X, X), lambda: se3.rotate(np.eye(4), X),
    lambda: screws.unit_screw(X, X[:3]), lambda: screws.prismatic_screw(X[:3, None]),
    lambda: lines.line(X[:2], X[:3]), lambda: lines.line_through(X[:3], X[:4]),
    lambda: lines.moment_about(X, X[:2]), lambda: states.compose([X], [X[:5]]),
    lambda: states.relative([X[:3]], [X]), lambda: states.classical_from_reduced([X[:4]]),
    lambda: screws.BodyState(np.eye(4), (X[:5],), X[:3])])
def test_shapes_are_checked(call):
    with pytest.raises(ShapeError, match='expected shape'):
        call()


@pytest.mark.parametrize('value', [['a'] * 6, [[1, 2], [3]]])
def test_what_is_no_array_of_numbers_is_refused(value):
    with pytest.raises(InvalidValueError, match='x.* must be'):
        se3.lie_product(value, Y)


@pytest.mark.parametrize('function', OF_POSES)
@pytest.mark.parametrize('T', [MIRROR, SCALED, LAST_ROW, np.stack([np.eye(4), MIRROR])])
def test_what_is_no_rigid_displacement_is_refused(function, T):
    with pytest.raises(InvalidValueError, match='no rigid displacement'):
        function(T)


@pytest.mark.parametrize('function', OF_POSES)
def test_the_stated_tolerance(function):
    """A part in a million of R^T R: poses in single precision pass."""
    T = se3.exp(X)
    function(T.astype(np.float32).astype(float))
    T[:3, :3] *= 1 + 1e-6
    with pytest.raises(InvalidValueError, match='within 1e-06'):
        function(T)


@pytest.mark.parametrize('function', [
    lambda R: se3.rotate(R, X), rotations.roll_pitch_yaw, rotations.quaternion_from_rotation,
    rotations.rotation_vector])
@pytest.mark.parametrize('R', [np.diag([1.0, 1, -1]), 2 * np.eye(3)])
def test_rotations_are_checked(function, R):
    with pytest.raises(InvalidValueError, match='rotation is no rotation'):
        function(R)


def test_rows_of_numbers_are_poses():
    T = se3.exp(np.random.default_rng(2).normal(size=(3, 6)))
    rows = rigid.row_of_pose(T)
    np.testing.assert_array_equal(rigid.pose_from_row(rows), T)
    np.testing.assert_array_equal(rows[1, :3], T[1, :3, 3])
    np.testing.assert_array_equal(rows[1, 3:6], T[1, 0, :3])
