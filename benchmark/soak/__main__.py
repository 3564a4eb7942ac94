# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Run the node for a long time with faults at random, over real DDS, and check every output.

Ends with code 0 if every message was accounted for, every output was right, and the memory
of the node did not grow.
"""
import argparse
from pathlib import Path
import sys
import tempfile

from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from .faults import FAULTS
from .printing import conclude, console, look_for_tracebacks, write
from .rig import Rig
from .soak import Result, Soak
from ..domain import own_domain


def main() -> int:
    """Run a soak from the command line; return the exit code."""
    parser = argparse.ArgumentParser(
        prog='python -m benchmark.soak', description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--minutes', type=float, default=1.0)
    parser.add_argument('--rate', type=int, default=1000, choices=(100, 125, 200, 250, 500, 1000),
                        help='samples of each robot in a second')
    parser.add_argument('--calm', type=float, default=5.0, help='seconds after each fault')
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--only', nargs='+', metavar='TEXT', default=[''],
                        help='only faults whose name contains one of these')
    parser.add_argument('--relay', action='store_true',
                        help='run a bare relay beside the node, to compare its memory')
    parser.add_argument('--json', type=Path,
                        help='file for all figures, brought up to date after each fault')
    options = parser.parse_args()
    names = [name for name in FAULTS if any(text in name for text in options.only)]
    screen = console()
    seconds = options.minutes * 60
    with own_domain(), tempfile.TemporaryDirectory() as folder:
        with Progress(TextColumn('{task.description:36}'), BarColumn(), TimeElapsedColumn(),
                      TimeRemainingColumn(), console=screen, refresh_per_second=1) as progress:
            task = progress.add_task('', total=seconds)

            def tell(text: str) -> None:
                elapsed = progress.tasks[0].elapsed or 0.0
                progress.update(task, description=text, completed=elapsed)
                if not screen.is_terminal:
                    print(f'{elapsed:7.1f} s  {text}', flush=True)
                if options.json:
                    write(soak.result, options.json)

            rig = Rig(Path(folder), options.rate, options.seed, options.relay)
            soak = Soak(rig, options.seed, options.calm, tell)
            result = soak.run(seconds, names)
        look_for_tracebacks(result, Path(folder), 'node')
    return conclude(screen, result, tables(result), options.json)


def tables(result: Result) -> list[Table]:
    """Return the figures of a soak for reading."""
    faults = Table('fault', 'times', 'messages', 'outputs', 'otherwise used', 'refused',
                   'lost with source', 'outcome', title=f'{result.minutes:.1f} minutes')
    for name, f in result.faults.items():
        if f.times:
            faults.add_row(name, str(f.times), *(f'{n:,}' for n in (
                f.published, f.outputs, f.used_otherwise, f.refused, f.lost_with_source)),
                '; '.join(f.failures[:3]) or 'all accounted for, all right')
    outputs = Table('output', 'received', 'exact', 'worst error', 'estimates', 'worst error',
                    'not settled', 'wrong')
    for name, t in result.tallies.items():
        outputs.add_row(name, f'{t.received:,}', f'{t.exact:,}', f'{t.worst_exact:.1e}',
                        f'{t.estimated:,}', f'{t.worst_estimate:.1e}', f'{t.unsettled:,}',
                        str(t.failures))
    reasons = Table('why refused, or used otherwise', *result.restarts)
    counts = [a.refused + a.of_topic + a.waiting for a in result.accounts]
    for reason in sorted(set().union(*counts)):
        reasons.add_row(reason, *(f'{c[reason]:,}' for c in counts))
    summary = Table('', 'figure')
    summary.add_row('memory of the node', result.memory.told())
    if result.relay_memory.samples:
        summary.add_row('memory of a bare relay beside it', result.relay_memory.told())
    summary.add_row('latency in calm times: p50, p99, worst', ', '.join(
        f'{x * 1e3:.2f} ms' for x in (
            result.latency_p50, result.latency_p99, result.latency_worst)))
    summary.add_row('worst latency, bursts and the like included',
                    f'{result.latency_worst_in_faults * 1e3:.0f} ms')
    summary.add_row('stopped subscribers that were cut off', str(result.deaf_subscribers))
    summary.add_row('estimators started anew', '; '.join(
        f'{name}: ' + ', '.join(f'{why} {n}' for why, n in r.items())
        for name, r in result.restarts.items() if r))
    return [faults, outputs, reasons, summary]


if __name__ == '__main__':
    sys.exit(main())
