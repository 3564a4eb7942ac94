# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Make backlogs on purpose: what stands still, with which queues, and how the node comes back.

Robots at 1 kHz. By default the inputs are best effort and keep the last 1000 messages; the
other queues are reliable and keep all.
"""
import argparse
from collections.abc import Callable
import os
from pathlib import Path
import signal
import subprocess
import sys
import tempfile
import time

from rich.table import Table

from .field.recovery import Recovery, recovery
from .field.rig import Rig
from .printing import console
from ..domain import own_domain

DEEP = {'history': 'keep_last', 'reliability': 'reliable', 'depth': 100_000}
QUEUES: dict[str, dict[str, object]] = {'the default': {}, 'reliable, 100,000 deep': DEEP}
BUSY = 'while True: pass'


def stopped(of: Callable[[Rig], int], seconds: float) -> Callable[[Rig], None]:
    """Return what stops a process for some time."""
    def stop(rig: Rig) -> None:
        os.kill(of(rig), signal.SIGSTOP)
        rig.spin(seconds)
        os.kill(of(rig), signal.SIGCONT)
    return stop


def busy(seconds: float) -> Callable[[Rig], None]:
    """Return what has processes take all cores for some time."""
    def take(rig: Rig) -> None:
        others = [subprocess.Popen([sys.executable, '-c', BUSY])
                  for _ in range(2 * (os.cpu_count() or 1))]
        rig.spin(seconds)
        for other in others:
            other.kill()
            other.wait()
    return take


def listener_stopped(seconds: float) -> Callable[[Rig], None]:
    """Return what stops a reliable subscriber of all outputs for some time."""
    def stop(rig: Rig) -> None:
        with rig.another_listener() as listener:
            os.kill(listener.pid, signal.SIGSTOP)
            rig.spin(seconds)
            os.kill(listener.pid, signal.SIGCONT)
            rig.spin(1.0)
    return stop


def main() -> int:
    """Make the backlogs, and print a table; return the exit code."""
    parser = argparse.ArgumentParser(
        prog='python -m benchmark.soak.backlog', description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--seconds', type=float, default=5.0, help='of each standstill')
    parser.add_argument('--limit', type=float, default=60.0,
                        help='longest wait for outputs that are on time [s]')
    parser.add_argument('--robots', type=int, default=4, choices=range(1, 5),
                        help='fewer for machines that have other work')
    parser.add_argument('--only', default='', metavar='TEXT',
                        help='only what contains this')
    options = parser.parse_args()
    causes: dict[str, Callable[[Rig], None]] = {
        'nothing': lambda rig: rig.spin(options.seconds),
        'the node': stopped(lambda rig: rig.node.pid, options.seconds),
        'the publishers': stopped(lambda rig: rig.drivers.pid, options.seconds),
        'nothing, but other processes take all cores': busy(options.seconds),
        'a subscriber of the outputs': listener_stopped(options.seconds)}
    table = Table('stood still', 'queues', 'on time after', 'messages lost', 'greatest latency',
                  'outputs a second', title=f'{options.seconds:g} s each')
    begin, late = time.monotonic(), False
    for queues, qos in QUEUES.items():
        with own_domain(), tempfile.TemporaryDirectory() as folder:
            rig = Rig(Path(folder), 1e9, qos, options.robots)
            try:
                rig.spin(5.0)
                for cause, standstill in causes.items():
                    if options.only not in cause:
                        continue
                    found = recovery(rig, lambda: standstill(rig), options.limit)
                    print(f'{time.monotonic() - begin:7.1f} s  {queues}: {cause}: {found}',
                          flush=True)
                    table.add_row(cause, queues, *_cells(found))
                    late |= not qos and found.on_time_after > options.limit
                    rig.spin(3.0)
            finally:
                rig.close()
    console().print(table)
    return int(late)


def _cells(found: Recovery) -> list[str]:
    return [f'{found.on_time_after:.2f} s', f'{found.lost:,}', f'{found.worst:.2f} s',
            f'{found.rate:,.0f}']


if __name__ == '__main__':
    sys.exit(main())
