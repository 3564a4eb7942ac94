# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Measure the tool bag on many recordings: rate by processes, memory, restart, reading alone.

Seven joints, all formats mixed, three recordings cut off. A run has as many cores as processes:
else reading tables would have another one, where there is but one process. Runs take turns of ten
seconds, halted between them, so that what else the machine does falls on all alike. It takes half
an hour; --recordings 40 and --long 200000 give nearly the same rates in minutes.
Beside them as many programs of their own, each with its share of the recordings on a core of its
own: what the machine gives, since cores may share more than the memory.
Of each run: the rate, the samples in a second of processor time, how many seconds processes that
could have worked waited for a processor, each, and the memory of the largest of them.
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
import re
import shutil
import tempfile
import time

from rich.console import Console
from rich.progress import track

from .recordings import damage, FORMATS, JOINTS, write
from .runs import LOOK, Run, take_turns
from screw_kinematics.recordings.joint_table import TableFormat
from screw_kinematics.recordings.recording import Recording
from screw_kinematics.recordings.sources import opened

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


def _compare(folder: Path, outputs: Path, counts: Sequence[int]) -> None:
    """Print the rates of whole runs with some numbers of processes, and what they need."""
    paths = sorted(folder.iterdir())
    runs = [Run([folder], outputs / f'states{count}', count) for count in counts]
    alone = [Run(paths[k::counts[-1]], outputs / 'alone' / str(k), 1, k)
             for k in range(counts[-1] if len(paths) > counts[-1] else 0)]
    take_turns([*([run] for run in runs), *([alone] if alone else [])], len(paths), _ERRORS)
    for run in runs:
        family = run.family
        print(f'{folder.name}, {run.processes} processes: {run.samples} samples in '
              f'{run.seconds:.1f} s, {run.rate:,.0f} samples/s; '
              f'{run.samples / family.busy:,.0f} in a second of processor time; waited '
              f'{family.waited / run.processes:.1f} s each; largest process '
              f'{family.largest:.0f} MiB')
    print(f'{folder.name}: {counts[-1]} processes have {runs[-1].rate / runs[0].rate:.2f} times '
          f'the rate of {counts[0]}', flush=True)
    if alone and counts[0] == 1:
        print(f'{folder.name}: {counts[-1]} programs of their own have '
              f'{sum(run.rate for run in alone) / runs[0].rate:.2f} times the rate of one',
              flush=True)


def _restart(folder: Path, output: Path, whole: int, processes: int) -> None:
    """Interrupt a run in its middle; print what the next one still had to do."""
    first = Run([folder], output, processes)
    first.go_on()
    while len(first.done) < whole // 2:
        time.sleep(LOOK)
    first.kill()
    done = first.done
    again = Run([folder], output, processes)
    take_turns([[again]], whole, _ERRORS)
    found = re.search(r'(\d+) of \d+ recordings are done and unchanged', again.text)
    made = sum(written != done.get(file) for file, written in again.done.items())
    print(f'killed when {len(done)} of {whole} were done; the next run found '
          f'{found[1] if found else 0} done, made {made} and took {again.seconds:.1f} s',
          flush=True)
    assert not list(output.glob('.*')), 'something unfinished was left'
    shutil.rmtree(output)


if __name__ == '__main__':
    main()
