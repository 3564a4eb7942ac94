# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
import warnings

from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

from screw_kinematics import screws
from screw_kinematics.errors import InvalidValueError, ShapeError
from screw_kinematics.screws import se3

PITCHES = [-2.0, -1e-3, 0.0, 0.5, np.inf]
SIZES = [1e-300, 1e-150, 1e-20, 1.0, 1e20, 1e150, 1e200]


def unit(rng, shape=()):
    axis = rng.normal(size=(*shape, 3))
    return axis / np.linalg.norm(axis, axis=-1, keepdims=True)


@pytest.mark.parametrize('pitch', PITCHES)
def test_points_of_the_axis_move_along_it_by_the_pitch(pitch):
    rng = np.random.default_rng(1)
    axis, point = unit(rng), rng.normal(size=3)
    at_axis = se3.shift_pole(screws.unit_screw(axis, point, pitch), point)
    expected = axis if np.isinf(pitch) else pitch * axis
    np.testing.assert_allclose(at_axis[3:], expected, atol=1e-15)
    np.testing.assert_array_equal(at_axis[:3], 0 * axis if np.isinf(pitch) else axis)


def test_pitches_broadcast_and_may_mix_finite_and_infinite():
    rng = np.random.default_rng(1)
    axis, point = unit(rng), rng.normal(size=3)
    batch = screws.unit_screw(axis, point, np.array(PITCHES))
    for row, pitch in zip(batch, PITCHES):
        np.testing.assert_array_equal(row, screws.unit_screw(axis, point, pitch))
    np.testing.assert_array_equal(batch[-1], screws.prismatic_screw(axis))


@pytest.mark.parametrize('pitch', PITCHES)
@pytest.mark.parametrize('size', SIZES)
def test_twist_and_screw_are_the_same_at_any_size(pitch, size):
    rng = np.random.default_rng(2)
    axis, point = unit(rng, (20,)), rng.normal(size=(20, 3))
    unit_screw = screws.unit_screw(axis, point, pitch)
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        screw = screws.screw_of_twist(size * unit_screw)
        np.testing.assert_allclose(screw.twist / size, unit_screw, rtol=0, atol=1e-13)
    np.testing.assert_allclose(screw.amplitude, size, rtol=1e-14)
    np.testing.assert_allclose(screw.axis, axis, atol=1e-15)
    np.testing.assert_allclose(screw.pitch, pitch, rtol=1e-11, atol=1e-13)
    kind = 'translation' if np.isinf(pitch) else 'rotation' if pitch == 0 else 'helical'
    assert set(screw.kind) == {kind}
    if kind != 'translation':
        foot = point - se3.dot(point, axis)[:, None] * axis
        np.testing.assert_allclose(screw.point, foot, atol=1e-13)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(st.lists(st.sampled_from([0.0, 1.0, -1.0, 3e-7]), min_size=6, max_size=6),
       st.integers(-305, 200), st.integers(-305, 200))
def test_any_two_sizes_of_the_parts_give_finite_numbers(signs, angular, linear):
    """Whatever the ratio of |w| and |v|: no NaN, no warning, and the twist comes back."""
    twist = np.array(signs) * np.repeat([10.0 ** angular, 10.0 ** linear], 3)
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        screw = screws.screw_of_twist(twist)
        back = screw.twist
    for part in (screw.axis, screw.point, screw.amplitude, back):
        assert np.all(np.isfinite(part))
    assert not np.isnan(screw.pitch) and screw.amplitude >= 0
    scale = np.abs(twist).max()
    if scale > 1e-290:      # below, the pieces themselves lose digits as subnormals
        np.testing.assert_allclose(back / scale, twist / scale, rtol=0, atol=1e-11)


def test_rest_is_no_exception():
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        screw = screws.screw_of_twist(np.zeros((2, 6)))
    assert set(screw.kind) == {'rest'}
    for value in (screw.axis, screw.point, screw.pitch, screw.amplitude, screw.twist):
        np.testing.assert_array_equal(value, 0)


def test_counter_rotation_about_parallel_axes_is_a_translation():
    there = screws.unit_screw(np.array([0, 0.6, 0.8]), np.array([1.0, 2, 3]))
    back = screws.unit_screw(np.array([0, 0.6, 0.8]), np.array([-0.1, 0.3, 0.2]))
    assert screws.screw_of_twist(0.3 * there - 0.1 * back - 0.2 * back).kind == 'translation'


@pytest.mark.parametrize('h1', PITCHES[:-1])
@pytest.mark.parametrize('h2', PITCHES[:-1])
def test_klein_form_of_two_unit_screws(h1, h2):
    """{$1; $2} = (h1 + h2) cos t - d sin t, t and d measured along the perpendicular."""
    rng = np.random.default_rng(3)
    for angle, gap in rng.normal(size=(10, 2)):
        s1, s2 = np.array([1.0, 0, 0]), np.array([np.cos(angle), np.sin(angle), 0])
        x = screws.unit_screw(s1, np.zeros(3), h1)
        y = screws.unit_screw(s2, np.array([0, 0, gap]), h2)
        carry = se3.adjoint(se3.exp(rng.normal(size=6)))
        expected = (h1 + h2) * np.cos(angle) - gap * np.sin(angle)
        assert se3.klein_form(carry @ x, carry @ y) == pytest.approx(expected, abs=1e-12)


def test_chasles():
    rng = np.random.default_rng(4)
    axis, point = unit(rng), rng.normal(size=3)
    T = se3.exp(1.2 * screws.unit_screw(axis, point, 0.3))
    screw = screws.screw_of_displacement(T)
    assert float(screw.amplitude) == pytest.approx(1.2, rel=1e-13)
    assert float(screw.pitch) == pytest.approx(0.3, rel=1e-12)
    on_axis = np.append(screw.point, 1)
    np.testing.assert_allclose((T @ on_axis - on_axis)[:3], 1.2 * 0.3 * axis, atol=1e-13)


@pytest.mark.parametrize('count', [0, 1, 3, 5, 6])
@pytest.mark.parametrize('length', [1.0, 1000.0])
def test_reciprocal_screws_do_no_work_and_complete_the_space(count, length):
    given_screws = np.random.default_rng(5).normal(size=(count, 6))
    given_screws[:, 3:] *= length
    found = screws.reciprocal_screws(given_screws, length)
    assert found.shape == (6 - count, 6)
    for x in found:
        assert np.all(screws.are_reciprocal(given_screws, x, tolerance=1e-10))
        assert screws.screw_of_twist(x).amplitude == pytest.approx(1)
    assert not screws.are_reciprocal(*np.random.default_rng(6).normal(size=(2, 6)))


def test_reciprocal_screws_of_a_planar_arm():
    """What a planar arm cannot do: the couples in the plane and the force across it."""
    z = np.array([0, 0, 1])
    arm = [screws.unit_screw(z, np.array(p)) for p in ((0, 0, 0), (1, 0, 0), (1, 2, 0))]
    found = screws.reciprocal_screws(np.array(arm))
    blocked = np.array([[0, 0, 1, 0, 0, 0], [0, 0, 0, 1, 0, 0], [0, 0, 0, 0, 1, 0]])
    assert np.linalg.matrix_rank(np.vstack([found, blocked]), tol=1e-9) == 3


def test_wrong_arguments_are_refused():
    with pytest.raises(ShapeError, match=r'twist: expected shape \(\.\.\., 6\)'):
        screws.screw_of_twist(np.zeros(3))
    with pytest.raises(InvalidValueError, match='twist must be finite'):
        screws.screw_of_twist(np.full(6, np.inf))
    with pytest.raises(ShapeError, match=r'screws: expected shape \(N, 6\), got \(6,\)'):
        screws.reciprocal_screws(np.zeros(6))
