# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The decoder of joint states agrees with the middleware, and survives anything."""
import math
import struct
import sys

from hypothesis import given, settings, strategies as st
import pytest
from screw_kinematics.errors import MalformedMessageError
from screw_kinematics.messages import joint_state as cdr
from screw_kinematics.messages.joint_state import JointStateDecoder

pytest.importorskip('rclpy', reason='comes with ROS')
from rclpy.serialization import deserialize_message, serialize_message    # noqa: E402
from screw_kinematics.node.foreign_encoding import read_by_middleware    # noqa: E402
from sensor_msgs.msg import JointState    # noqa: E402

text = st.text(st.characters(exclude_characters='\0', exclude_categories=('Cs',)), max_size=40)
numbers = st.lists(st.floats(), max_size=60)


@st.composite
def messages(draw):
    message = JointState()
    message.header.frame_id = draw(text)
    message.header.stamp.sec = draw(st.integers(-2**31, 2**31 - 1))
    message.header.stamp.nanosec = draw(st.integers(0, 999_999_999))
    message.name = draw(st.lists(text | st.text('q', min_size=200, max_size=300), max_size=60))
    message.position = draw(numbers)
    message.velocity = draw(numbers)
    message.effort = draw(numbers)
    return message


def serialized(names=('a', 'bc'), position=(1.0, 2.0), velocity=(), effort=(), frame='base',
               sec=5, nanosec=7, order='<', padding=b'\0'):
    """Write a joint state as the standard says, independent of the code under test."""
    data = b''

    def align(size):
        nonlocal data
        data += (padding * 8)[:-len(data) % size]

    def put_string(value):
        nonlocal data
        align(4)
        raw = value.encode() + b'\0'
        data += struct.pack(order + 'I', len(raw)) + raw

    data += struct.pack(order + 'iI', sec, nanosec)
    put_string(frame)
    align(4)
    data += struct.pack(order + 'I', len(names))
    for name in names:
        put_string(name)
    for values in (position, velocity, effort):
        align(4)
        data += struct.pack(order + 'I', len(values))
        if values:
            align(8)
            data += struct.pack(f'{order}{len(values)}d', *values)
    return (b'\0\1\0\0' if order == '<' else b'\0\0\0\0') + data


def assert_same(sample, message):
    stamp = message.header.stamp
    assert sample.stamp_ns == stamp.sec * 10**9 + stamp.nanosec
    assert sample.names == tuple(message.name)
    for ours, theirs in ((sample.position, message.position), (sample.velocity, message.velocity)):
        assert struct.pack(f'{len(ours)}d', *ours) == theirs.tobytes()


@settings(deadline=None, derandomize=True)
@given(st.lists(messages(), min_size=1, max_size=4), st.randoms(use_true_random=False))
def test_reads_what_the_middleware_writes(batch, random):
    decoder = JointStateDecoder(read_by_middleware)
    for message in [*batch, *random.sample(batch, len(batch))]:
        assert_same(decoder.decode(serialize_message(message)), message)


@settings(deadline=None, derandomize=True)
@given(messages(), st.binary(min_size=8, max_size=8), st.sampled_from('<>'))
def test_reads_what_the_standard_says_whatever_the_padding(message, padding, order):
    stamp = message.header.stamp
    data = serialized(message.name, message.position, message.velocity, message.effort,
                      message.header.frame_id, stamp.sec, stamp.nanosec, order, padding)
    assert repr(deserialize_message(data, JointState)) == repr(message)
    assert_same(JointStateDecoder(read_by_middleware).decode(data), message)


@pytest.mark.parametrize('order', '<>')
def test_names_stay_the_same_object_while_they_are_equal(order):
    decoder = JointStateDecoder(read_by_middleware)
    first = decoder.decode(serialized(order=order)).names
    for i in range(5):
        data = serialized(velocity=[0.5] * i, padding=bytes([i]), frame='f' * i, order=order)
        assert decoder.decode(data).names is first
    assert decoder.decode(serialized(names=('a', 'bd'), order=order)).names == ('a', 'bd')


@pytest.mark.parametrize('publishers', [2, cdr.MAX_LAYOUTS, 2 * cdr.MAX_LAYOUTS])
def test_alternating_layouts_do_not_mix_and_do_not_pile_up(publishers):
    decoder = JointStateDecoder(read_by_middleware)
    for turn in range(3):
        for i in range(publishers):
            sample = decoder.decode(serialized(names=(f'r{i}',), position=(i + turn,)))
            assert sample[1:3] == ((f'r{i}',), (i + turn,))
    assert len(decoder._layouts) <= cdr.MAX_LAYOUTS


def test_layouts_of_equal_length_are_told_apart_by_every_count():
    one = (1.0, 2.0)
    decoder = JointStateDecoder(read_by_middleware)
    assert decoder.decode(serialized(velocity=one, effort=())).velocity == one
    assert decoder.decode(serialized(velocity=(), effort=one)).velocity == ()
    assert decoder.decode(serialized(position=(), velocity=one))[2:] == ((), one)


@settings(deadline=None, derandomize=True)
@given(messages(), st.data())
def test_every_truncation_is_refused(message, data):
    stamp = message.header.stamp
    whole = serialized(message.name, message.position, message.velocity, message.effort,
                       message.header.frame_id, stamp.sec, stamp.nanosec)
    decoder = JointStateDecoder(read_by_middleware)
    decoder.decode(whole)
    cut = data.draw(st.integers(0, len(whole) - 1))
    for reader in (decoder, JointStateDecoder(read_by_middleware)):
        with pytest.raises(MalformedMessageError):
            reader.decode(whole[:cut])


def test_a_little_slack_is_accepted_and_more_is_not():
    data = serialized()
    size = len(data)
    assert JointStateDecoder(read_by_middleware).decode(data + bytes(12)).names == ('a', 'bc')
    with pytest.raises(MalformedMessageError, match=f'after {size} bytes and has {size + 13}'):
        JointStateDecoder(read_by_middleware).decode(data + bytes(13))


@pytest.mark.parametrize('at, remaining', [
    (12, 52),     # frame_id
    (24, 40),     # names
    (28, 36),     # first name
    (44, 16),     # positions
    (60, 0),      # velocities
    (64, 0),      # efforts
])
def test_counts_beyond_the_message_are_refused(at, remaining):
    data = bytearray(serialized(position=(1.0,)))
    problem = f'announces 4294967295 items where {remaining} bytes remain'
    data[at:at + 4] = b'\xff' * 4
    decoder = JointStateDecoder(read_by_middleware)
    decoder.decode(serialized(position=(1.0,)))
    with pytest.raises(MalformedMessageError, match=problem):
        decoder.decode(bytes(data))


@pytest.mark.parametrize('data, problem', [
    (b'', 'JointState'),
    (b'\0\1\0\0', 'cut off after 4 bytes'),
    (serialized(nanosec=10**9), '1e9 nanoseconds'),
    (serialized(names=('a\0b',)), 'does not end in NUL'),
    (serialized(names=('abc',)).replace(b'abc\0', b'abcd'), 'does not end in NUL'),
    (serialized(names=('abc',)).replace(b'abc', b'a\xffc'), 'is not UTF-8'),
    (serialized() + bytes(cdr.MAX_BYTES), 'more than 262144'),
    (b'\0\5' + serialized()[2:], 'deserialize'),
])
def test_malformed_messages_are_named(data, problem):
    with pytest.raises(MalformedMessageError, match=problem):
        JointStateDecoder(read_by_middleware).decode(data)


@settings(deadline=None, derandomize=True, max_examples=300)
@given(st.data())
def test_no_bytes_do_harm(data):
    """Random bytes, and true messages with random damage, decode or are refused."""
    decoder = JointStateDecoder(read_by_middleware)
    good = serialized(velocity=(3.0, 4.0), order=data.draw(st.sampled_from('<<<>')))
    decoder.decode(good)
    damaged = bytearray(good)
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(damaged)))
        patch = data.draw(st.binary(max_size=8))
        damaged[at:at + data.draw(st.sampled_from([0, len(patch)]))] = patch
    for hostile in (bytes(damaged), data.draw(st.binary(max_size=200))):
        try:
            sample = decoder.decode(hostile)
        except MalformedMessageError:
            continue
        assert isinstance(sample.stamp_ns, int)
        assert sys.getsizeof(sample.position) < 1000 + 8 * len(hostile)
        assert all(isinstance(name, str) for name in sample.names)
        assert all(isinstance(v, float) for v in sample.position + sample.velocity)


def test_numbers_arrive_unchanged():
    values = (math.pi, -0.0, 5e-324, math.inf, -math.inf)
    data = serialized(position=values, velocity=(math.nan,))
    sample = JointStateDecoder(read_by_middleware).decode(data)
    assert sample.position == values
    assert math.copysign(1, sample.position[1]) == -1
    assert math.isnan(sample.velocity[0])
