# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Measure the tool bag on many recordings: rate by processes, memory, restart, reading alone.

Run ``python -m benchmark.recordings --recordings 200 --samples 30000`` on an idle machine; as it
is, it takes some minutes.
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
import os
from pathlib import Path
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from .recordings import damage, FORMATS, JOINTS, write
from screw_kinematics.recordings.joint_table import TableFormat
from screw_kinematics.recordings.recording import Recording
from screw_kinematics.recordings.sources import opened

MODEL = 'package://screw_kinematics/config/robots/panda.yaml'
DAMAGED = 3
KINDS = dict.fromkeys(JOINTS, 'revolute')


def main(argv: Sequence[str] | None = None) -> None:
    """Run the benchmark."""
    options = argparse.ArgumentParser(prog='python -m benchmark.recordings', description=__doc__,
                                      formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument('--recordings', type=int, default=24)
    options.add_argument('--samples', type=int, default=10_000, help='of each')
    options.add_argument('--long', type=int, default=200_000, help='samples of one long recording')
    options.add_argument('--processes', default='1,2', help='numbers to compare')
    arguments = options.parse_args(argv)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name, 'recordings')
        folder.mkdir()
        made = [write(folder, k, arguments.samples, FORMATS[k % len(FORMATS)])
                for k in range(arguments.recordings)]
        for path in made[:DAMAGED]:
            damage(path)
        _reading(made[len(made) - len(FORMATS):], arguments.samples)
        for count in map(int, arguments.processes.split(',')):
            _rate(folder, Path(name, f'states{count}'), count)
        _restart(folder, Path(name, 'restarted'))
        long = write(Path(name), 9999, arguments.long, 'mcap')
        for count in map(int, arguments.processes.split(',')):
            _rate(long, Path(name, f'long{count}'), count)


def _reading(paths: Sequence[Path], samples: int) -> None:
    """Print how fast each format is read and decoded."""
    print(f'{"reading alone":<24}{"samples/s":>12}{"MB/s":>8}')
    for path, form in zip(paths, FORMATS):
        begin = time.process_time()
        with opened(str(path), TableFormat()) as recording:
            count = sum(1 for _ in (
                recording.samples({'/joint_states'}) if isinstance(recording, Recording)
                else recording.samples(KINDS)))
        seconds = time.process_time() - begin
        files = path.rglob('*') if path.is_dir() else [path]
        size = sum(file.stat().st_size for file in files)
        print(f'{form:<24}{count / seconds:>12,.0f}{size / seconds / 1e6:>8.1f}')
        assert count == samples


def _start(folder: Path, output: Path, processes: int) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, '-m', 'screw_kinematics', 'bag', str(folder), '--robot', MODEL,
         '--output', str(output), '--format', 'dataset', '--processes', str(processes)],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, start_new_session=True)


def _rate(folder: Path, output: Path, processes: int) -> None:
    """Print the rate of a whole run, its processor time, and the largest process."""
    begin, busy = time.monotonic(), _processor()
    running = _start(folder, output, processes)
    largest = 0.0
    while running.poll() is None:
        largest = max(largest, *map(_memory, _family(running.pid)))
        time.sleep(0.2)
    seconds = time.monotonic() - begin
    text = running.stdout.read() if running.stdout else ''
    samples = int(re.findall(r'^\d+ recordings +(\d+)', text, re.MULTILINE)[-1])
    print(f'{folder.name}, {processes} processes: {samples} samples in {seconds:.1f} s, '
          f'{samples / seconds:,.0f} samples/s; {samples / (_processor() - busy):,.0f} in a '
          f'second of processor time; largest process {largest:.0f} MiB')


def _restart(folder: Path, output: Path) -> None:
    """Interrupt a run in its middle; print what the next one still had to do."""
    running = _start(folder, output, 2)
    whole = len(list(folder.iterdir()))
    while len(list(output.glob('_done/*.json'))) < whole // 2 and running.poll() is None:
        time.sleep(0.1)
    os.killpg(running.pid, signal.SIGKILL)
    running.wait()
    done = len(list(output.glob('_done/*.json')))
    begin = time.monotonic()
    text = _start(folder, output, 2).communicate()[0]
    again = re.search(r'(\d+) of \d+ recordings are done and unchanged', text)
    print(f'killed when {done} of {whole} were done; the next run found '
          f'{again[1] if again else 0} done and took {time.monotonic() - begin:.1f} s')
    assert not list(output.glob('.*')), 'something unfinished was left'
    shutil.rmtree(output)


def _processor() -> float:
    """Return the processor time of all processes that were started and have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _family(pid: int) -> list[int]:
    """Return a process and those that descend from it."""
    children: dict[int, list[int]] = {}
    for status in Path('/proc').glob('[0-9]*/stat'):
        try:
            parent = int(status.read_text().rpartition(')')[2].split()[1])
        except (OSError, ValueError, IndexError):
            continue
        children.setdefault(parent, []).append(int(status.parent.name))
    family = [pid]
    for member in family:
        family.extend(children.get(member, []))
    return family


def _memory(pid: int) -> float:
    """Return how much memory a process needed so far [MiB]."""
    try:
        found = re.search(r'VmHWM:\s+(\d+)', Path(f'/proc/{pid}/status').read_text())
    except OSError:
        return 0.0
    return int(found[1]) / 1024 if found else 0.0


if __name__ == '__main__':
    main()
