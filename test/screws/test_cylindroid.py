# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The pencil of two screws, and the theorem of the three axes."""
import numpy as np
import pytest

from screw_kinematics.errors import InvalidValueError
from screw_kinematics.screws import (
    cylindroid, lines, screw_of_twist, se3, third_axis, unit_screw)


def screws(seed):
    """Return two random screws of any pitch, as twists of any amplitude."""
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(2, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    return rng.normal(size=(2, 1)) * unit_screw(axes, rng.normal(size=(2, 3)), rng.normal(size=2))


@pytest.mark.parametrize('seed', range(6))
def test_principal_screws_meet_at_right_angles_and_are_reciprocal(seed):
    found = cylindroid(*screws(seed))
    first, second = found.principal
    assert se3.killing_form(first, second) == pytest.approx(0, abs=1e-12)
    assert se3.klein_form(first, second) == pytest.approx(0, abs=1e-11)
    for screw, pitch in zip(found.principal, found.pitches):
        one = screw_of_twist(screw)
        assert one.pitch == pytest.approx(pitch, abs=1e-11)
        assert one.amplitude == pytest.approx(1)
        line = lines.line(one.point, one.axis)
        np.testing.assert_allclose(lines.moment_about(line, found.centre), 0, atol=1e-10)
    assert found.length == pytest.approx(found.pitches[1] - found.pitches[0])


@pytest.mark.parametrize('seed', range(6))
def test_every_combination_lies_on_the_cylindroid(seed):
    """Pluecker's conoid: pitch and place of an axis follow from its direction alone."""
    x, y = screws(seed)
    found = cylindroid(x, y)
    for ratio in np.random.default_rng(seed).normal(size=5):
        one = screw_of_twist(x + ratio * y)
        c, s = found.principal[:, :3] @ one.axis
        assert c * c + s * s == pytest.approx(1)        # across the cylindroid's axis
        h1, h2 = found.pitches
        assert one.pitch == pytest.approx(h1 * c * c + h2 * s * s, abs=1e-10)
        foot = lines.nearest_point(lines.line(one.point, one.axis), found.centre)
        np.testing.assert_allclose(foot - found.centre, (h2 - h1) * s * c * found.axis,
                                   atol=1e-9)
        np.testing.assert_allclose(
            found.screw_at(np.arctan2(s, c)), (x + ratio * y) / one.amplitude, atol=1e-10)


@pytest.mark.parametrize('seed', range(6))
def test_the_third_axis_cuts_the_common_perpendicular_at_a_right_angle(seed):
    x, y = screws(seed)
    one, two, three = screw_of_twist(x), screw_of_twist(y), third_axis(x, y)
    feet = lines.common_perpendicular(*(lines.line(s.point, s.axis) for s in (one, two)))
    perpendicular = lines.line_through(*feet)
    line = lines.line(three.point, three.axis)
    assert lines.distance(line, perpendicular) == pytest.approx(0, abs=1e-10)
    assert lines.angle(line, perpendicular) == pytest.approx(np.pi / 2)


def test_three_centres_of_a_plane_are_on_one_line():
    """Kennedy's theorem: turns about z."""
    rng = np.random.default_rng(7)
    points = np.column_stack([rng.normal(size=(2, 2)), np.zeros(2)])
    x, y = (w * unit_screw(np.array([0, 0, 1.0]), p) for w, p in zip((1.3, -0.4), points))
    a, b = points - third_axis(x, y).point
    assert np.cross(a, b)[2] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize('x, y', [
    ([0, 0, 1, 0, 0, 0], [0, 0, 2, 0, 1, 0]), ([0, 0, 1, 0, 0, 0], [0, 0, 0, 1, 0, 0])])
def test_no_cylindroid_of_parallel_or_infinite_screws(x, y):
    with pytest.raises(InvalidValueError, match='whose axes are not parallel'):
        cylindroid(x, y)
