# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
CPU time of the whole node for a Gough-Stewart platform at 500 Hz, over real DDS.

The platform moves in closed form; the lengths of its legs are published, and twist and
acceleration received. The node runs in a process of its own, once with the default estimator
and once with one that knows the exact rates: then its outputs are those of the exact motion.
The CPU time is that of the node as it is used; to know the exact motion costs time of its own.
"""
import argparse
from pathlib import Path
import statistics
import subprocess
import sys
import time

from benchmark.domain import own_domain
from geometry_msgs.msg import AccelStamped, TwistStamped
import numpy as np
import rclpy
from rclpy.experimental import EventsExecutor
from rich.console import Console
from rich.table import Table
from sensor_msgs.msg import JointState

TESTS = Path(__file__).parents[1] / 'test'
sys.path.insert(0, str(TESTS))

# The exact motion lives with the test of the node, which holds it to a bound.
from support import simulated_stewart as simulated    # noqa: E402

MODEL = 'package://screw_kinematics/config/robots/stewart_6ups.yaml'
PERIOD_NS, START_NS = 2_000_000, 100 * 10**9
PATIENCE = 120.0
KINDS = {'exact rates': 'kalman', 'default': 'bank'}
"""Estimators; in the process that runs ``simulated_stewart`` 'kalman' gives the exact rates."""


class Trial:
    """One run of the node."""

    def __init__(self, estimator: str) -> None:
        self._node = rclpy.create_node('parallel_driver')
        self._executor = EventsExecutor()
        self._executor.add_node(self._node)
        self.received: dict[str, list] = {'twist': [], 'accel': []}
        for name, kind in (('twist', TwistStamped), ('accel', AccelStamped)):
            self._node.create_subscription(kind, f'hexapod/{name}', self.received[name].append,
                                           1000)
        self._publisher = self._node.create_publisher(JointState, 'joint_states', 100)
        settings = {'robots': '[hexapod]', 'hexapod.description': MODEL,
                    'hexapod.estimator.kind': KINDS[estimator]}
        self._process = subprocess.Popen(
            [sys.executable, str(TESTS / 'support' / 'simulated_stewart.py'), '--ros-args', *(
                word for key, value in settings.items() for word in ('-p', f'{key}:={value}'))])
        self._clock = (~self._process.pid << 3) | 2     # clock_getcpuclockid(3)
        self._count = 0

    def run(self, samples: int) -> tuple[float, int, int, dict[str, float]]:
        """Return CPU time of a message [s], messages, outputs, and largest errors."""
        try:
            self._until(lambda: self._publisher.get_subscription_count() > 0)
            self._until(lambda: all(self.received.values()), self._send)
            busy = True
            while busy:     # machine code is being made
                cpu = time.clock_gettime(self._clock)
                self._spin(time.monotonic() + 0.5)
                busy = time.clock_gettime(self._clock) - cpu > 0.05
            self._play(500)
            for messages in self.received.values():
                messages.clear()
            cpu = time.clock_gettime(self._clock)
            self._play(samples)
            cpu = time.clock_gettime(self._clock) - cpu
            outputs = min(map(len, self.received.values()))
            return cpu / samples, samples, outputs, self._errors()
        finally:
            self._process.terminate()
            self._process.wait(PATIENCE)
            self._node.destroy_node()

    def _send(self) -> None:
        stamp = START_NS + self._count * PERIOD_NS
        self._count += 1
        message = JointState(name=simulated.LEGS)
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
        message.position = simulated.legs(stamp * 1e-9)[0].tolist()
        self._publisher.publish(message)

    def _play(self, samples: int) -> None:
        begin = time.monotonic()
        for k in range(1, samples + 1):
            self._send()
            self._spin(begin + k * PERIOD_NS * 1e-9)
        self._spin(time.monotonic() + 0.3)

    def _spin(self, until: float) -> None:
        while (left := until - time.monotonic()) > 0:
            self._executor.spin_once(left)

    def _until(self, condition, each=lambda: None) -> None:    # type: ignore[no-untyped-def]
        deadline = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > deadline or self._process.poll() is not None:
                raise RuntimeError('the node does not answer')
            each()
            self._spin(time.monotonic() + 0.01)

    def _errors(self) -> dict[str, float]:
        out = {}
        for name, row in (('twist', 2), ('accel', 3)):
            worst = 0.0
            for message in self.received[name]:
                stamp, content = message.header.stamp, getattr(message, name)
                exact = simulated.platform((stamp.sec * 10**9 + stamp.nanosec) * 1e-9)[row]
                found = [getattr(part, axis) for part in (content.angular, content.linear)
                         for axis in 'xyz']
                worst = max(worst, float(np.abs(found - exact).max()))
            out[name] = worst
        return out


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(
        prog='python -m benchmark.parallel_node', description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--seconds', type=float, default=4.0, help='of each trial')
    parser.add_argument('--rounds', type=int, default=3)
    options = parser.parse_args()
    table = Table('estimator', 'CPU per message, ms', 'messages', 'outputs', 'largest error of '
                  'the twist', 'of the acceleration')
    with own_domain():
        rclpy.init()
        rounds = [[Trial(kind).run(round(options.seconds * 1e9 / PERIOD_NS)) for kind in KINDS]
                  for _ in range(options.rounds)]
        rclpy.try_shutdown()
    for kind, trials in zip(KINDS, zip(*rounds)):
        cpu, messages, outputs, errors = zip(*trials)
        table.add_row(
            kind, '-' if kind != 'default' else f'{statistics.median(cpu) * 1e3:.3f} '
            f'({min(cpu) * 1e3:.3f}-{max(cpu) * 1e3:.3f})', str(sum(messages)), str(sum(outputs)),
            *(f'{max(e[name] for e in errors):.1e}' for name in ('twist', 'accel')))
    Console(width=110).print(table)


if __name__ == '__main__':
    main()
