# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Measure the tool bag on many recordings: rate by processes, memory, restart, reading alone.

Seven joints, all formats mixed, three recordings cut off. A run has as many cores as processes:
else reading tables would have another one, where there is but one process. As it is, it takes
half an hour and needs an idle machine; --recordings 40 and --long 200000 give nearly the same
rates in minutes.
Beside them as many programs of their own, each with its share of the recordings on a core of its
own: what the machine gives, since cores may share more than the memory.
Of each run: the rate, the samples in a second of processor time, how many seconds processes that
could have worked waited for a processor, each, and the memory of the largest of them.
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
import os
from pathlib import Path
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from rich.console import Console
from rich.progress import Progress, track

from .processes import Family
from .recordings import damage, FORMATS, JOINTS, write
from screw_kinematics.recordings.joint_table import TableFormat
from screw_kinematics.recordings.recording import Recording
from screw_kinematics.recordings.sources import opened
from screw_kinematics.tools.processes import end_with_parent

MODEL = 'package://screw_kinematics/config/robots/panda.yaml'
DAMAGED = 3
KINDS = dict.fromkeys(JOINTS, 'revolute')
_ERRORS = Console(stderr=True)


def main(argv: Sequence[str] | None = None) -> None:
    """Run the benchmark."""
    options = argparse.ArgumentParser(prog='python -m benchmark.recordings', description=__doc__,
                                      formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument('--recordings', type=int, default=200)
    options.add_argument('--samples', type=int, default=30_000, help='of each')
    options.add_argument('--long', type=int, default=2_000_000,
                         help='samples of one long recording; 0: none')
    options.add_argument('--processes', default='1,2', help='numbers to compare')
    arguments = options.parse_args(argv)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name, 'recordings')
        folder.mkdir()
        made = [write(folder, k, arguments.samples, FORMATS[k % len(FORMATS)]) for k in track(
            range(arguments.recordings), 'writing recordings', console=_ERRORS)]
        _reading(made[-len(FORMATS):], arguments.samples)
        for path in made[:DAMAGED]:
            damage(path)
        counts = [int(count) for count in arguments.processes.split(',')]
        _compare(folder, Path(name), counts)
        _restart(folder, Path(name, 'restarted'), len(made), counts[-1])
        if arguments.long:
            long = Path(name, 'long')
            long.mkdir()
            write(long, 9999, arguments.long, 'mcap')
            _compare(long, Path(name, 'of_long'), counts)


def _reading(paths: Sequence[Path], samples: int) -> None:
    """Print how fast each format is read and decoded."""
    print(f'{"reading alone":<24}{"samples/s":>12}{"MB/s":>8}')
    for path in paths:
        begin = time.process_time()
        with opened(str(path), TableFormat()) as recording:
            count = sum(1 for _ in (
                recording.samples({'/joint_states'}) if isinstance(recording, Recording)
                else recording.samples(KINDS)))
        seconds = time.process_time() - begin
        files = list(path.rglob('*')) if path.is_dir() else [path]
        size = sum(file.stat().st_size for file in files)
        form = FORMATS[int(re.findall(r'\d+', path.name)[0]) % len(FORMATS)]
        print(f'{form:<24}{count / seconds:>12,.0f}{size / seconds / 1e6:>8.1f}')
        assert count == samples


def _start(paths: Sequence[Path], output: Path, processes: int, first: int = 0,
           ) -> subprocess.Popen[str]:
    cores, parent = sorted(os.sched_getaffinity(0))[first:first + processes], os.getpid()

    def prepare() -> None:
        os.sched_setaffinity(0, cores)
        end_with_parent(parent)     # also where this one is killed outright

    return subprocess.Popen(
        [sys.executable, '-m', 'screw_kinematics', 'bag', *map(str, paths), '--robot', MODEL,
         '--output', str(output), '--format', 'dataset', '--processes', str(processes)],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, start_new_session=True,
        preexec_fn=prepare)


def _compare(folder: Path, outputs: Path, counts: Sequence[int]) -> None:
    """Print the rate of whole runs with some numbers of processes, and what they need."""
    rates = [_rate(folder, outputs / f'states{count}', count) for count in counts]
    print(f'{folder.name}: {counts[-1]} processes have {rates[-1] / rates[0]:.2f} times the rate '
          f'of {counts[0]}')
    paths = sorted(folder.iterdir())
    if counts[0] == 1 and len(paths) > counts[-1]:
        alone = _rate_of_programs(paths, outputs / 'alone', counts[-1])
        print(f'{folder.name}: {counts[-1]} programs of their own have {alone / rates[0]:.2f} '
              f'times the rate of one', flush=True)


def _rate(folder: Path, output: Path, processes: int) -> float:
    """Print the rate of a whole run, its processor time, and the largest process."""
    begin = time.monotonic()
    running = _start([folder], output, processes)
    family = Family(running.pid)
    _watch(running, output, len(list(folder.iterdir())), family)
    seconds = time.monotonic() - begin
    samples = _samples(running)
    print(f'{folder.name}, {processes} processes: {samples} samples in {seconds:.1f} s, '
          f'{samples / seconds:,.0f} samples/s; {samples / family.busy:,.0f} in a second of '
          f'processor time; waited {family.waited / processes:.1f} s each; largest process '
          f'{family.largest:.0f} MiB', flush=True)
    return samples / seconds


def _rate_of_programs(paths: Sequence[Path], output: Path, count: int) -> float:
    """Return the rate of programs that know nothing of each other, while all of them work."""
    begin = time.monotonic()
    running = [_start(paths[k::count], output / str(k), 1, k) for k in range(count)]
    return sum(_samples(program) / (time.monotonic() - begin) for program in running)


def _samples(running: subprocess.Popen[str]) -> int:
    """Wait for a run; return how many samples it made states of."""
    text = running.communicate()[0]
    return int(re.findall(r'^\d+ recordings +(\d+)', text, re.MULTILINE)[-1])


def _watch(running: subprocess.Popen[str], output: Path, whole: int, family: Family,
           until: int = sys.maxsize) -> int:
    """Show a bar while a run lasts, or until so many recordings are done; return how many are."""
    with Progress(console=_ERRORS, transient=True) as progress:
        bar = progress.add_task(output.name, total=whole)
        while running.poll() is None:
            family.look()
            done = len(list(output.glob('_done/*.json')))
            progress.update(bar, completed=done)
            if done >= until:
                break
            time.sleep(0.2)
    return len(list(output.glob('_done/*.json')))


def _restart(folder: Path, output: Path, whole: int, processes: int) -> None:
    """Interrupt a run in its middle; print what the next one still had to do."""
    running = _start([folder], output, processes)
    _watch(running, output, whole, Family(running.pid), whole // 2)
    os.killpg(running.pid, signal.SIGKILL)
    running.wait()
    done = {file: file.stat().st_mtime_ns for file in output.glob('_done/*.json')}
    begin = time.monotonic()
    running = _start([folder], output, processes)
    _watch(running, output, whole, Family(running.pid))
    text = running.stdout.read() if running.stdout else ''
    again = re.search(r'(\d+) of \d+ recordings are done and unchanged', text)
    now = {file: file.stat().st_mtime_ns for file in output.glob('_done/*.json')}
    print(f'killed when {len(done)} of {whole} were done; the next run found '
          f'{again[1] if again else 0} done, made {sum(now[f] != done.get(f) for f in now)} and '
          f'took {time.monotonic() - begin:.1f} s', flush=True)
    assert not list(output.glob('.*')), 'something unfinished was left'
    shutil.rmtree(output)


if __name__ == '__main__':
    main()
