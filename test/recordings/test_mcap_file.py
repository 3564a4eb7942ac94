# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""MCAP files of every kind, whole and broken: what is there is read, what is not is named."""
import os

from mcap.writer import CompressionType, IndexType, Writer
import pytest

from screw_kinematics.errors import ToolError
from screw_kinematics.recordings.recording import JOINT_STATE, Recording, STRING
from screw_kinematics.tools.bag import main as bag
from support import recordings as rec

PUMA = str(rec.ROBOTS / 'puma560.yaml')


def write(path, messages, profile='ros2', encoding='cdr', schema_encoding='ros2msg',
          close=True, **options):
    """Write an MCAP file by the library of its makers; return its path."""
    with open(path, 'wb') as file:
        writer = Writer(file, **options)
        writer.start(profile=profile, library='test')
        channels = {}
        for topic, kind, received, data in messages:
            if (topic, kind) not in channels:
                schema = writer.register_schema(kind, schema_encoding, b'# not needed')
                channels[topic, kind] = writer.register_channel(topic, encoding, schema)
            writer.add_message(channels[topic, kind], log_time=received, publish_time=received,
                               data=data)
        if close:
            writer.finish()
    return path


def messages(count=120, **options):
    """Return joint states as (topic, type, time, bytes)."""
    return list(rec.samples(count, **options))


def read(path, kinds=frozenset({JOINT_STATE})):
    """Return the messages of a recording, and what was broken."""
    with Recording(path) as recording:
        found = [(m.received, m.data) for m in recording.messages(set(kinds))]
        return found, recording.damage


def expected(given):
    return [(received, data) for _, _, received, data in given]


@pytest.mark.parametrize('options', [
    {'compression': compression} for compression in CompressionType] + [
    {'use_chunking': False}, {'index_types': IndexType.NONE}, {'index_types': IndexType.CHUNK},
    {'repeat_channels': False, 'repeat_schemas': False}, {'use_statistics': False},
    {'use_summary_offsets': False, 'enable_crcs': False}, {'profile': ''}], ids=str)
def test_all_messages_of_whole_files(options, tmp_path):
    given = messages()
    found, damage = read(write(tmp_path / 'x.mcap', given, chunk_size=4000, **options))
    assert found == expected(given) and damage == []


def test_chunks_out_of_order_are_read_in_order(tmp_path):
    given = messages(300)
    shuffled = given[200:] + given[:100] + given[100:200][::-1]
    found, damage = read(write(tmp_path / 'x.mcap', shuffled, chunk_size=4000))
    assert found == expected(given) and not damage


@pytest.mark.parametrize('times', [
    lambda k, t: 7, lambda k, t: t // 10**9, lambda k, t: 0, lambda k, t: 2**64 - 5,
    lambda k, t: 7 if k < 150 else 8], ids=['same', 's', 'zero', 'below zero', 'two'])
def test_messages_of_one_time_stay_in_order(times, tmp_path):
    given = [(topic, kind, times(k, time), data)
             for k, (topic, kind, time, data) in enumerate(messages(300))]
    found, damage = read(write(tmp_path / 'x.mcap', given, chunk_size=4000))
    assert [data for _, data in found] == [data for *_, data in given] and not damage


@pytest.mark.parametrize('options', [
    {'compression': CompressionType.ZSTD}, {'compression': CompressionType.LZ4},
    {'compression': CompressionType.NONE}, {'use_chunking': False}], ids=str)
def test_a_file_cut_at_any_byte_keeps_what_came_before(options, tmp_path):
    given = messages(8)
    cut, sent = write(tmp_path / 'cut.mcap', given, chunk_size=600, **options), expected(given)
    whole = cut.read_bytes()
    counts = [0] * len(whole)
    for size in reversed(range(len(whole))):
        os.truncate(cut, size)
        found, damage = read(cut)
        assert damage and f'at byte {size}' in damage[0] or 'at byte 0' in damage[0]
        assert found == sent[:len(found)]
        counts[size] = len(found)
    assert counts == sorted(counts) and counts[-1] == len(given)
    # Without compression, every message that is there as a whole is kept.
    if options in ({'compression': CompressionType.NONE}, {'use_chunking': False}):
        for i, (_, data) in enumerate(sent):
            assert counts[min(whole.index(data) + len(data), len(counts) - 1)] > i


def test_any_byte_may_be_wrong(tmp_path):
    given = messages(12)
    broken = write(tmp_path / 'broken.mcap', given, chunk_size=1000)
    whole = broken.read_bytes()
    good = set(expected(given))
    for at in range(0, len(whole), 5):
        with open(broken, 'r+b') as file:
            for place in (at, max(0, at - 5)):      # the one before is right again
                file.seek(place)
                file.write(bytes([whole[place] ^ 0xff * (place == at)]))
        found, damage = read(broken)
        with Recording(broken) as recording:
            known = any(c[:2] == ('/joint_states', JOINT_STATE) for c in recording.connections)
        # A wrong letter in the name of a type makes another type.
        assert damage or len(found) == len(given) or not known
        # By its checksum a chunk is whole or not read; a time may be wrong in an index only.
        assert set(found) <= good


def test_a_hole_costs_its_chunk_only(tmp_path):
    given = messages(300)
    path = write(tmp_path / 'x.mcap', given, chunk_size=4000)
    data = bytearray(path.read_bytes())
    data[len(data) // 2:len(data) // 2 + 60] = bytes(60)
    path.write_bytes(data)
    found, damage = read(path)
    assert 300 - 60 < len(found) < 300 and set(found) < set(expected(given))
    assert found[-1] == expected(given)[-1] and found[0] == expected(given)[0]
    assert any('of 300 messages on /joint_states are not there' in line for line in damage)


def test_a_log_time_below_zero(tmp_path):
    given = messages(60)
    given[20] = (*given[20][:2], 2**64 - 5, given[20][3])
    found, damage = read(write(tmp_path / 'x.mcap', given, chunk_size=4000))
    assert [data for _, data in found] == [data for _, data in expected(given)] and not damage
    assert found[20][0] == found[19][0]


def test_two_types_on_one_topic(tmp_path):
    given = messages(40)
    text = ('/joint_states', STRING, given[0][2], b'\0\1\0\0\2\0\0\0a\0')
    path = write(tmp_path / 'x.mcap', [text, *given, text])
    assert read(path)[0] == expected(given)
    assert bag.main([str(path), '--robot', PUMA, '--output', str(tmp_path / 'x.csv')]) == 0


def test_messages_that_are_missing_are_a_finding(tmp_path):
    """Statistics that promise more than there is."""
    given = messages(120)
    path = write(tmp_path / 'x.mcap', given, compression=CompressionType.NONE, chunk_size=4000,
                 enable_crcs=False)
    data = path.read_bytes()
    # A message of another channel is nobody's.
    at = data.index(given[50][3]) - 22
    path.write_bytes(data[:at] + b'\x99\x99' + data[at + 2:])
    found, damage = read(path)
    assert len(found) == 119
    assert damage == [f'{path}: 1 of 120 messages on /joint_states are not there']


@pytest.mark.parametrize('encoding', ['ros1', 'json', 'protobuf'])
@pytest.mark.parametrize('kind', [JOINT_STATE, 'sensor_msgs/JointState', 'foxglove.JointStates'])
def test_messages_that_are_not_ros_2(encoding, kind, tmp_path, capsys):
    given = [(topic, kind, received, data) for topic, _, received, data in messages()]
    path = write(tmp_path / 'x.mcap', given, profile='', encoding=encoding)
    with Recording(path) as recording, pytest.raises(ToolError, match=encoding):
        recording.require_joint_states({'/joint_states'})
    assert bag.main([str(path), '--robot', PUMA, '--output', str(tmp_path / 'x.csv')]) == 2
    error = capsys.readouterr().err
    assert error.count('\n') == 1 and f'encoded as {encoding}' in error and 'convert' in error
    assert sorted(file.name for file in tmp_path.iterdir()) == ['x.mcap']


def test_an_unfinished_file(tmp_path, capsys):
    path = write(tmp_path / 'x.mcap', messages(400), chunk_size=4000, close=False)
    output = tmp_path / 'x.csv'
    assert bag.main([str(path), '--robot', PUMA, '--output', str(output)]) == 1
    assert output.exists() and 'the recording was not closed' in capsys.readouterr().err


def test_no_mcap_at_all(tmp_path, capsys):
    for content in (b'', b'\x89MCAP', b'SQLite format 3' * 10):
        (tmp_path / 'x.mcap').write_bytes(content)
        assert bag.main([str(tmp_path / 'x.mcap'), '--robot', PUMA,
                         '--output', str(tmp_path / 'x.csv')]) == 1
        assert 'damaged' in capsys.readouterr().err
    assert sorted(file.name for file in tmp_path.iterdir()) == ['x.mcap']
