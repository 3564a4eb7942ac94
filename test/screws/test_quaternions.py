# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Quaternions give back the rotation they were made from."""
import numpy as np
import pytest
from screw_kinematics.screws.orientation import rotation_from_quaternion
from screw_kinematics.screws.quaternions import quaternion_from_rotation
from screw_kinematics.screws.se3 import rotation_about


@pytest.mark.parametrize('angle', [0.0, 1e-9, 0.3, 2.0, np.pi - 1e-7, np.pi, -2.5])
@pytest.mark.parametrize('seed', range(4))
def test_there_and_back(angle, seed):
    axis = np.random.default_rng(seed).normal(size=3)
    if seed < 3:
        axis = np.eye(3)[seed]
    rotation = rotation_about(axis / np.linalg.norm(axis), angle)
    quaternion = np.array(quaternion_from_rotation(rotation.ravel().tolist()))
    assert np.isclose(np.linalg.norm(quaternion), 1.0, rtol=1e-14) and quaternion[3] >= 0
    assert np.allclose(rotation_from_quaternion(quaternion), rotation, rtol=0, atol=1e-14)
