# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A disk that is full while states are written: one line that says so, and nothing half done."""
import os
from pathlib import Path
import re
import subprocess
import sys

import pytest

from support import recordings as rec

ROOT = Path(__file__).parents[2]
LIMITED = """
import resource, signal, sys
from pathlib import Path
sys.dont_write_bytecode = True      # it would be cut off, too
from screw_kinematics.tools.bag.main import main
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)       # an error, as of a full disk, not the end
for limit in map(int, sys.argv[1].split(',')):
    most = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, most))
    print('ends with', main(sys.argv[3:]), [*Path(sys.argv[2]).iterdir()], flush=True)
"""


@pytest.fixture(scope='module')
def recording(tmp_path_factory):
    """Return a bag of 10 s."""
    return rec.write_bag(tmp_path_factory.mktemp('full') / 'run', rec.samples(2000))


def bag(folder, arguments, *limits):
    """
    Run the tool, again and again; no file of its may become longer than each of the limits.

    Return how it ended, the codes, and how often something was left in a folder.

    """
    ended = subprocess.run(
        [sys.executable, '-c', LIMITED, ','.join(map(str, limits)), folder,
         *map(str, arguments)],
        text=True, capture_output=True, timeout=300, env=os.environ | {'PYTHONPATH': str(ROOT)})
    assert ended.returncode == 0, ended.stderr
    told = re.findall(r'^ends with (\d+) (.*)$', ended.stdout, re.M)
    return ended, [int(code) for code, _ in told], sum(left != '[]' for _, left in told)


@pytest.mark.parametrize('form', ['mcap', 'sqlite3', 'csv', 'parquet'])
def test_nothing_half_done_is_left(recording, tmp_path, form):
    if form == 'parquet':
        pytest.importorskip('pyarrow')
    output = tmp_path / ('out' if form in ('mcap', 'sqlite3') else f'out.{form}')
    storage = ['--storage', form] if form in ('mcap', 'sqlite3') else []
    ended, codes, left = bag(tmp_path, [
        recording, '--robot', rec.ROBOTS / 'puma560.yaml', '--name', 'puma', '--output', output,
        *storage], 0, 1000, 50_000, 150_000)
    told = ended.stderr + ended.stdout
    assert len(codes) == 4 and set(codes) <= {1, 2}, told
    assert 'Traceback' not in told and 'Exception ignored' not in told, told
    assert len(ended.stderr.splitlines()) == 4, told
    assert not left


def test_the_same_with_room_enough_is_whole(recording, tmp_path):
    ended, codes, left = bag(tmp_path, [
        recording, '--robot', rec.ROBOTS / 'puma560.yaml', '--name', 'puma', '--output',
        tmp_path / 'out'], 100_000_000)
    assert codes == [0] and left == 1, ended.stderr
    assert len(rec.read_bag(tmp_path / 'out')['/puma/twist']) == 2000


@pytest.mark.skipif(not os.path.exists('/dev/full'), reason='there is no /dev/full')
@pytest.mark.parametrize('tool, arguments', [
    ('check', ['model', rec.ROBOTS / 'puma560.yaml']),
    ('derive', [rec.ROBOTS / 'rpr.yaml']),
    ('derive', [rec.ROBOTS / 'rpr.yaml', '--output', '/dev/full'])])
def test_what_cannot_be_printed_is_told(tool, arguments):
    with open('/dev/full', 'w') as full:
        ended = subprocess.run(
            [sys.executable, '-m', 'screw_kinematics', tool, *map(str, arguments)], stdout=full,
            stderr=subprocess.PIPE, text=True, timeout=300,
            env=os.environ | {'PYTHONPATH': str(ROOT)})
    assert ended.returncode != 0
    assert 'Traceback' not in ended.stderr and 'Exception ignored' not in ended.stderr
    assert 'No space left on device' in ended.stderr and len(ended.stderr.splitlines()) == 1
