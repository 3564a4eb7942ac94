# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The node, the drivers, and the side that listens to the node."""
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import AccelWithCovarianceStamped, PoseStamped, TwistWithCovarianceStamped
from rcl_interfaces.srv import SetParametersAtomically
import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String

from .checks import Sent, TopicCheck
from .log import SentLog
from .robots import DESCRIPTIONS, OUTPUTS, ROBOTS
from ..books import Account, account_of, parts_of
from ..rig import Broken, CHECK_PERIOD, NODE, PATIENCE

KINDS = dict(zip(OUTPUTS, (TwistWithCovarianceStamped, AccelWithCovarianceStamped)))
OUTPUT_DEPTH = 2000
"""So that an output waits for a checker that is busy."""


class Rig:
    """
    Everything that runs, and what it is told.

    Parameters
    ----------
    directory : Path
        For parameters, logs, and what the drivers have sent.
    every : float
        Seconds between two settings of a clock.

    Attributes
    ----------
    models : list of set of int
        For each robot the models that may be in use.
    during : str
        What is going on.
    usage : list of (float, float, float)
        Time [s, monotonic], memory [KiB] and CPU time [s] of the node, each second.

    """

    def __init__(self, directory: Path, every: float) -> None:
        self.models = [{0} for _ in ROBOTS]
        self.during = 'the start'
        self.usage: list[tuple[float, float, float]] = []
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self._node = rclpy.create_node('field_soak', context=self._context)
        self._executor = EventsExecutor(context=self._context)
        self._executor.add_node(self._node)
        log = SentLog(directory / 'sent', len(ROBOTS))
        self._published = log.counts[:, 0]
        self._sent = [Sent(log, k) for k in range(len(ROBOTS))]
        self.checks = {(k, output): TopicCheck(robot, output, self._sent[k])
                       for k, robot in enumerate(ROBOTS) for output in OUTPUTS}
        self._qos = QoSProfile(depth=OUTPUT_DEPTH)
        for (k, output), check in self.checks.items():
            self._node.create_subscription(
                KINDS[output], f'{ROBOTS[k].name}/{output}', check.take, self._qos, raw=True)
        self._parts: dict[str, dict[str, str]] = {}
        self._node.create_subscription(DiagnosticArray, '/diagnostics', self._report, 10)
        self._describe = self._node.create_publisher(String, 'robot_description', QoSProfile(
            depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
        self.describe(DESCRIPTIONS[0])
        self._setter = self._node.create_client(
            SetParametersAtomically, 'kinematic_state_publisher/set_parameters_atomically')
        self._logs = {name: open(directory / f'{name}.log', 'ab') for name in ('node', 'drivers')}
        file = directory / 'parameters.yaml'
        file.write_text(json.dumps({'/**': {'ros__parameters': self._parameters()}}))
        self.node = self._start('node', [*NODE, '--ros-args', '--params-file', str(file)])
        self._next_check = self._next_look = 0.0
        self.wait(lambda: all(
            self._parts.get(r.name, {}).get('outputs listened to') == ', '.join(OUTPUTS)
            for r in ROBOTS), 'the node to serve all outputs')
        self._drivers = self._start('drivers', [
            sys.executable, '-m', 'benchmark.soak.field.drivers', str(directory / 'sent'),
            str(time.time_ns()), str(every)])
        self.wait(lambda: all(c.tally.received for c in self.checks.values()), 'outputs')

    def _start(self, name: str, command: list[str]) -> subprocess.Popen[bytes]:
        return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=self._logs[name],
                                stderr=subprocess.STDOUT, env=os.environ)

    @staticmethod
    def _parameters() -> dict[str, Any]:
        keep = {'history': 'keep_last', 'reliability': 'reliable', 'depth': OUTPUT_DEPTH}
        return {'robots': [robot.name for robot in ROBOTS], 'diagnostics_rate': 5.0,
                **{robot.name: robot.parameters for robot in ROBOTS},
                'qos_overrides': {f'/{robot.name}/{output}': {'publisher': keep}
                                  for robot in ROBOTS for output in OUTPUTS}}

    # What is done

    def command(self, name: str, *arguments: Any) -> None:
        """Have the drivers do something."""
        assert self._drivers.stdin is not None
        self._drivers.stdin.write((json.dumps([name, *arguments]) + '\n').encode())
        self._drivers.stdin.flush()

    def describe(self, text: str) -> None:
        """Publish a robot description."""
        self._describe.publish(String(data=text))

    def set_parameters(self, values: dict[str, Any]) -> None:
        """Set parameters of the node; raise RuntimeError if it refuses."""
        self.wait(self._setter.service_is_ready, 'the parameter service')
        future = self._setter.call_async(SetParametersAtomically.Request(parameters=[
            Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]))
        self.wait(future.done, 'parameters to be set')
        result = future.result().result
        if not result.successful:
            raise RuntimeError(f'{values} refused: {result.reason}')

    def listen(self, robot: int) -> Any:
        """Listen to one more output for a while; return the subscriptions."""
        name = ROBOTS[robot].name
        more = [self._node.create_subscription(PoseStamped, f'{name}/pose', _ignore, 10, raw=True)]
        return more + [self._node.create_subscription(
            KINDS[output], f'{name}/{output}', _ignore, 10, raw=True) for output in OUTPUTS]

    def stop_listening(self, subscriptions: Any) -> None:
        """Listen no more."""
        for subscription in subscriptions:
            self._node.destroy_subscription(subscription)

    # Listening

    def spin(self, seconds: float) -> None:
        """Take what arrives, and check it now and then."""
        end = time.monotonic() + seconds
        while (now := time.monotonic()) < end:
            self._executor.spin_once(min(0.02, end - now))
            if now >= self._next_check:
                self.check()
                self._next_check = time.monotonic() + CHECK_PERIOD

    def wait(self, condition: Any, what: str, limit: float = PATIENCE) -> None:
        """Wait for a condition; raise Broken if it never comes."""
        end = time.monotonic() + limit
        while not condition():
            if time.monotonic() > end:
                raise Broken(f'waited {limit:g} s in vain for {what}')
            self.spin(0.05)

    def check(self) -> None:
        """Check the outputs that have arrived, and look after the node."""
        for sent in self._sent:
            sent.update()
        for (robot, _), check in self.checks.items():
            check.check(self.models[robot], self.during)
        if self.node.poll() is not None:
            raise Broken(f'the node ended with code {self.node.returncode}')
        now = time.monotonic()
        if now >= self._next_look:
            self._next_look = now + 1.0
            pages = int(Path(f'/proc/{self.node.pid}/statm').read_text().split()[1])
            # CPU time of another process: clock_getcpuclockid(3)
            self.usage.append((now, pages * os.sysconf('SC_PAGE_SIZE') / 1024,
                               time.clock_gettime((~self.node.pid << 3) | 2)))

    def _report(self, array: DiagnosticArray) -> None:
        self._parts = parts_of(array)

    @property
    def parts(self) -> dict[str, dict[str, str]]:
        """Return all values that the node reports."""
        return self._parts

    def accounts(self) -> list[Account]:
        """Return the latest account of each robot."""
        return [account_of(robot.name, f'/{robot.name}/joints', self._parts) for robot in ROBOTS]

    def published(self) -> list[int]:
        """Return how many messages were published for each robot."""
        return [int(count) for count in self._published]

    def close(self) -> int:
        """End everything; return the exit code of the node."""
        self._drivers.kill()
        self._drivers.wait()
        self.node.send_signal(signal.SIGINT)
        try:
            code = self.node.wait(30)
        except subprocess.TimeoutExpired:
            self.node.kill()
            code = self.node.wait()
        for log in self._logs.values():
            log.close()
        self._executor.shutdown()
        self._node.destroy_node()
        self._context.try_shutdown()
        return code


def _ignore(_: bytes) -> None:
    pass
