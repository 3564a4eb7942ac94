# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The paper's examples, in their right form.

The planar RPR manipulator in closed form is in ``test/symbolic``. Numbers of the PUMA
robot at t = 0 were found by exact differentiation of the product of its DH matrices.
"""
import numpy as np
import pytest

from screw_kinematics import InverseSolver
from screw_kinematics.errors import SingularityError
from screw_kinematics.screws import se3
from support import exact, robots

PUMA = robots.robot('puma560')
AMPLITUDES = np.array([0.2, 0.15, 0.25, 0.25, 0.15, 0.3])


def puma_motion(t):
    """Return q_i = 10 deg + A_i sin t and its derivatives to order 4."""
    s, c = np.sin(t)[..., None], np.cos(t)[..., None]
    return (np.radians(10) + AMPLITUDES * s, AMPLITUDES * c, -AMPLITUDES * s,
            -AMPLITUDES * c, AMPLITUDES * s)


def test_puma_at_time_zero():
    state = PUMA.state(*puma_motion(np.array(0.0)))
    np.testing.assert_allclose(state.pose[:3, 3],
                               np.array([548.088474, 244.677917, 387.685932]) * 1e-3,
                               rtol=0, atol=1e-9)
    np.testing.assert_allclose(state.velocity[:3], [.110409, .584824, .703910], rtol=0, atol=6e-7)
    np.testing.assert_allclose(state.velocity[3:] * 1e3,
                               [128.262094, 144.769510, -130.620410], rtol=0, atol=1e-6)
    np.testing.assert_allclose(state.classical(2)[3:] * 1e3,
                               [-75.851720, 58.070508, -78.416507], rtol=0, atol=1e-6)
    np.testing.assert_allclose(state.reduced_acceleration[3:] * 1e3,
                               [102.442998, -46.636100, -19.389517], rtol=0, atol=1e-6)


@pytest.mark.parametrize('t', np.linspace(0, 2 * np.pi, 7))
def test_puma_over_its_period(t):
    motion = puma_motion(t)
    state, expected = PUMA.state(*motion), exact.tip_motion(PUMA, *motion)
    for n in range(1, 5):
        np.testing.assert_allclose(state.classical(n), expected.classical[n - 1], rtol=0,
                                   atol=1e-11 * np.abs(expected.classical[n - 1]).max())


@pytest.mark.parametrize('q5', [0.0, 1e-9, 0.4])
def test_puma_fifth_screw_is_defined_everywhere(q5):
    """4$5 turns about z4, also at q5 = 0, where the printed quotient is 0 / 0."""
    q = np.array([0.1, 0.2, 0.3, 0.4, q5, 0.6])
    origins, axes = frames_of_puma(q)
    screw = PUMA.screws(q, pole='base')[4]
    np.testing.assert_allclose(screw[:3], axes[4], rtol=0, atol=1e-12)
    np.testing.assert_allclose(screw[3:], np.cross(origins[4], axes[4]), rtol=0, atol=1e-12)


def test_the_printed_fifth_screw_has_the_wrong_sign():
    """(O6 - O4) x (O4 - O3) = - d4 d6 sin(q5) z4, so that all of the example is off."""
    for t in np.linspace(0, 2 * np.pi, 9):
        q, qd = puma_motion(t)[:2]
        origins, axes = frames_of_puma(q)
        printed = np.cross(origins[6] - origins[4], origins[4] - origins[3])
        np.testing.assert_allclose(
            printed, -0.43307 * 0.05625 * np.sin(q[4]) * axes[4], rtol=0, atol=1e-15)
    q, qd = puma_motion(0.0)[:2]
    screws = PUMA.screws(q)
    np.testing.assert_allclose(qd @ screws[:, :3], [.110, .585, .704], rtol=0, atol=5e-4)
    screws[4] *= -1
    np.testing.assert_allclose(qd @ screws[:, :3], [.210, .302, .686], rtol=0, atol=5e-4)


def frames_of_puma(q):
    """Return origins and z axes of the Denavit-Hartenberg frames 0 to 6."""
    rows = [(0, 0, -1), (144.09, 431.8, 0), (0, -20.32, 1), (433.07, 0, -1), (0, 0, 1),
            (56.25, 0, 0)]
    T, frames = np.eye(4), [np.eye(4)]
    for (d, a, alpha), theta in zip(rows, q):
        x, z = np.zeros((2, 6))
        z[[2, 5]] = theta, d / 1000
        x[[0, 3]] = alpha * np.pi / 2, a / 1000
        T = T @ se3.exp(z) @ se3.exp(x)
        frames.append(T)
    return [T[:3, 3] for T in frames], [T[:3, 2] for T in frames]


def test_the_damped_inverse_of_the_example_and_the_exact_one():
    """In 4.2.4 q5 falls to 1.4 degrees: damping costs 6e-4 rad/s there, and is reported."""
    q, qd = puma_motion(np.linspace(0, 2 * np.pi, 2001))[:2]
    assert np.degrees(q[:, 4].min()) == pytest.approx(1.4, abs=0.01)
    twist = PUMA.state(q, qd).velocity
    damped = PUMA.inverse_velocity(q, twist)
    exact_one = PUMA.inverse_velocity(q, twist, solver=InverseSolver(exact=True))
    assert np.abs(damped.rates - qd).max() == pytest.approx(6.3e-4, rel=0.02)
    assert damped.damping.max() > 0 and np.all(exact_one.damping == 0)
    np.testing.assert_allclose(exact_one.rates, qd, rtol=0, atol=1e-13)


def test_puma_wrist_singularity_is_named():
    """At q5 = 0 axes 4 and 6 coincide: the blocked wrench is found and is reciprocal."""
    q = np.radians([10, 20, 30, 40, 0, 50])
    with pytest.raises(SingularityError, match='rank 5 .* reciprocal screw') as caught:
        PUMA.inverse_velocity(q, np.arange(1, 7), solver=InverseSolver(exact=True))
    np.testing.assert_allclose(se3.klein_form(caught.value.screw, PUMA.screws(q)), 0,
                               atol=1e-12)
