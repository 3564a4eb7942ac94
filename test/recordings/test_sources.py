# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Recordings are found wherever they are, and each is one."""
import functools
import gzip
import http.server
import shutil
import threading

import pytest

from screw_kinematics.errors import ToolError
from screw_kinematics.recordings.joint_table import TableFormat
from screw_kinematics.recordings.sources import find_sources, group_files, opened, short_names
from screw_kinematics.tools.bag import main as bag
from support import recordings as rec

fsspec = pytest.importorskip('fsspec')
PUMA = str(rec.ROBOTS / 'puma560.yaml')


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with a bag, a file of a bag, and a folder within."""
    folder = tmp_path_factory.mktemp('sources') / 'lab'
    folder.mkdir()
    rec.write_bag(folder / 'whole', rec.samples(300))
    rec.write_bag(folder / 'part', rec.samples(300), 'sqlite3')
    (folder / 'monday').mkdir()
    shutil.move(folder / 'part' / 'part.db3', folder / 'monday' / 'run.db3')
    shutil.rmtree(folder / 'part')
    rec.write_ros1_bag(folder / 'monday' / 'run.bag', 300)
    (folder / 'notes.md').write_text('not a recording')
    return folder


@pytest.mark.parametrize('files, found', [
    (['a/x_0.db3', 'a/x_1.db3', 'a/x_2.db3'], ['a']),
    (['a/0_x_12.mcap', 'a/1_x_13.mcap'], ['a']),
    (['a/x_0.db3', 'a/x_2.db3'], ['a/x_0.db3', 'a/x_2.db3']),
    (['a/x_0.db3', 'a/y_1.db3'], ['a/x_0.db3', 'a/y_1.db3']),
    (['a/x_0.db3', 'a/x_1.db3', 'a/z.csv'], ['a/x_0.db3', 'a/x_1.db3', 'a/z.csv']),
    (['a/x_0.db3', 'a/b/y.bag'], ['a', 'a/b/y.bag']),
    (['a/p.mcap', 'a/q.mcap', 'a/metadata.yaml'], ['a']),
    (['a/a.mcap'], ['a']), (['a/b.mcap'], ['a/b.mcap']),
    (['in/a.csv', 'in/out/a.csv', 'in/out/_done/a.json'], ['in/a.csv']),
    (['in/a.csv', 'in/.hidden/b.csv', 'in/robot=x/date=1/c.parquet'], ['in/a.csv'])])
def test_which_files_are_one_recording(files, found):
    assert sorted(group_files(files)) == found


def test_names_are_short_and_different():
    assert short_names(['/d/run.mcap', '/d/run.bag']) == ['run_mcap', 'run_bag']
    assert short_names(['/d/a/run.mcap', '/d/b/run.mcap']) == ['a-run', 'b-run']
    assert short_names(['/d/a/run.mcap']) == ['run']
    assert short_names(['s3://lab/x.db3.zstd', 's3://lab/y']) == ['x', 'y']


def test_endings_in_capitals_are_the_same(folder, tmp_path):
    table = ['t,' + ','.join(f'q{k}' for k in range(1, 7))]
    table += [f'{k / 200},' + ','.join(['%g' % (k / 1000)] * 6) for k in range(300)]
    (tmp_path / 'log.csv').write_text('\n'.join(table))
    with gzip.open(tmp_path / 'packed.csv.gz', 'wt') as file:
        file.write('\n'.join(table))
    capitals = tmp_path / 'capitals'
    capitals.mkdir()
    for k, original in enumerate([folder / 'monday' / 'run.db3', folder / 'monday' / 'run.bag',
                                  tmp_path / 'log.csv', tmp_path / 'packed.csv.gz']):
        stem, _, ending = original.name.partition('.')
        copy = shutil.copy(original, capitals / f'{stem}{k}.{ending.upper()}')
        states = []
        for place, output in (original, f'{k}a.csv'), (copy, f'{k}b.CSV'):
            assert bag.main([str(place), '--robot', PUMA, '--output', str(tmp_path / output),
                             '--processes', '1']) == 0
            states.append((tmp_path / output.lower()).read_text())
        assert states[0] == states[1]
    assert {source.name for source in find_sources([str(capitals)])} == {
        'run0', 'run1', 'log2', 'packed3'}


def test_folders_patterns_and_files(folder):
    names = {source.name for source in find_sources([str(folder)])}
    assert names == {'whole', 'monday-run_db3', 'monday-run_bag'}
    assert [s.name for s in find_sources([str(folder / '*' / '*.bag')])] == ['run']
    assert len(find_sources([str(folder / 'whole'), str(folder / '**' / '*.db3')])) == 2
    with pytest.raises(ToolError, match='none.*: no recording there; allowed: a directory'):
        find_sources([str(folder), str(folder / 'none')])
    with pytest.raises(ToolError, match='notes.md: no recording there'):
        find_sources([str(folder / 'notes.md')])


def test_a_change_changes_the_state(tmp_path):
    (tmp_path / 'a.csv').write_text('x')
    before = find_sources([str(tmp_path)])
    assert find_sources([str(tmp_path)]) == before
    (tmp_path / 'a.csv').write_text('xy')
    assert find_sources([str(tmp_path)])[0].state != before[0].state


def test_what_fsspec_reaches(folder, tmp_path):
    """In memory, as in an object store: found, copied for reading, left as it is."""
    memory = fsspec.filesystem('memory')
    memory.put(str(folder), '/bucket/lab', recursive=True)
    sources = find_sources(['memory://bucket/lab'])
    assert {s.name for s in sources} == {'whole', 'monday-run_db3', 'monday-run_bag'}
    assert all(s.place.startswith('memory://bucket/lab/') and s.size > 1000 for s in sources)
    assert [s.name for s in find_sources(['memory://bucket/lab/*/*.bag'])] == ['run']
    for source in sources:
        with opened(source.place, TableFormat()) as recording:
            assert sum(1 for _ in recording.samples({'/joint_states'})) == 300
    for place, name in ((str(folder), 'local'), ('memory://bucket/lab', 'remote')):
        assert bag.main([place, '--robot', PUMA, '--processes', '1', '--output',
                         str(tmp_path / name)]) == 0
    parts = [sorted(path.relative_to(tmp_path / name) for path in (tmp_path / name).rglob(
        '*.parquet')) for name in ('local', 'remote')]
    assert parts[0] == parts[1] and len(parts[0]) == 3
    for part in parts[0]:
        assert (tmp_path / 'local' / part).read_bytes() == (
            tmp_path / 'remote' / part).read_bytes()


def test_a_server_of_files(folder, tmp_path):
    pytest.importorskip('aiohttp')

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *arguments):
            pass

    server = http.server.ThreadingHTTPServer(
        ('127.0.0.1', 0), functools.partial(Quiet, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        url = f'http://127.0.0.1:{server.server_port}/monday/run.bag'
        assert bag.main([url, '--robot', PUMA, '--output', str(tmp_path / 'x.csv')]) == 0
    finally:
        server.shutdown()


@pytest.mark.parametrize('url, message', [
    ('memory://nothing/there', 'nothing/there'), ('gopher://x/y', 'gopher'),
    ('http://127.0.0.1:9/x.bag', '127.0.0.1')])
def test_places_that_are_not_there(url, message, tmp_path, capsys):
    assert bag.main([url, '--robot', PUMA, '--output', str(tmp_path / 'x.csv')]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count('\n') == 1
