# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages of a moving base are read as the middleware writes them, or refused."""
from hypothesis import given, settings, strategies as st
import numpy as np
import pytest
from screw_kinematics.errors import MalformedMessageError
from screw_kinematics.messages.base_motion import read_odometry, read_twist, READERS

pytest.importorskip('rclpy', reason='comes with ROS')
from geometry_msgs.msg import TwistStamped    # noqa: E402
from nav_msgs.msg import Odometry    # noqa: E402
from rclpy.serialization import serialize_message    # noqa: E402

text = st.text(st.characters(exclude_characters='\0', exclude_categories=('Cs',)), max_size=30)
stamps = st.integers(-2**31 * 10**9, 2**31 * 10**9 - 1)
numbers = st.lists(st.floats(allow_nan=False), min_size=13, max_size=13).map(tuple)


def filled(message, twist, stamp_ns, frame, values):
    """Fill in header and twist, linear first."""
    message.header.frame_id = frame
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 10**9)
    for part, three in ((twist.linear, values[:3]), (twist.angular, values[3:6])):
        part.x, part.y, part.z = three
    return message


def odometry(stamp_ns, frame, child, values):
    message = Odometry(child_frame_id=child)
    message.pose.covariance = np.arange(36.0)
    message.twist.covariance = np.arange(36.0)
    p, o = message.pose.pose.position, message.pose.pose.orientation
    p.x, p.y, p.z = values[6:9]
    o.x, o.y, o.z, o.w = values[9:]
    return filled(message, message.twist.twist, stamp_ns, frame, values)


@settings(deadline=None, derandomize=True)
@given(stamps, text, text, numbers)
def test_odometry(stamp_ns, frame, child, values):
    sample = read_odometry(serialize_message(odometry(stamp_ns, frame, child, values)))
    assert sample == (stamp_ns, child, (*values[3:6], *values[:3]), frame, values[6:9],
                      values[9:])


@settings(deadline=None, derandomize=True)
@given(stamps, text, numbers)
def test_twist(stamp_ns, frame, values):
    message = TwistStamped()
    sample = read_twist(serialize_message(
        filled(message, message.twist, stamp_ns, frame, values)))
    assert sample[:3] == (stamp_ns, frame, (*values[3:6], *values[:3])) and sample.world is None


@settings(deadline=None, derandomize=True)
@given(st.data())
def test_what_is_cut_or_changed_is_refused_or_read(data):
    """Never anything but a sample or this error."""
    whole = serialize_message(odometry(5, 'odom', 'base', (0.5,) * 13))
    end = data.draw(st.integers(0, len(whole)))
    broken = bytearray(whole[:end])
    for at in data.draw(st.lists(st.integers(0, max(end - 1, 0)), max_size=4)):
        if end:
            broken[at] = data.draw(st.integers(0, 255))
    for read in READERS.values():
        try:
            read(bytes(broken))
        except MalformedMessageError:
            pass


@pytest.mark.parametrize('broken, words', [
    (b'\0\0' + bytes(800), 'encapsulation is 0000'), (b'\0\1\0\0', 'cut off after 4 bytes'),
    (b'\0\1\0\0' + bytes(4) + b'\xff' * 4 + bytes(800), '1e9 nanoseconds'),
    (b'\0\1\0\0' + bytes(8) + b'\xff\xff\xff\x7f' + bytes(800), 'cut off after'),
    (b'\0\1\0\0' + bytes(8) + b'\2\0\0\0\xff\0' + bytes(800), 'not UTF-8')])
def test_what_is_wrong_is_named(broken, words):
    with pytest.raises(MalformedMessageError, match=words):
        read_odometry(broken)
