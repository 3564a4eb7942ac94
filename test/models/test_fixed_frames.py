# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Links that are fixed to the tip are where the chains to them say."""
import numpy as np
import pytest
from screw_kinematics import models
from screw_kinematics.screws.rotations import pose, rotation_rpy
from screw_kinematics.screws.se3 import inverse

ARM = """
<robot name="arm">
  <link name="base"/><link name="upper"/><link name="flange"/><link name="sensor"/>
  <link name="tool"/><link name="finger"/><link name="odd"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <axis xyz="0 0 1"/><limit lower="-9" upper="9" effort="1" velocity="9"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="flange"/>
    <origin xyz="0.4 0 0" rpy="0 0.2 0"/><axis xyz="0 1 0"/>
    <limit lower="-9" upper="9" effort="1" velocity="9"/></joint>
  <joint name="to_sensor" type="fixed"><parent link="flange"/><child link="sensor"/>
    <origin xyz="0.01 0.02 0.05" rpy="0.3 0 1"/></joint>
  <joint name="to_tool" type="fixed"><parent link="flange"/><child link="tool"/>
    <origin xyz="0 0 0.2" rpy="0 1 0"/></joint>
  <joint name="to_finger" type="prismatic"><parent link="tool"/><child link="finger"/>
    <limit lower="-9" upper="9" effort="1" velocity="9"/></joint>
  <joint name="to_odd" type="fixed"><parent link="tool"/><child link="odd"/>
    <origin xyz="much"/></joint>
</robot>"""


@pytest.mark.parametrize('tool', [None, pose(rotation_rpy(0.1, 0.2, 0.3), [0.0, 0.1, 0.2])])
def test_links_fixed_to_the_tip(tool):
    arm = models.load_urdf(ARM, tip_frame='tool')
    if tool is not None:
        arm = arm.with_tool(tool, 'tool_tool')
    q = [0.3, -0.7]
    # Nothing that moves against the tip, and nothing of which nobody knows where it is.
    assert set(arm.fixed_frames) - {'tool_tool'} == {'flange', 'sensor', 'tool'}
    for link in ('flange', 'sensor', 'tool'):
        np.testing.assert_allclose(arm.pose(q) @ arm.fixed_frames[link],
                                   models.load_urdf(ARM, tip_frame=link).pose(q), atol=1e-12)
    np.testing.assert_array_equal(arm.fixed_frames[arm.tip_frame], np.eye(4))


def test_links_fixed_to_the_base():
    """Seen from the other end, what was the tip is the base."""
    arm = models.load_urdf(ARM, base_frame='tool', tip_frame='base')
    assert set(arm.fixed_to_base) == {'flange', 'sensor', 'tool'}
    q = [0.3, -0.7]
    for link in ('flange', 'sensor', 'tool'):
        np.testing.assert_allclose(
            inverse(arm.fixed_to_base[link]) @ arm.pose(q),
            models.load_urdf(ARM, base_frame=link, tip_frame='base').pose(q), atol=1e-12)
    assert arm.with_tool(np.eye(4)).fixed_to_base is not None


def test_the_platform_of_a_parallel_robot():
    platform = models.load('package://screw_kinematics/config/robots/planar_3rrr.yaml')
    tool = pose(rotation_rpy(0, 0, 0.3), [0.0, 0.1, 0.2])
    frames = platform.with_tool(tool, 'tool').fixed_frames
    np.testing.assert_allclose(frames[platform.tip_frame], inverse(tool), atol=1e-15)
    np.testing.assert_array_equal(frames['tool'], np.eye(4))
