# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Rotations and poses: every form gives back the rotation it was made from."""
import numpy as np
import pytest
from screw_kinematics.screws import rotations, se3


def some_rotation(seed, angle):
    axis = np.random.default_rng(seed).normal(size=3) if seed >= 3 else np.eye(3)[seed]
    axis = axis / np.linalg.norm(axis)
    return axis, rotations.rotation_about(axis, angle)


ANGLES = [0.0, 1e-9, 0.3, 2.0, np.pi - 1e-7, np.pi, -2.5]


@pytest.mark.parametrize('angle', ANGLES)
@pytest.mark.parametrize('seed', range(4))
def test_quaternions_there_and_back(angle, seed):
    _, rotation = some_rotation(seed, angle)
    quaternion = rotations.quaternion_from_rotation(rotation)
    assert np.isclose(np.linalg.norm(quaternion), 1.0, rtol=1e-14) and quaternion[3] >= 0
    np.testing.assert_allclose(
        rotations.rotation_from_quaternion(quaternion), rotation, rtol=0, atol=1e-14)
    row = rotations.quaternion_from_row(rotation.ravel().tolist())
    sign = 1.0 if np.dot(row, quaternion) > 0 else -1.0     # at half a turn both are right
    np.testing.assert_allclose(sign * np.array(row), quaternion, rtol=0, atol=1e-15)


@pytest.mark.parametrize('seed', range(4))
def test_batches_are_what_their_rotations_are(seed):
    batch = np.array([some_rotation(seed + k, angle)[1] for k, angle in enumerate(ANGLES)])
    for function in (rotations.quaternion_from_rotation, rotations.rotation_vector,
                     rotations.roll_pitch_yaw):
        np.testing.assert_array_equal(function(batch), [function(R) for R in batch])


@pytest.mark.parametrize('length', [1e-3, 1.0, 50.0])
def test_quaternions_of_any_length_are_rotations(length):
    _, rotation = some_rotation(3, 2.0)
    quaternion = length * rotations.quaternion_from_rotation(rotation)
    np.testing.assert_allclose(
        rotations.rotation_from_quaternion(quaternion), rotation, rtol=0, atol=1e-14)


@pytest.mark.parametrize('angle', [0.0, 1e-9, 0.3, 2.0, np.pi - 1e-7])
@pytest.mark.parametrize('seed', range(4))
def test_the_rotation_vector_is_axis_times_angle(angle, seed):
    axis, rotation = some_rotation(seed, angle)
    np.testing.assert_allclose(
        rotations.rotation_vector(rotation), angle * axis, rtol=0, atol=1e-14)


@pytest.mark.parametrize('angles', [(0.3, -1.2, 2.9), (-3.0, 1.5, 0.1)])
def test_roll_pitch_yaw_there_and_back(angles):
    np.testing.assert_allclose(
        rotations.roll_pitch_yaw(rotations.rotation_rpy(*angles)), angles, rtol=1e-14)


@pytest.mark.parametrize('angle', [0.0, 1e-9, 1.0, np.pi, 7.0])
def test_rotation_about_is_the_exponential_of_a_pure_rotation(angle):
    axis = np.array([2.0, -1, 2]) / 3
    expected = se3.exp(np.concatenate([angle * axis, np.zeros(3)]))[:3, :3]
    np.testing.assert_allclose(rotations.rotation_about(axis, angle), expected, atol=1e-14)


@pytest.mark.parametrize('shape', [(), (5,), (2, 3)])
def test_poses_are_made_of_rotations_and_translations(shape):
    T = se3.exp(np.random.default_rng(0).normal(size=(*shape, 6)))
    np.testing.assert_array_equal(rotations.pose(T[..., :3, :3], T[..., :3, 3]), T)
