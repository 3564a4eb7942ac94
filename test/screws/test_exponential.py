# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
from hypothesis import example, given, settings, strategies as st
import mpmath
import numpy as np
import pytest

from screw_kinematics.errors import InvalidValueError, ShapeError
from screw_kinematics.screws import se3

ANGLES = [0.0, 5e-324, 1e-300, 1e-160, 1e-12, 1e-8, 1e-4, 0.499999, 0.5, 1.0, 3.0,
          np.pi - 1e-4, np.pi - 1e-8, np.pi - 1e-12, np.pi]


def twists(angle, count=200):
    rng = np.random.default_rng(1)
    axis = rng.normal(size=(count, 3))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    return np.concatenate([angle * axis, rng.normal(size=(count, 3))], axis=-1)


@pytest.mark.parametrize('angle', ANGLES)
def test_exp_undoes_log_at_every_angle(angle):
    T = se3.exp(twists(angle))
    np.testing.assert_allclose(se3.exp(se3.log(T)), T, rtol=0, atol=1e-13)


@pytest.mark.parametrize('angle', ANGLES[:-1])
def test_log_undoes_exp_below_pi(angle):
    x = twists(angle)
    np.testing.assert_allclose(se3.log(se3.exp(x)), x, rtol=0, atol=1e-13)


def test_half_turns_about_the_coordinate_axes_are_exact():
    for axis in np.eye(3):
        T = np.eye(4)
        T[:3, :3] = 2 * np.outer(axis, axis) - np.eye(3)
        np.testing.assert_allclose(np.abs(se3.log(T)[:3]), np.pi * axis, rtol=1e-15)


@pytest.mark.parametrize('angle', [0.0, 1e-7, 0.3, 0.5, 2.0, 3.1, 20.0])
def test_exp_is_the_matrix_exponential(angle):
    x = twists(angle, count=1)[0]
    matrix = np.zeros((4, 4))
    matrix[:3, :3], matrix[:3, 3] = se3.skew(x[:3]), x[3:]
    with mpmath.workdps(40):
        expected = np.array(mpmath.expm(mpmath.matrix(matrix.tolist())).tolist(), dtype=float)
    np.testing.assert_allclose(se3.exp(x), expected, rtol=0, atol=1e-14 * max(1, angle))


@settings(max_examples=200, deadline=None, derandomize=True)
@example(parts=[0.0, 0.0, 1.0, 6.7e-70, 0.0, 0.0], angle=1.0, exponent=-243)
@given(st.lists(st.floats(-1, 1), min_size=6, max_size=6), st.floats(0, np.pi),
       st.integers(-300, 200))
def test_exp_undoes_log_for_any_axis_and_any_unit_of_length(parts, angle, exponent):
    x = np.array(parts)
    size = np.linalg.norm(x[:3])
    if size > 1e-100:       # below, the direction itself would not survive the division
        x[:3] *= angle / size
    T = se3.exp(x * np.repeat([1.0, 10.0 ** exponent], 3))
    back = se3.exp(se3.log(T))
    np.testing.assert_allclose(back[:3, :3], T[:3, :3], rtol=0, atol=1e-13)
    p = T[:3, 3]
    # The smallest numbers of all, below 1e-308, have fewer digits.
    np.testing.assert_allclose(back[:3, 3], p, rtol=0, atol=1e-12 * np.abs(p).max() + 1e-322)


def test_wrong_arguments_are_refused():
    with pytest.raises(ShapeError, match=r'x: expected shape \(\.\.\., 6\), got \(5,\)'):
        se3.exp(np.zeros(5))
    with pytest.raises(ShapeError, match=r'T: expected shape \(\.\.\., 4, 4\)'):
        se3.log(np.eye(3))
    with pytest.raises(InvalidValueError, match='x must be finite'):
        se3.exp(np.array([0, 0, np.nan, 0, 0, 0]))
