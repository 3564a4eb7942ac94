# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Many recordings: the same states whoever makes them, and only what is missing."""
import json
import os
from pathlib import Path
import re
import shutil
import signal
import subprocess
import sys
import time

import pyarrow.dataset
import pyarrow.parquet
import pytest

from screw_kinematics.pipeline.parameter_file import robot_settings
from screw_kinematics.recordings import blocks
from screw_kinematics.recordings.fleet import cluster, in_order, process_all
from screw_kinematics.recordings.processing import process, Task
from screw_kinematics.recordings.sources import find_sources
from screw_kinematics.tools.bag import main as bag
from support import recordings as rec

PUMA = str(rec.ROBOTS / 'puma560.yaml')
ROBOT = (robot_settings('puma', {'description': PUMA}),)


def fleet(folder, count=4, samples=400):
    """Write recordings of all formats; return the folder."""
    folder.mkdir()
    for number in range(count):
        name = folder / f'run{number}'
        kind = number % 4
        if kind == 3:
            rec.write_ros1_bag(name.with_suffix('.bag'), samples + number)
        else:
            rec.write_bag(name, rec.samples(samples + number), 'sqlite3' if kind == 1 else 'mcap')
        if kind == 2:
            shutil.move(name / f'{name.name}.mcap', folder)
            shutil.rmtree(name)
    return folder


@pytest.fixture(scope='module')
def recordings(tmp_path_factory):
    return fleet(tmp_path_factory.mktemp('fleet') / 'day')


@pytest.fixture(scope='module')
def running_cluster(tmp_path_factory):
    """Start a scheduler and two workers as processes of their own; give address and workers."""
    folder = tmp_path_factory.mktemp('cluster')
    environment = {**os.environ, 'PYTHONPATH': str(Path(__file__).parents[2])}
    about = folder / 'scheduler.json'
    where = ['--scheduler-file', str(about)]
    commands = [['scheduler', '--port', '0', '--no-dashboard', *where], *[
        ['worker', '--nthreads', '1', '--no-nanny', '--no-dashboard', *where]] * 2]
    processes = []
    try:
        for command in commands:
            processes.append(subprocess.Popen(
                [sys.executable, '-m', f'distributed.cli.dask_{command[0]}', *command[1:]],
                env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                cwd=folder))
        end = time.monotonic() + 300
        while not about.exists() or not about.read_text().endswith('}'):
            assert time.monotonic() < end
            time.sleep(0.1)
        yield json.loads(about.read_text())['address'], processes[1:]
    finally:
        for process_ in processes:
            process_.kill()
            process_.wait()


def run(recordings, output, *more):
    return bag.main([str(recordings), '--robot', PUMA, '--name', 'puma', '--output', str(output),
                     *more])


def rows(output):
    """Return the data set as a table, ordered."""
    return pyarrow.dataset.dataset(output, partitioning='hive').to_table().sort_by(
        [('stamp_ns', 'ascending'), ('twist.linear.x', 'ascending')])


def contents(output):
    return {path.relative_to(output).as_posix(): pyarrow.parquet.read_table(path)
            for path in sorted(Path(output).rglob('*.parquet'))}


def test_a_data_set_of_all_recordings(recordings, tmp_path, capsys):
    assert run(recordings, tmp_path / 'states', '--processes', '1') == 0
    captured = capsys.readouterr()
    for number in range(4):
        assert re.search(rf'^run{number}  +puma +{400 + number} +{400 + number} .*200\.0 Hz',
                         captured.out, re.MULTILINE)
        assert f'run{number}: puma: {400 + number} joint samples' in captured.err
    assert re.search(r'^4 recordings .*0 with problems', captured.out, re.MULTILINE)
    table = rows(tmp_path / 'states')
    assert table.num_rows == 4 * 400 + 6 and set(table['robot'].to_pylist()) == {'puma'}
    assert set(table['date'].to_pylist()) == {'2023-11-14'}
    part = next((tmp_path / 'states').rglob('run0.parquet'))
    assert part.parent.name == 'date=2023-11-14' and part.parents[1].name == 'robot=puma'
    schema = pyarrow.parquet.read_schema(part)
    assert schema.metadata[b'base_frame'] == b'base' and schema.metadata[b'tip_frame'] == b'tool'
    assert schema.field('accel.linear.x').metadata[b'unit'] == b'm/s^2'
    assert schema.field('stamp_ns').metadata[b'unit'] == b'ns'


def test_two_processes_on_dask_make_what_one_makes(recordings, tmp_path):
    assert run(recordings, tmp_path / 'one', '--processes', '1') == 0
    assert run(recordings, tmp_path / 'two', '--processes', '2') == 0
    one, two = contents(tmp_path / 'one'), contents(tmp_path / 'two')
    assert one.keys() == two.keys() and all(one[name].equals(two[name]) for name in one)


def test_only_what_is_missing_is_done_again(tmp_path, capsys):
    day = fleet(tmp_path / 'day')
    output = tmp_path / 'states'
    assert run(day, output, '--processes', '1') == 0
    before = {path: path.stat().st_mtime_ns for path in output.rglob('*.parquet')}
    next(output.rglob('run1.parquet')).unlink()         # lost
    (output / '_done' / 'run3.json').unlink()           # the run was interrupted here
    shutil.rmtree(day / 'run0')
    rec.write_bag(day / 'run0', rec.samples(450))       # changed
    capsys.readouterr()
    assert run(day, output, '--processes', '1') == 0
    captured = capsys.readouterr()
    assert '1 of 4 recordings are done and unchanged' in captured.out
    assert 'run2' not in captured.err and re.search(r'run2 .*done before', captured.out)
    after = {path: path.stat().st_mtime_ns for path in output.rglob('*.parquet')}
    assert {path.stem for path in after if after[path] == before.get(path)} == {'run2'}
    assert rows(output).num_rows == 450 + 401 + 402 + 403
    assert run(day, output, '--processes', '1', '--outputs', 'twist') == 0
    assert 'are done' not in capsys.readouterr().out      # another task
    assert run(day, output, '--processes', '1', '--outputs', 'twist', '--force') == 0
    assert 'are done' not in capsys.readouterr().out
    assert not list(output.rglob('*.unfinished'))


def begun(recordings, output):
    """Return a run on two processes, as of a terminal of its own."""
    return subprocess.Popen(
        [sys.executable, '-m', 'screw_kinematics', 'bag', str(recordings), '--robot', PUMA,
         '--name', 'puma', '--output', str(output), '--processes', '2'], stderr=subprocess.PIPE,
        text=True, start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))


def test_signals_in_the_middle_of_a_long_recording(tmp_path):
    """What its workers are at is not waited for; the second signal waits for nothing."""
    path = rec.write_bag(tmp_path / 'run', rec.samples(70_000))
    for number, twice in ((signal.SIGINT, False), (signal.SIGTERM, False), (signal.SIGINT, True)):
        tool = begun(path, tmp_path / 'states')
        while tool.poll() is None and not (tmp_path / '.states.unfinished').exists():
            time.sleep(0.02)
        for _ in range(1 + twice):
            (tool.terminate() if number == signal.SIGTERM else os.killpg(tool.pid, number))
        error = tool.communicate(timeout=60)[1]
        assert tool.returncode == 128 + number and not error
        left = {path.name for path in tmp_path.iterdir()} - {'run'}
        assert left <= ({'.states.unfinished'} if twice else set())


def test_ctrl_c_leaves_nothing_unfinished_and_the_next_run_goes_on(tmp_path, capsys):
    """It reaches every process of the terminal; none of them has more to say than the tool."""
    day, output = fleet(tmp_path / 'day', 12, 2000), tmp_path / 'states'
    process_ = begun(day, output)
    while process_.poll() is None and not [*output.glob('_done/*.json')]:
        time.sleep(0.02)
    os.killpg(process_.pid, signal.SIGINT)
    error = process_.communicate(timeout=120)[1]
    assert process_.returncode == 130
    assert not [line for line in error.splitlines() if not re.match(
        r"run\d+: puma: \d+ joint samples", line)], error
    done = len([*output.glob('_done/*.json')])
    assert 0 < done < 12 and not [*output.rglob('*unfinished*')]
    assert run(day, output, '--processes', '1') == 0
    assert f'{done} of 12 recordings are done and unchanged' in capsys.readouterr().out
    assert rows(output).num_rows == sum(2000 + number for number in range(12))


def test_broken_recordings_are_a_line_each(running_cluster, tmp_path, capsys):
    day = fleet(tmp_path / 'day')
    data = (day / 'run2.mcap').read_bytes()
    (day / 'run2.mcap').write_bytes(data[:len(data) // 2])
    (day / 'run5.bag').write_bytes(b'#ROSBAG V2.0\n')
    (day / 'run6.csv').write_text('a,b\n1,2\n')
    assert run(day, tmp_path / 'states', '--scheduler', running_cluster[0]) == 1
    captured = capsys.readouterr()
    assert re.search(r'run2: .*damaged: .*cut off at byte', captured.err)
    assert re.search(r'run5: .*rosbag reindex', captured.err)
    assert re.search(r'run6: .*run6\.csv: no column of stamps; seen: a, b', captured.err)
    assert re.search(r'^run6 .*failed$', captured.out, re.MULTILINE)
    assert '6 recordings' in captured.out and '3 with problems' in captured.out
    assert {path.stem for path in (tmp_path / 'states').rglob('*.parquet')} == {
        'run0', 'run1', 'run2', 'run3'}


@pytest.mark.parametrize('form', ['mcap', 'csv'])
def test_other_outputs_of_many(recordings, form, tmp_path):
    assert run(recordings, tmp_path / 'out', '--format', form, '--processes', '1') == 0
    names = {path.name for path in (tmp_path / 'out').iterdir()}
    assert names == {'_done', *(f'run{i}' + ('.csv' if form == 'csv' else '') for i in range(4))}
    if form == 'mcap':
        assert len(rec.read_bag(tmp_path / 'out' / 'run3')['/puma/twist']) == 403


def test_however_blocks_are_handed_out_the_bits_are_the_same(
        running_cluster, tmp_path, monkeypatch):
    monkeypatch.setattr(blocks, 'BLOCK', 300)
    path = rec.write_bag(tmp_path / 'run', rec.samples(2000))
    source, = find_sources([str(path)])
    results = []
    with cluster(running_cluster[0], 2) as client:
        executor = client.get_executor(pure=False)
        for name, how in (('here', map), ('two', in_order(executor, 2)),
                          ('eight', in_order(executor, 8))):
            outcome = process(Task(source, ROBOT, form='parquet', folder=tmp_path, name=name), how)
            assert outcome.sound and outcome.robots[0].states == 2000
            results.append(pyarrow.parquet.read_table(tmp_path / f'{name}.parquet'))
    assert results[0].equals(results[1]) and results[0].equals(results[2])


def test_a_worker_that_dies_costs_its_blocks_only(running_cluster, tmp_path, monkeypatch):
    """One of two workers is killed in the middle of recordings and of blocks."""
    monkeypatch.setattr(blocks, 'BLOCK', 500)
    day = fleet(tmp_path / 'day', count=4, samples=600)
    rec.write_bag(day / 'long', rec.samples(5000, rate=1000.0))
    common = {'robots': ROBOT, 'form': 'dataset'}
    tasks = [Task(source, folder=tmp_path / 'cluster', name=source.name, **common)
             for source in find_sources([str(day)])]
    address, workers = running_cluster
    with cluster(address, 2) as client:
        client.wait_for_workers(2, timeout=300)
        killed = []

        def progress(task, samples, expected):
            if samples > 1500 and not killed:
                killed.append(task.name)
                workers[0].kill()

        outcomes = list(process_all(tasks, client, progress))
        assert killed == ['long'] and workers[0].wait(60) != 0
    assert sorted(outcome.name for outcome in outcomes) == sorted(task.name for task in tasks)
    assert all(outcome.sound for outcome in outcomes), [o.error for o in outcomes]
    for source in find_sources([str(day)]):
        # By whole recordings the workers have blocks of the usual size.
        monkeypatch.setattr(blocks, 'BLOCK', 500 if source.name == 'long' else 6400)
        process(Task(source, folder=tmp_path / 'here', name=source.name, **common))
    there, here = contents(tmp_path / 'cluster'), contents(tmp_path / 'here')
    assert there.keys() == here.keys()
    assert [name for name in here if not here[name].equals(there[name])] == []


def test_no_scheduler_there(recordings, tmp_path, capsys):
    assert run(recordings, tmp_path / 'out', '--scheduler', 'tcp://127.0.0.1:9') == 2
    assert 'no dask scheduler answers' in capsys.readouterr().err


def test_many_recordings_without_dask(recordings, tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, 'distributed', None)
    assert run(recordings, tmp_path / 'out', '--processes', '2') == 2
    error = capsys.readouterr().err
    assert "pip install 'screw_kinematics[fleet]'" in error and '--processes 1' in error
