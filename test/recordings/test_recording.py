# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Bags of ROS 2 and ROS 1 as recorders, crashes and compression leave them."""
import shutil
import sqlite3

import numpy as np
import pytest
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
import yaml

from screw_kinematics.recordings.recording import description_in, JOINT_STATE, Recording, STRING
from screw_kinematics.recordings.storage import zstd
from screw_kinematics.tools.bag import main as bag
from support import recordings as rec

PUMA = str(rec.ROBOTS / 'puma560.yaml')


def stamps(path):
    """Return the stamps of the joint states in a recording, and what was broken."""
    with Recording(path) as recording:
        found = [sample.stamp_ns for _, _, sample in recording.samples({'/joint_states'})]
        return found, recording.damage


def expected(count, rate=200.0):
    return [rec.START + round(k / rate * 1e9) for k in range(count)]


def contents(folder):
    """Return names and bytes of all files, to see that reading changes nothing."""
    return {file.name: file.read_bytes() for file in sorted(folder.rglob('*')) if file.is_file()}


def databases(folder, counts, name='rec_{}.db3'):
    """Write joint states into numbered databases without metadata; return the folder."""
    folder.mkdir()
    messages = list(rec.samples(sum(counts)))
    for number, count in enumerate(counts):
        bag_path = rec.write_bag(folder.parent / f'part{number}', messages[:count], 'sqlite3')
        messages = messages[count:]
        shutil.move(next(bag_path.glob('*.db3')), folder / name.format(number))
    return folder


@pytest.mark.parametrize('name', ['rec_{}.db3', '{}_rec_2026_11_29.db3', 'night{}.db3'])
def test_split_files_follow_each_other_in_time(name, tmp_path):
    folder = databases(tmp_path / 'rec', [20] * 12, name)
    found, damage = stamps(folder)
    assert found == expected(240) and damage == [f'{folder}: metadata.yaml is missing']


@pytest.mark.parametrize('what', ['folder', 'with metadata', 'file'])
@pytest.mark.parametrize('journal', ['-wal', '-journal'])
def test_a_journal_is_part_of_the_recording(what, journal, tmp_path):
    """400 messages are in the file, and 800 in the journal of a recorder that was killed."""
    path = rec.write_bag(tmp_path / 'run', rec.samples(1200), 'sqlite3')
    file, = path.glob('*.db3')
    database = sqlite3.connect(file, isolation_level=None)
    rows = database.execute('SELECT * FROM messages WHERE id > 400').fetchall()
    database.execute('DELETE FROM messages WHERE id > 400')
    database.execute(f'PRAGMA journal_mode={"WAL" if journal == "-wal" else "DELETE"}')
    if journal == '-journal':
        # As a crash leaves it: pages written, and what they were before in the journal.
        database.execute('PRAGMA cache_size=1')
        database.execute('PRAGMA cache_spill=1')
    database.execute('BEGIN')
    database.executemany('INSERT INTO messages VALUES (?, ?, ?, ?)', rows)
    if journal == '-wal':
        database.execute('COMMIT')
    crashed = tmp_path / 'crashed'
    shutil.copytree(path, crashed)
    database.close()
    assert (crashed / f'{file.name}{journal}').stat().st_size
    if what == 'folder':
        (crashed / 'metadata.yaml').unlink()
    before = contents(crashed)
    found, damage = stamps(crashed / file.name if what == 'file' else crashed)
    assert found == expected(1200 if journal == '-wal' else 400)
    assert contents(crashed) == before      # the recording is never written to
    lost = 'are not there' if what == 'with metadata' and journal == '-journal' else 'missing'
    assert all(lost in line for line in damage)
    assert bool(damage) == (what == 'folder' or lost == 'are not there')


def test_a_database_with_broken_pages(tmp_path):
    path = rec.write_bag(tmp_path / 'run', rec.samples(3000), 'sqlite3')
    file, = path.glob('*.db3')
    data = bytearray(file.read_bytes())
    page = 4096
    for number in (60, 90):
        data[number * page:(number + 1) * page] = b'\xff' * page
    file.write_bytes(data)
    found, damage = stamps(path)
    assert 2800 < len(set(found)) < 3000 and set(found) <= set(expected(3000))
    assert any('malformed' in line for line in damage)
    assert any('of 3000 messages on /joint_states are not there' in line for line in damage)


@pytest.mark.parametrize('share', [0.2, 0.5, 0.9])
def test_a_database_that_is_cut_off_keeps_what_came_before(share, tmp_path):
    path = rec.write_bag(tmp_path / 'run', rec.samples(1500), 'sqlite3')
    file, = path.glob('*.db3')
    file.write_bytes(file.read_bytes()[:int(share * file.stat().st_size)])
    before = contents(path)
    found, damage = stamps(path)
    assert found == sorted(set(found)) and set(found) <= set(expected(1500))
    assert (share - 0.1) * 1500 < len(found) < share * 1500
    assert any('cut off at byte' in line for line in damage)
    assert any('of 1500 messages on /joint_states are not there' in line for line in damage)
    assert contents(path) == before         # the recording is never written to


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
@pytest.mark.parametrize('mode', ['FILE', 'MESSAGE'])
@pytest.mark.parametrize('metadata', [True, False])
def test_compressed_bags(storage, mode, metadata, tmp_path):
    if (storage, mode) == ('mcap', 'MESSAGE'):
        # rosbags leaves MCAP's messages to MCAP's own compression; other writers do not.
        messages = [(t, k, at, zstd().compress(data)) for t, k, at, data in rec.samples(100)]
        path = rec.write_bag(tmp_path / 'run', messages)
    else:
        path = tmp_path / 'run'
        writer = Writer(path, version=9, storage_plugin=StoragePlugin[storage.upper()])
        writer.set_compression(CompressionMode[mode], CompressionFormat.ZSTD)
        with writer:
            connection = writer.add_connection('/joint_states', JOINT_STATE, typestore=rec.TYPES)
            for _, _, received, data in rec.samples(100):
                writer.write(connection, received, data)
    if not metadata:
        (path / 'metadata.yaml').unlink()
    found, damage = stamps(path)
    assert found == expected(100)
    assert len(damage) == (not metadata)


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_a_message_that_cannot_be_unpacked_is_lost_alone(storage, tmp_path):
    messages = list(rec.samples(100))
    messages[30] = (*messages[30][:3], zstd().compress(messages[30][3])[:-9])
    path = rec.write_bag(tmp_path / 'run', messages, storage)
    found, damage = stamps(path)
    assert found == expected(100)[:30] + expected(100)[31:]
    assert any('a message on /joint_states cannot be unpacked' in line for line in damage)


@pytest.mark.parametrize('change', ["timestamp = 'noon'", 'data = 7'])
def test_a_database_that_holds_other_types(change, tmp_path):
    """A database does not ensure types; what a broken page holds is of any."""
    path = rec.write_bag(tmp_path / 'run', rec.samples(100), 'sqlite3')
    edit(path, f'UPDATE messages SET {change} WHERE id = 7')
    found, damage = stamps(path)
    assert found == expected(100)[:6] + expected(100)[7:]
    assert damage == [f'{path}: 1 of 100 messages on /joint_states are not there']
    edit(path, "UPDATE topics SET name = CAST(X'2F88' AS TEXT)")
    with Recording(path) as recording:
        assert [connection.topic for connection in recording.connections] == ['/\ufffd']


def edit(path, statement):
    """Change the database of a recording."""
    file, = path.glob('*.db3')
    with sqlite3.connect(file) as database:
        database.execute(statement)
    database.close()


def test_a_compressed_file_that_is_cut_off(tmp_path):
    path = rec.write_bag(tmp_path / 'run', rec.samples(3000))
    file, = path.glob('*.mcap')
    packed = zstd().compress(file.read_bytes())
    (tmp_path / 'cut.mcap.zstd').write_bytes(packed[:len(packed) // 2])
    found, damage = stamps(tmp_path / 'cut.mcap.zstd')
    assert 0 < len(found) < 3000 and found == expected(3000)[:len(found)]
    assert any('cut off' in line for line in damage)


def test_versions_of_the_metadata(tmp_path):
    """Humble wrote version 5, Jazzy writes 9; the oldest put the folder before each file."""
    path = rec.write_bag(tmp_path / 'run', rec.samples(50), 'sqlite3')
    file = path / 'metadata.yaml'
    about = yaml.safe_load(file.read_text())
    bag_info = about['rosbag2_bagfile_information']
    for version in range(3, 10):
        bag_info['version'] = version
        if version < 5:
            bag_info.pop('files', None)
            bag_info['relative_file_paths'] = [f'run/{name}' if '/' not in name else name
                                               for name in bag_info['relative_file_paths']]
        file.write_text(yaml.safe_dump(about))
        assert stamps(path) == (expected(50), [])


def test_metadata_and_files_that_do_not_fit(tmp_path):
    path = rec.write_bag(tmp_path / 'run', rec.samples(50), 'sqlite3')
    shutil.copy(next(path.glob('*.db3')), path / 'other.db3')
    found, damage = stamps(path)
    assert found == expected(50) and 'other.db3: left out' in damage[0]
    (path / 'metadata.yaml').write_text('rosbag2_bagfile_information: [')
    assert 'metadata.yaml: unreadable' in stamps(path)[1][0]
    (path / 'metadata.yaml').write_text('x: 1')
    assert stamps(path)[0]


@pytest.mark.parametrize('compression', [None, 'BZ2', 'LZ4'])
def test_bags_of_ros_1_give_the_same_states(compression, tmp_path):
    path = rec.write_ros1_bag(tmp_path / 'run.bag', 300, compression)
    assert stamps(path) == (expected(300), [])
    new = rec.write_bag(tmp_path / 'run', rec.samples(300))
    for recording, name in ((path, 'old'), (new, 'new')):
        assert bag.main([str(recording), '--robot', PUMA, '--processes', '1',
                         '--output', str(tmp_path / f'{name}.csv')]) == 0
    assert (tmp_path / 'old.csv').read_bytes() == (tmp_path / 'new.csv').read_bytes()


def test_a_bag_of_ros_1_that_was_not_closed(tmp_path):
    data = rec.write_ros1_bag(tmp_path / 'run.bag', 300).read_bytes()
    for size in (0, 5, 13, 100, 4200, len(data) // 2, len(data) - 1):
        (tmp_path / 'cut.bag').write_bytes(data[:size])
        found, damage = stamps(tmp_path / 'cut.bag')
        assert damage and 'rosbag reindex' in damage[0] or len(found) == 300


def test_the_description_in_a_recording(tmp_path):
    text = '<robot name="ä"/>'
    data = bytes(rec.TYPES.serialize_cdr(rec.TYPES.types[STRING](text), STRING))
    path = rec.write_bag(tmp_path / 'run', [('/robot_description', STRING, rec.START, data)])
    with Recording(path) as recording:
        assert description_in(recording, '/robot_description') == text
        assert description_in(recording, '/other') is None


def test_negative_and_zero_stamps_are_treated_as_by_the_node(tmp_path, capsys):
    names = rec.PUMA.joint_names
    messages = [(topic, kind, at, data) for topic, kind, at, data in rec.samples(300)]
    for number, stamp in ((100, 0), (150, -5 * 10**9)):
        at = messages[number][2]
        q = rec.MOTION.derivatives((at - 300_000 - rec.START) * 1e-9, 0)[0]
        sample = rec.joint_state(0, names, q)
        seconds = int(stamp // 10**9).to_bytes(4, 'little', signed=True)
        messages[number] = (*messages[number][:3], sample[:4] + seconds + sample[8:])
    path = rec.write_bag(tmp_path / 'run', messages)
    assert bag.main([str(path), '--robot', PUMA, '--output', str(tmp_path / 'out')]) == 0
    assert '299 states' in (out := capsys.readouterr().out) and '1 stamp_negative' in out
    found = rec.read_bag(tmp_path / 'out')['/robot/twist']
    assert rec.stamp_of(found[100][1]) == messages[100][2]     # when it came
    assert np.all(np.diff([rec.stamp_of(m) for _, m in found]) > 0)
