# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Every encoder writes what the middleware writes for the same message."""
from hypothesis import given, settings, strategies as st
import numpy as np
import pytest
from screw_kinematics.errors import InvalidValueError
from screw_kinematics.messages import stamped as encoders

pytest.importorskip('rclpy', reason='comes with ROS')
from geometry_msgs import msg    # noqa: E402
from rclpy.serialization import deserialize_message, serialize_message    # noqa: E402

text = st.text(st.characters(exclude_characters='\0', exclude_categories=('Cs',)), max_size=40)
stamps = st.integers(-2**31 * 10**9, 2**31 * 10**9 - 1)


def floats(count):
    return st.lists(st.floats(), min_size=count, max_size=count).map(tuple)


def put_header(header, stamp_ns, frame_id):
    header.frame_id = frame_id
    header.stamp.sec, header.stamp.nanosec = divmod(stamp_ns, 10**9)


def put_six(twist, values):
    names = ('x', 'y', 'z')
    for name, value in zip(names, values[:3]):
        setattr(twist.angular, name, value)
    for name, value in zip(names, values[3:]):
        setattr(twist.linear, name, value)


def assert_same(ours, message):
    """Compare as messages, value by value, and as bytes but for the undefined padding."""
    theirs = serialize_message(message)
    assert len(ours) == len(theirs)
    back = deserialize_message(ours, type(message))
    # Equal messages serialize into equal bytes, but for padding, which becomes text here.
    assert repr(back) == repr(message)
    different = [i for i, (a, b) in enumerate(zip(ours, theirs)) if a != b]
    assert all(ours[i] == 0 for i in different)
    assert all(i < 12 + 3 * 4 + 3 * 164 for i in different)


@settings(deadline=None, derandomize=True)
@given(stamps, text, floats(6), st.sampled_from([
    (msg.TwistStamped, 'twist'), (msg.AccelStamped, 'accel')]))
def test_six_vectors(stamp_ns, frame_id, values, kind):
    message_type, field = kind
    message = message_type()
    put_header(message.header, stamp_ns, frame_id)
    put_six(getattr(message, field), values)
    assert_same(encoders.TwistEncoder(frame_id).encode(stamp_ns, values), message)


@settings(deadline=None, derandomize=True)
@given(stamps, text, text, text, floats(6))
def test_velocity(stamp_ns, frame_id, body, reference, values):
    message = msg.VelocityStamped(body_frame_id=body, reference_frame_id=reference)
    put_header(message.header, stamp_ns, frame_id)
    put_six(message.velocity, values)
    encoder = encoders.VelocityEncoder(frame_id, body, reference)
    assert_same(encoder.encode(stamp_ns, values), message)


@settings(deadline=None, derandomize=True)
@given(stamps, text, floats(7))
def test_pose(stamp_ns, frame_id, values):
    message = msg.PoseStamped()
    put_header(message.header, stamp_ns, frame_id)
    position, orientation = message.pose.position, message.pose.orientation
    position.x, position.y, position.z = values[:3]
    orientation.x, orientation.y, orientation.z, orientation.w = values[3:]
    assert_same(encoders.PoseEncoder(frame_id).encode(stamp_ns, values), message)


@settings(deadline=None, derandomize=True)
@given(stamps, text, floats(42), st.sampled_from([
    (msg.TwistWithCovarianceStamped, 'twist'), (msg.AccelWithCovarianceStamped, 'accel')]))
def test_covariance(stamp_ns, frame_id, values, kind):
    message_type, field = kind
    message = message_type()
    put_header(message.header, stamp_ns, frame_id)
    inner = getattr(message, field)
    put_six(getattr(inner, field), values[:6])
    # Linear first: exchange the two blocks of rows and of columns.
    inner.covariance = np.roll(np.reshape(values[6:], (6, 6)), 3, axis=(0, 1)).ravel()
    assert_same(encoders.TwistWithCovarianceEncoder(frame_id).encode(stamp_ns, values), message)


@pytest.mark.parametrize('stamp_ns', [2**31 * 10**9, -2**31 * 10**9 - 1])
@pytest.mark.parametrize('encoder, size', [
    (encoders.TwistEncoder, 6), (encoders.PoseEncoder, 7)])
def test_stamps_that_do_not_fit_are_refused(stamp_ns, encoder, size):
    with pytest.raises(InvalidValueError, match=f'{stamp_ns} ns does not fit'):
        encoder('base').encode(stamp_ns, (0.0,) * size)


def test_frame_names_with_nul_are_refused():
    with pytest.raises(InvalidValueError, match='contains a NUL'):
        encoders.TwistEncoder('ba\0se')
