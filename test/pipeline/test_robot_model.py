# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Which measured joints may wrap at 2 pi, also where others follow them."""
import pytest

from screw_kinematics import Joint, Mimic, SerialChain
from screw_kinematics.pipeline.robot_model import continuous_joints

Z = (0, 0, 1)


@pytest.mark.parametrize('joints, expected', [
    ([Joint('a', 'continuous', Z), Joint('b', 'revolute', Z)], [True, False]),
    ([Joint('a', 'continuous', Z), Joint('b', 'revolute', Z, mimic=Mimic('a'))], [True]),
    ([Joint('b', 'continuous', Z, mimic=Mimic('a')), Joint('a', 'revolute', Z)], [False]),
    ([Joint('b', 'continuous', Z, mimic=Mimic('elsewhere'))], [True])])
def test_a_measured_joint_wraps_by_its_own_kind(joints, expected):
    assert list(continuous_joints(SerialChain(joints))) == expected
