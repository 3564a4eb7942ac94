# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from screw_kinematics.errors import InvalidValueError, ShapeError
from screw_kinematics.screws import lines, se3


def points(count, shape=(), seed=1):
    return np.random.default_rng(seed).normal(size=(count, *shape, 3))


@pytest.mark.parametrize('shape', [(), (7,)])
def test_every_point_of_a_line_gives_the_same_moment(shape):
    p, d, a = points(3, shape)
    x = lines.line(p, d)
    np.testing.assert_allclose(lines.line(p + 3 * d, d), x, rtol=1e-11, atol=1e-13)
    np.testing.assert_allclose(lines.line_through(p, p + d), x, rtol=1e-11, atol=1e-13)
    np.testing.assert_allclose(lines.moment_about(x, p), 0, atol=1e-14)
    np.testing.assert_allclose(lines.moment_about(x, a), np.cross(p - a, d), atol=1e-13)


@pytest.mark.parametrize('shape', [(), (7,)])
def test_nearest_point_is_on_the_line_and_below_the_point(shape):
    p, d, a = points(3, shape)
    x = lines.line(p, d)
    foot = lines.nearest_point(x, a)
    np.testing.assert_allclose(lines.moment_about(x, foot), 0, atol=1e-13)
    np.testing.assert_allclose(se3.dot(foot - a, d), 0, atol=1e-13)


@pytest.mark.parametrize('angle', [1e-6, 0.3, np.pi / 2, 3.0, np.pi - 1e-6])
@pytest.mark.parametrize('gap', [0.0, 0.7])
def test_distance_angle_and_reciprocal_product(angle, gap):
    """Two lines with a given common perpendicular, moved anywhere."""
    x = lines.line(np.zeros(3), np.array([2.0, 0, 0]))
    y = lines.line(np.array([0, 0, gap]), 3 * np.array([np.cos(angle), np.sin(angle), 0]))
    assert se3.klein_form(x, y) == pytest.approx(-gap * 6 * np.sin(angle), abs=1e-15)
    x, y = (se3.adjoint(se3.exp(np.arange(6) / 3)) @ z for z in (x, y))
    assert lines.angle(x, y) == pytest.approx(angle, abs=1e-12)
    assert lines.distance(x, y) == pytest.approx(gap, abs=1e-9)
    assert lines.distance(y, x) == pytest.approx(gap, abs=1e-9)


@pytest.mark.parametrize('sense', [1.0, -2.0])
def test_distance_of_parallel_lines(sense):
    p, d, a = points(3)
    across = np.cross(d, a)
    across *= 0.4 / np.linalg.norm(across)
    y = lines.line(p + across + 5 * d, sense * d)
    assert lines.distance(lines.line(p, d), y) == pytest.approx(0.4, rel=1e-12)


def test_mutual_positions():
    p, d, a = points(3)
    x = lines.line(p, d)
    assert lines.mutual_position(x, lines.line(p + 2 * d, -3 * d)) == 'identical'
    assert lines.mutual_position(x, lines.line(p + np.cross(d, a), d)) == 'parallel'
    assert lines.mutual_position(x, lines.line_through(p + d, a)) == 'intersecting'
    assert lines.mutual_position(x, lines.line(a, np.cross(d, a))) == 'skew'


def test_distance_broadcasts():
    p, d = points(2, (4, 1))
    e, f = points(2, (3,), seed=2)
    assert lines.distance(lines.line(p, d), lines.line(e, f)).shape == (4, 3)


def test_what_is_no_line_is_refused():
    x = lines.line(*points(2))
    with pytest.raises(InvalidValueError, match='direction must be finite and not zero'):
        lines.angle(x, np.array([0, 0, 0, 1, 0, 0]))
    with pytest.raises(InvalidValueError, match='must be perpendicular'):
        lines.distance(x, np.array([0, 0, 1, 0, 0, 1]))
    with pytest.raises(InvalidValueError, match='direction must not be zero'):
        lines.line(x[:3], np.zeros(3))
    with pytest.raises(InvalidValueError, match='q - p must not be zero'):
        lines.line_through(x[:3], x[:3])
    with pytest.raises(ShapeError, match=r'line: expected shape \(\.\.\., 6\), got \(5,\)'):
        lines.nearest_point(np.ones(5))
    with pytest.raises(ShapeError, match=r'line y: expected shape \(6,\)'):
        lines.mutual_position(x, np.stack([x, x]))


@pytest.mark.parametrize('shape', [(), (5,)])
def test_common_perpendicular_is_perpendicular_and_as_long_as_the_distance(shape):
    x, y = (lines.line(*points(2, shape, seed=k)) for k in (3, 4))
    on_x, on_y = lines.common_perpendicular(x, y)
    for foot, line in ((on_x, x), (on_y, y)):
        np.testing.assert_allclose(lines.moment_about(line, foot), 0, atol=1e-12)
        np.testing.assert_allclose(se3.dot(on_y - on_x, line[..., :3]), 0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(on_y - on_x, axis=-1), lines.distance(x, y),
                               rtol=1e-10)


def test_common_perpendicular_of_parallel_and_meeting_lines():
    x = lines.line(np.array([0, 1, 5]), np.array([0, 0, 1]))
    on_x, on_y = lines.common_perpendicular(x, lines.line(np.array([3, 1, 2]), -x[:3]))
    np.testing.assert_allclose([on_x, on_y], [[0, 1, 0], [3, 1, 0]], atol=1e-15)
    feet = lines.common_perpendicular(x, lines.line(np.array([4, 1, 7]), np.array([1, 0, 0])))
    np.testing.assert_allclose(feet, [[0, 1, 7]] * 2, atol=1e-15)
