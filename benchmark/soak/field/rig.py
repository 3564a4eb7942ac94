# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The node, the drivers, and the side that listens to the node."""
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
import os
from pathlib import Path
import subprocess
import sys
import time
from types import MappingProxyType
from typing import Any

from geometry_msgs.msg import AccelWithCovarianceStamped, PoseStamped, TwistWithCovarianceStamped
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile

from .checks import Sent, TopicCheck
from .log import SentLog
from .robots import DESCRIPTIONS, OUTPUTS, ROBOTS
from ..books import Account, account_of, parts_of
from ..listening import Listening

KINDS = dict(zip(OUTPUTS, (TwistWithCovarianceStamped, AccelWithCovarianceStamped)))
OUTPUT_DEPTH = 2000
"""So that an output waits for a checker that is busy."""


class Rig(Listening):
    """
    Everything that runs, and what it is told.

    A clock is set every so many seconds; queues are the quality of service of the node's inputs,
    and as deep are those of the publishers.
    """

    def __init__(self, directory: Path, every: float,
                 queues: Mapping[str, object] = MappingProxyType({}),
                 robots: int = len(ROBOTS)) -> None:
        super().__init__('field_soak', directory)
        self.robots = ROBOTS[:robots]
        self.models = [{0} for _ in self.robots]    # that may be in use
        self.during = 'the start'
        # Time [s, monotonic], memory [KiB] and CPU time [s] of the node, each second.
        self.usage: list[tuple[float, float, float]] = []
        log = SentLog(directory / 'sent', len(self.robots))
        self._published = log.counts[:, 0]
        self._sent = [Sent(log, k) for k in range(len(self.robots))]
        self.checks = {(k, output): TopicCheck(robot, output, self._sent[k])
                       for k, robot in enumerate(self.robots) for output in OUTPUTS}
        self._qos = QoSProfile(depth=OUTPUT_DEPTH)
        for (k, output), check in self.checks.items():
            self._here.create_subscription(
                KINDS[output], f'{self.robots[k].name}/{output}', check.take, self._qos, raw=True)
        self.describe(DESCRIPTIONS[0])
        self._setter = self._here.create_client(
            SetParametersAtomically, 'kinematic_state_publisher/set_parameters_atomically')
        self.start_node(self._parameters(queues))
        self.wait(lambda: all(
            self.parts.get(r.name, {}).get('outputs listened to') == ', '.join(OUTPUTS)
            for r in self.robots), 'the node to serve all outputs')
        self.drivers = self.start('drivers', [
            sys.executable, '-m', 'benchmark.soak.field.drivers', str(directory / 'sent'),
            str(time.time_ns()), str(every), str(queues.get('depth', 1000)),
            str(robots)])
        self.wait(lambda: all(c.tally.received for c in self.checks.values()), 'outputs')

    def _parameters(self, queues: Mapping[str, object]) -> dict[str, Any]:
        keep = {'history': 'keep_last', 'reliability': 'reliable', 'depth': OUTPUT_DEPTH}
        return {'robots': [robot.name for robot in self.robots], 'diagnostics_rate': 5.0,
                **{robot.name: robot.parameters for robot in self.robots},
                'qos_overrides': {f'/{robot.name}/{output}': {'publisher': keep}
                                  for robot in self.robots for output in OUTPUTS} | {
                    f'/{robot.name}/joints': {'subscription': dict(queues)}
                    for robot in self.robots if queues}}

    # What is done

    def command(self, name: str, *arguments: Any) -> None:
        """Have the drivers do something."""
        self.tell(self.drivers, name, *arguments)

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
        name = self.robots[robot].name
        more = [self._here.create_subscription(PoseStamped, f'{name}/pose', _ignore, 10, raw=True)]
        return more + [self._here.create_subscription(
            KINDS[output], f'{name}/{output}', _ignore, 10, raw=True) for output in OUTPUTS]

    @contextmanager
    def another_listener(self) -> Iterator[subprocess.Popen[bytes]]:
        """Give a process that listens reliably to all outputs; end it."""
        log = self._directory / 'listener.log'
        process = self.start('listener', [
            sys.executable, '-m', 'benchmark.soak.field.listener', str(len(self.robots))])
        try:
            self.wait(lambda: 'listening' in log.read_text(), 'another listener')
            yield process
        finally:
            process.kill()
            process.wait()

    def stop_listening(self, subscriptions: Any) -> None:
        """Listen no more."""
        for subscription in subscriptions:
            self._here.destroy_subscription(subscription)

    # Listening

    def check_outputs(self) -> None:
        """Check the outputs that have arrived."""
        for sent in self._sent:
            sent.update()
        for (robot, _), check in self.checks.items():
            check.check(self.models[robot], self.during)

    def look(self) -> None:
        """See how much memory and time the node takes; each second."""
        pages = int(Path(f'/proc/{self.node.pid}/statm').read_text().split()[1])
        # CPU time of another process: clock_getcpuclockid(3)
        self.usage.append((time.monotonic(), pages * os.sysconf('SC_PAGE_SIZE') / 1024,
                           time.clock_gettime((~self.node.pid << 3) | 2)))

    @property
    def parts(self) -> dict[str, dict[str, str]]:
        """Return all values that the node reports."""
        return parts_of(self.diagnostics)

    def accounts(self) -> list[Account]:
        """Return the latest account of each robot."""
        parts = self.parts
        return [account_of(robot.name, f'/{robot.name}/joints', parts) for robot in self.robots]

    def published(self) -> list[int]:
        """Return how many messages were published for each robot."""
        return [int(count) for count in self._published]

    def close(self) -> int:
        """End everything; return the exit code of the node."""
        return self.end(self.drivers)


def _ignore(_: bytes) -> None:
    pass
