# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joint motion as bytes: ROS reads what was written, whatever the lengths of names."""
import numpy as np
import pytest
from screw_kinematics.errors import InvalidValueError
from screw_kinematics.messages.joint_motion import JointStateEncoder, JointTrajectoryEncoder
from screw_kinematics.messages.joint_state import JointStateDecoder

STAMP = 1_700_000_000_123_456_789
NAMES = [['q'], ['a', 'bc', 'def'], ['left_arm_joint_1', 'ä', ''], [f'j{k}' for k in range(40)]]


def numbers(names, arrays):
    return np.random.default_rng(len(names)).normal(size=arrays * len(names)).tolist()


@pytest.mark.parametrize('names', NAMES)
def test_joint_states_are_read_back(names):
    values = numbers(names, 3)
    sample = JointStateDecoder().decode(JointStateEncoder(names).encode(STAMP, values))
    n = len(names)
    assert sample == (STAMP, tuple(names), tuple(values[:n]), tuple(values[n:2 * n]))


@pytest.mark.parametrize('names', NAMES)
def test_ros_reads_what_is_written(names):
    pytest.importorskip('rclpy')
    from rclpy.serialization import deserialize_message
    from sensor_msgs.msg import JointState
    from trajectory_msgs.msg import JointTrajectory

    n, values = len(names), numbers(names, 3)
    for encoder, kind in (JointStateEncoder, JointState), (JointTrajectoryEncoder,
                                                           JointTrajectory):
        message = deserialize_message(encoder(names).encode(STAMP, values), kind)
        if kind is JointState:
            assert message.name == names and list(message.velocity) == values[n:2 * n]
        assert (message.header.stamp.sec, message.header.stamp.nanosec) == divmod(STAMP, 10**9)
    point, = message.points
    assert message.joint_names == names
    got = [point.positions, point.velocities, point.accelerations, point.effort]
    assert [list(x) for x in got] == [values[:n], values[n:2 * n], values[2 * n:], []]
    assert (point.time_from_start.sec, point.time_from_start.nanosec) == (0, 0)


@pytest.mark.parametrize('stamp', [2**31 * 10**9, -2**31 * 10**9 - 1])
def test_stamps_that_do_not_fit_are_refused(stamp):
    with pytest.raises(InvalidValueError, match='int32'):
        JointStateEncoder(['q']).encode(stamp, [0.0, 0.0])


def test_names_hold_no_nul():
    with pytest.raises(InvalidValueError, match='NUL'):
        JointTrajectoryEncoder(['a\0b'])
