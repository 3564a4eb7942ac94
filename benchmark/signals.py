# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
End the node by signals under load, again and again, and start it anew.

The node computes twist and acceleration of a 7R arm from joint states at a rate that does not
stop when it ends. SIGINT and SIGTERM, at a random moment after the first output, must end it with
code 0 and nothing of a traceback; after SIGKILL the next one must work. No process may be
left. Ends with code 0 if all that holds.
"""
import argparse
from collections import Counter
from collections.abc import Callable
import os
from pathlib import Path
from random import Random
import signal
import statistics
import subprocess
import sys
import tempfile
import time

from geometry_msgs.msg import AccelStamped, TwistStamped
import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.qos import QoSProfile
from rich.console import Console
from rich.progress import track
from rich.table import Table
from sensor_msgs.msg import JointState

from .domain import own_domain
from .node.contenders import SCRIPTED
from .node.robot import Driver

NAMES = ('SIGINT', 'SIGTERM', 'SIGKILL')
PATIENCE = 60.0     # s
OURS = next(contender for contender in SCRIPTED if contender.name.startswith('ours'))


class Trials:
    """Starts and ends nodes, which write a log, while joint states are published at a rate."""

    def __init__(self, rate: int, seed: int, log: Path) -> None:
        self._random, self._log = Random(seed), log
        self._period = 1.0 / rate
        self._driver = Driver(seed)
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self._node = rclpy.create_node('signals', context=self._context)
        publisher = self._node.create_publisher(
            JointState, 'r0/joint_states', QoSProfile(depth=100))
        self._publish, self._listeners = publisher.publish, publisher.get_subscription_count
        self._outputs = 0
        for output, kind in (('twist', TwistStamped), ('accel', AccelStamped)):
            self._node.create_subscription(kind, f'r0/{output}', self._count, 100, raw=True)
        self._executor = EventsExecutor(context=self._context)
        self._executor.add_node(self._node)

    def run(self, name: str) -> tuple[str, float]:
        """Return what is wrong about one start and end, if anything, and how long it took."""
        self._become_silent()
        with open(self._log, 'w') as log:
            process = subprocess.Popen(
                OURS.command(1), stdout=log, stderr=subprocess.STDOUT, start_new_session=True)
        try:
            before = self._outputs
            if not self._feed(lambda: self._outputs > before or process.poll() is not None):
                return self._why_no_output(process), 0.0
            end = time.monotonic() + self._random.uniform(0.0, 0.5)
            self._feed(lambda: time.monotonic() > end)
            process.send_signal(signal.Signals[name])
            sent = time.monotonic()
            if not self._feed(lambda: process.poll() is not None):
                return 'does not end', 0.0
            took = time.monotonic() - sent
        finally:
            process.kill()
            process.wait()
        expected = -signal.SIGKILL if name == 'SIGKILL' else 0
        text = self._log.read_text(errors='replace')
        if process.returncode != expected:
            return f'code {process.returncode}: {text[-1000:]}', took
        if 'Traceback' in text:
            return f'traceback: {text[-1000:]}', took
        if _group_is_alive(process.pid):
            return 'left a process', took
        return '', took

    def close(self) -> None:
        """End the driving side."""
        self._executor.shutdown()
        self._node.destroy_node()
        self._context.try_shutdown()

    def _why_no_output(self, process: subprocess.Popen) -> str:
        """Return how far a node has come that gave no output."""
        heard = self._listeners()
        offered = [self._node.count_publishers(f'r0/{output}') for output in OURS.outputs]
        process.kill()
        log = self._log.read_text(errors='replace')[-1000:]
        return (f'no output within {PATIENCE:g} s: {heard} listen to the joint states, '
                f'{offered} offer the outputs; {log}')

    def _feed(self, condition: Callable[[], bool]) -> bool:
        """Publish until a condition holds; return whether it does."""
        due = time.monotonic()
        limit = due + PATIENCE
        while not condition():
            now = time.monotonic()
            if now > limit:
                return False
            if now >= due:
                self._publish(self._driver.message())
                # Where the processor is busy elsewhere nothing is made up for.
                due = max(due + self._period, now)
            self._executor.spin_once(max(0.0, due - now))
        return True

    def _become_silent(self) -> None:
        """Take what is left of the last node."""
        before = -1
        while self._outputs != before:
            before = self._outputs
            end = time.monotonic() + 0.2
            while (left := end - time.monotonic()) > 0:
                self._executor.spin_once(left)

    def _count(self, data: bytes) -> None:
        self._outputs += 1


def _group_is_alive(group: int) -> bool:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def main() -> int:
    """Run from the command line; return the exit code."""
    parser = argparse.ArgumentParser(
        prog='python -m benchmark.signals', description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--times', type=int, default=50, help='of each signal')
    parser.add_argument('--rate', type=int, default=1000, help='joint states in a second')
    parser.add_argument('--seed', type=int, default=1)
    options = parser.parse_args()
    # A shell's background jobs ignore SIGINT, and so would their children.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    console = Console()
    problems: dict[str, Counter[str]] = {name: Counter() for name in NAMES}
    durations: dict[str, list[float]] = {name: [] for name in NAMES}
    with own_domain(), tempfile.TemporaryDirectory() as directory:
        trials = Trials(options.rate, options.seed, Path(directory, 'log'))
        for _ in track(range(options.times), 'signals', console=console):
            for name in NAMES:
                problem, took = trials.run(name)
                durations[name].append(took)
                if problem:
                    problems[name][problem] += 1
        # After the last SIGKILL, too.
        last, _ = trials.run('SIGINT')
        trials.close()
    table = Table('signal', 'times', 'time to end, median (greatest)', 'outcome')
    for name in NAMES:
        worst, median = max(durations[name]), statistics.median(durations[name])
        good = 'ended, the next one worked' if name == 'SIGKILL' else 'code 0, no traceback'
        table.add_row(name, str(options.times), f'{median:.3f} s ({worst:.3f} s)',
                      '; '.join(f'{n} times {p}' for p, n in problems[name].items()) or good)
    console.print(table)
    if last:
        console.print(f'the last start: {last}', markup=False)
    return 1 if last or any(problems.values()) else 0


if __name__ == '__main__':
    sys.exit(main())
