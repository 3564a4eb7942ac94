# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The core's loops over bytes: compiled and as text the same, and nothing beyond the message."""
import random
import struct

import pytest

from screw_kinematics.core import cdr, interpreted

TEXT = interpreted('cdr')
MODULES = pytest.mark.parametrize('module', [cdr, TEXT])
# Stamp, frame 'b', one name 'j', two positions, one velocity, no effort; 2 bytes of no value.
MESSAGE = (b'\0\1\0\0' + struct.pack('<iI', 7, 8) + struct.pack('<I2s2x', 2, b'b\0')
           + struct.pack('<II2s2x', 1, 2, b'j\0') + struct.pack('<I4x2d', 2, 1.5, -2.5)
           + struct.pack('<I4xd', 1, 9.0) + struct.pack('<I', 0))
MASK = bytes([255] * 18 + [0] * 2 + [255] * 10 + [0] * 2 + [255] * (len(MESSAGE) - 32))
PLACES = {'end': 36, 'position_at': 40, 'positions': 2, 'velocity_count_at': 56,
          'velocity_at': 64, 'velocities': 1, 'effort_count_at': 72}


def layout(module, **changes):
    return module.JointStateLayout(MESSAGE, MASK, *{**PLACES, **changes}.values())


def changed(at, data):
    return MESSAGE[:at] + data + MESSAGE[at + len(data):]


@MODULES
def test_stamp_and_numbers_are_read(module):
    read = layout(module).read
    assert read(MESSAGE) == (7_000_000_008, (1.5, -2.5), (9.0,))
    assert read(changed(4, struct.pack('<iI', -3, 5)))[0] == -2_999_999_995
    earliest = read(changed(4, struct.pack('<iI', -2**31, 999_999_999)))[0]
    assert earliest == -2**31 * 10**9 + 999_999_999
    assert read(changed(2, b'\7\7'))[1] == (1.5, -2.5)            # options have no meaning
    assert read(changed(18, b'\7\7'))[1] == (1.5, -2.5)           # nor have bytes between fields
    assert read(changed(40, struct.pack('<d', 0.1)))[1] == (0.1, -2.5)


@MODULES
@pytest.mark.parametrize('at, data', [
    (0, b'\1'), (1, b'\0'), (8, struct.pack('<I', 10**9)), (16, b'c'), (28, b'k'), (12, b'\3'),
    (32, b'\1'), (56, b'\2'), (56, b'\xff\xff\xff\xff'), (72, b'\1'), (20, b'\2')])
def test_what_differs_in_more_is_of_another_layout(module, at, data):
    assert layout(module).read(changed(at, data)) is None


@MODULES
def test_other_lengths_are_of_another_layout(module):
    read = layout(module).read
    assert not any(map(read, [b'', MESSAGE[:-1], MESSAGE + b'\0', MESSAGE * 2]))


@MODULES
@pytest.mark.parametrize('changes', [
    {'end': 11}, {'end': 77}, {'position_at': -1}, {'position_at': 61}, {'positions': -1},
    {'positions': 5}, {'positions': 2**62}, {'velocity_at': 69}, {'velocities': 2},
    {'velocities': 2**61}, {'velocity_count_at': 73}, {'effort_count_at': -4}])
def test_places_beyond_the_message_are_refused(module, changes):
    with pytest.raises(ValueError, match='beyond its message'):
        layout(module, **changes)


def test_damaged_messages_are_the_same_compiled_and_as_text():
    rng = random.Random(0)
    compiled, text = layout(cdr).read, layout(TEXT).read
    for _ in range(3000):
        data = bytearray(MESSAGE)
        for _ in range(rng.randrange(3)):
            data[rng.randrange(len(data))] = rng.randrange(256)
        assert repr(compiled(bytes(data))) == repr(text(bytes(data)))


@MODULES
def test_numbers_go_where_they_belong(module):
    write = module.StampedMessage(
        b'head' + bytes(8) + b'body' + bytes(8) + b'mid' + bytes(8) + b'end', [16, 27],
        [2, 0]).write
    assert write(7_000_000_008, (1.0, 2.0, 3)) == (
        b'head' + struct.pack('<iI', 7, 8) + b'body' + struct.pack('<d', 3.0)
        + b'mid' + struct.pack('<d', 1.0) + b'end')
    assert write(-1, [1.0, 2.0, 3.0])[4:12] == struct.pack('<iI', -1, 999_999_999)
    for stamp in (2**31 * 10**9, -2**31 * 10**9 - 1, 2**63 - 1):
        assert write(stamp, (1.0, 2.0, 3.0)) is None
    assert write(2**31 * 10**9 - 1, (1.0, 2.0, 3.0))[4:12] == \
        struct.pack('<iI', 2**31 - 1, 999_999_999)
    with pytest.raises(ValueError, match='3 values are needed, not 2'):
        write(0, (1.0, 2.0))


@MODULES
@pytest.mark.parametrize('size, places, order, match', [
    (11, [], [], 'without a stamp'), (30, [11], [0], 'reach beyond'),
    (30, [23], [0], 'reach beyond'), (30, [12, 2**62], [0, 1], 'reach beyond'),
    (30, [12], [-1], 'a place'), (30, [12], [0, 1], 'a place')])
def test_numbers_without_a_place_are_refused(module, size, places, order, match):
    with pytest.raises(ValueError, match=match):
        module.StampedMessage(bytes(size), places, order)
