# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Run the node with four robots at 1 kHz, each stamped in another way of the field.

Messages are dropped, doubled, swapped, malformed and partial among them, parameters changed,
publishers restarted, a description replaced, the node stopped for 5 s twice, listeners coming
and going. Ends with code 0 if no output was wrong by more than ten times the deviation that it
states, none had a stamp that no message had, every message was used or refused with a reason,
memory and CPU time stayed what they were, and the node ended well.
"""
import argparse
from pathlib import Path
import sys
import tempfile
import time

from rich.table import Table

from .course import Course, EVENTS, Result
from .rig import Rig
from .robots import ROBOTS
from ..printing import conclude, console, look_for_tracebacks
from ...domain import own_domain


def main() -> int:
    """Run a field soak from the command line; return the exit code."""
    parser = argparse.ArgumentParser(
        prog='python -m benchmark.soak.field', description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--minutes', type=float, default=1.0)
    parser.add_argument('--every', type=float, default=120.0, metavar='SECONDS',
                        help='time between two settings of the clock that is set (default: 120)')
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--only', nargs='+', metavar='TEXT', default=[''],
                        help='of what happens beside the stops, only what contains one of these')
    parser.add_argument('--json', type=Path, help='file for all figures')
    options = parser.parse_args()
    events = [name for name in EVENTS if any(text in name for text in options.only)]
    if not events:
        parser.error(f'--only: one of {", ".join(EVENTS)}')
    begin = time.monotonic()

    def tell(text: str) -> None:
        print(f'{time.monotonic() - begin:7.1f} s  {text}', flush=True)

    with own_domain(), tempfile.TemporaryDirectory() as folder:
        course = Course(Rig(Path(folder), options.every), options.seed, tell, events)
        result = course.run(options.minutes * 60)
        look_for_tracebacks(result, Path(folder), 'node', 'drivers')
    return conclude(console(), result, tables(result), options.json)


def tables(result: Result) -> list[Table]:
    """Return the figures for reading."""
    robots = Table('robot', 'stamps', 'published', 'received', 'used', 'refused',
                   title=f'{result.minutes:.1f} minutes: ' + ', '.join(
                       f'{name} {n}' for name, n in result.events.items()))
    for robot, published, a in zip(ROBOTS, result.published, result.accounts):
        robots.add_row(robot.name, (robot.way.__doc__ or '').strip(), f'{published:,}',
                       f'{a.on_topic:,}', f'{a.used:,}', ', '.join(
                           f'{reason} {n:,}' for reason, n in (a.refused + a.of_topic).items()))
    outputs = Table('output', 'received', 'judged', 'usual error', 'worst error', 'beyond 10',
                    'strange stamps', 'not finite', title='errors in deviations as stated')
    for name, t in result.tallies.items():
        outputs.add_row(name, f'{t.received:,}', f'{t.judged:,}', f'{t.usual:.2f}',
                        f'{t.worst:.2f}', *(str(n) for n in (t.beyond, t.strange, t.not_finite)))
    summary = Table('', 'figure')
    for number, stop in enumerate(result.stops, start=1):
        summary.add_row(f'stop {number} of the node', str(stop))
    summary.add_row('latency', ', '.join(
        f'{share} {1e3 * late:.2f} ms' for share, late in result.latency.items()))
    summary.add_row('memory by quarters', ', '.join(f'{m / 1024:.1f}' for m in result.memory)
                    + f' MiB; growth after a minute {result.growth:.0f} KiB')
    summary.add_row('CPU by quarters', ', '.join(f'{100 * c:.0f} %' for c in result.cpu))
    return [robots, outputs, summary]


if __name__ == '__main__':
    sys.exit(main())
