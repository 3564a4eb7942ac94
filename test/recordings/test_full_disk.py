# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A disk that is full while states are written: one line that says so, and nothing half done."""
from importlib.util import find_spec
import json
import os
from pathlib import Path
import re
import subprocess
import sys

import pytest

from support import recordings as rec

ROOT = Path(__file__).parents[2]
LIMITED = """
import json, resource, signal, sys
from pathlib import Path
sys.dont_write_bytecode = True      # it would be cut off, too
from screw_kinematics.tools.bag.main import main
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)       # an error, as of a full disk, not the end
most = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
for name, folder, arguments, limits in json.loads(sys.argv[1]):
    for limit in limits:
        for stream in (sys.stdout, sys.stderr):
            print('begins', name, file=stream, flush=True)
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, most))
        code = main(arguments)
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
        print('ends with', code, [*Path(folder).iterdir()], flush=True)
"""
FORMS = 'mcap', 'sqlite3', 'csv', 'parquet'
LIMITS = 0, 1000, 50_000, 150_000


@pytest.fixture(scope='module')
def runs(tmp_path_factory):
    """
    Write states of 10 s again and again; no file may become longer than each of the limits.

    Return by name what a form printed to stdout and to stderr, and the folder.

    """
    base = tmp_path_factory.mktemp('full')
    recording = rec.write_bag(base / 'run', rec.samples(2000))
    wanted = []
    for name in (*FORMS, 'whole'):
        if name == 'parquet' and find_spec('pyarrow') is None:
            continue
        folder = base / name
        folder.mkdir()
        output = folder / ('out' if name in ('mcap', 'sqlite3', 'whole') else f'out.{name}')
        storage = ['--storage', name] if name in ('mcap', 'sqlite3') else []
        wanted.append((name, str(folder), [
            str(recording), '--robot', str(rec.ROBOTS / 'puma560.yaml'), '--name', 'puma',
            '--output', str(output), *storage], (100_000_000,) if name == 'whole' else LIMITS))
    ended = subprocess.run(
        [sys.executable, '-c', LIMITED, json.dumps(wanted)],
        text=True, capture_output=True, timeout=300, env=os.environ | {'PYTHONPATH': str(ROOT)})
    assert ended.returncode == 0, ended.stderr
    found = {}
    for name, folder, *_ in wanted:
        texts = []
        for stream in (ended.stdout, ended.stderr):
            parts = re.split(r'^begins (.*)\n', stream, flags=re.M)[1:]
            texts.append(''.join(text for of, text in zip(parts[::2], parts[1::2]) if of == name))
        found[name] = *texts, Path(folder)
    return found


def ends(out):
    """Return the codes with which runs ended, and how often something was left in a folder."""
    told = re.findall(r'^ends with (\d+) (.*)$', out, re.M)
    return [int(code) for code, _ in told], sum(left != '[]' for _, left in told)


@pytest.mark.parametrize('form', FORMS)
def test_nothing_half_done_is_left(runs, form):
    if form == 'parquet':
        pytest.importorskip('pyarrow')
    out, errors, _ = runs[form]
    codes, left = ends(out)
    assert len(codes) == 4 and set(codes) <= {1, 2}, out + errors
    assert 'Traceback' not in out + errors and 'Exception ignored' not in out + errors, errors
    assert len(errors.splitlines()) == 4, out + errors
    assert not left


def test_the_same_with_room_enough_is_whole(runs):
    out, errors, folder = runs['whole']
    assert ends(out) == ([0], 1), errors
    assert len(rec.read_bag(folder / 'out')['/puma/twist']) == 2000


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
