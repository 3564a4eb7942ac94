# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The processes of a soak: the node, the source, a subscriber; and the listening side."""
from pathlib import Path
import subprocess
import sys
import time
from typing import Any

from rclpy.qos import QoSProfile

from .books import Account, read
from .checks import Permitted, TopicCheck
from .listening import Broken, Listening
from .memory import Memory
from .robots import (
    DESCRIPTIONS, INPUT_DEPTH, KINDS, OUTPUT_DEPTH, ROBOTS, SAMPLES, TICK_NS)
from .shared import Progress

DEEP = QoSProfile(depth=100_000)
KEEP = {'history': 'keep_last', 'reliability': 'reliable'}


class Rig(Listening):
    """Everything that runs, a bare relay beside the node if wanted, and what it is told."""

    def __init__(self, directory: Path, rate: int, seed: int, relay: bool = False) -> None:
        super().__init__('soak', directory)
        self.permitted = Permitted()
        self.memory, self.relay_memory = Memory(), Memory()
        self._rate, self._seed = rate, seed
        self._listening = directory / 'listening'
        self.progress = Progress(directory / 'progress', len(ROBOTS))
        begin = time.time_ns() // TICK_NS // SAMPLES * SAMPLES
        for robot in range(len(ROBOTS)):
            self.progress.numbers[self.progress.tick(robot)] = begin
        self.checks = {(i, output): TopicCheck(
                i, robot, output, self.progress, 1_000_000_000 // TICK_NS // rate)
                       for i, robot in enumerate(ROBOTS) for output in robot.outputs}
        for (i, output), check in self.checks.items():
            self._here.create_subscription(
                KINDS[output], f'{ROBOTS[i].name}/{output}', check.take, DEEP, raw=True)
        self.describe(DESCRIPTIONS[0])
        self.start_node(self._parameters())
        self._relay = self._start_module('relay') if relay else None
        self.deaf_subscribers = 0
        self.stalling = self._start_subscriber('reliable')
        self._command_number = 0
        self.start_source()

    # Processes

    def _start_module(self, name: str, *arguments: object) -> subprocess.Popen[bytes]:
        return self.start(name, [sys.executable, '-m', f'benchmark.soak.{name}',
                                 *map(str, arguments)])

    @staticmethod
    def _parameters() -> dict[str, Any]:
        parameters: dict[str, Any] = {
            'robots': [robot.name for robot in ROBOTS], 'diagnostics_rate': 5.0,
            'qos_overrides': {}}
        for robot in ROBOTS:
            parameters[robot.name] = robot.parameters | {
                'joint_states_topic': f'{robot.name}/joint_states'}
            parameters['qos_overrides'] |= {
                f'/{robot.name}/joint_states': {
                    'subscription': KEEP | {'depth': INPUT_DEPTH}}} | {
                f'/{robot.name}/{output}': {'publisher': KEEP | {'depth': OUTPUT_DEPTH}}
                for output in robot.outputs}
        return parameters

    def start_source(self) -> None:
        """
        Start the source, which waits for a command, and wait until the node has found it.

        What is published before does not reach the node, though the source has found it (see
        eProsima/Fast-DDS, issue 2641). A killed source is still counted for a while; if one is
        forgotten in the moment in which the new one is found, this is not seen.
        """
        fewest = self._publishers()

        def found() -> bool:
            nonlocal fewest
            counts = self._publishers()
            fewest = [min(pair) for pair in zip(fewest, counts)]
            return all(count > few for count, few in zip(counts, fewest))

        self.source = self._start_module(
            'source', self._directory / 'progress', self._rate,
            self._seed + self._command_number, 1 if self._relay is None else 2)
        try:
            self.wait(found, 'the node to find the source', limit=10.0)
        except Broken:
            pass

    def _publishers(self) -> list[int]:
        """Return how many publishers of joint states the node sees for each robot."""
        of_node = self.report()[1].get('node', {})
        return [int(of_node.get(f'/{robot.name}/joint_states publishers', 0)) for robot in ROBOTS]

    def _start_subscriber(self, reliability: str) -> subprocess.Popen[bytes]:
        self._listening.unlink(missing_ok=True)
        return self._start_module('stalling', reliability, self._listening)

    def restart_subscriber(self, reliability: str = 'reliable') -> None:
        """
        Kill the other subscriber, start a new one, and wait until it gets messages.

        One that is cut off from the start, by what the killed one left, is replaced too.
        """
        for _ in range(5):
            self.stalling.kill()
            self.stalling.wait()
            self.stalling = self._start_subscriber(reliability)
            try:
                self.wait(lambda: self._listening.exists() or self.stalling.poll() is not None,
                          'the other subscriber', limit=25.0)
            except Broken:
                self.deaf_subscribers += 1
                continue
            if self.stalling.poll() is not None:
                raise Broken(f'the other subscriber ended with code {self.stalling.returncode}')
            return
        raise Broken('no other subscriber gets any message')

    def count_deaf_subscriber(self) -> None:
        """
        Note if the other subscriber, once stopped, is cut off.

        Fast DDS 2.14 gives up the port in shared memory of a process that stands still, and
        makes it anew for each message from then on. A process that goes on right between
        the two listens to a deleted port for ever.
        """
        maps = Path(f'/proc/{self.stalling.pid}/maps').read_text().splitlines()
        self.deaf_subscribers += any(
            'fastrtps_port' in line and line.endswith('(deleted)') for line in maps)

    def command(self, name: str, *arguments: Any) -> None:
        """Have the source do something, and wait until it is done."""
        self._command_number += 1
        number = self._command_number
        self.tell(self.source, name, *arguments)
        self.wait(lambda: self.progress.numbers[0] == number, f'the source to {name}')

    def close(self) -> int:
        """End everything; return the exit code of the node."""
        return self.end(self.source, self.stalling, *[self._relay] if self._relay else [])

    # Listening

    def wait_for_progress(self, condition: Any, limit: float) -> None:
        """Wait for a condition, but not longer than this after the last change of a count."""
        last: Any = None
        end = time.monotonic() + limit
        while not condition() and time.monotonic() < end:
            self.spin(0.05)
            counts = [a.on_topic for a in self.report()[0]], [
                self.received(*key) for key in self.checks]
            if counts != last:
                last, end = counts, time.monotonic() + limit
        self.check()

    def wait_for_report(self) -> None:
        """Wait for diagnostics that are made from now on."""
        begin = time.time()

        def made() -> float:
            stamp = self.diagnostics.header.stamp
            return stamp.sec + stamp.nanosec * 1e-9

        self.wait(lambda: made() > begin, 'diagnostics')

    def check_outputs(self) -> None:
        """Check the outputs that have arrived."""
        for check in self.checks.values():
            check.check(self.permitted)

    def look(self) -> None:
        """See how much memory node and relay have; each second."""
        self.memory.look(self.node.pid)
        if self._relay is not None:
            self.relay_memory.look(self._relay.pid)

    def report(self) -> tuple[list[Account], dict[str, dict[str, str]]]:
        """Return the latest account of each robot, and all values the node reports."""
        return read(self.diagnostics)

    def ticks(self) -> list[int]:
        """Return the next tick of each robot."""
        return [self.progress.numbers[self.progress.tick(i)] for i in range(len(ROBOTS))]

    def published(self) -> list[int]:
        """Return how many messages were published for each robot."""
        return [self.progress.numbers[self.progress.published(i)] for i in range(len(ROBOTS))]

    def received(self, robot: int, output: str) -> int:
        """Return how many outputs of a robot have arrived."""
        return self.checks[robot, output].tally.received

    def base_in_use(self) -> int:
        """Return which of the descriptions the described robot's last output was made with."""
        return next(check.last_base for (i, _), check in self.checks.items()
                    if ROBOTS[i].described)
