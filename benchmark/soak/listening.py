# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The node in its own process, and the side that listens to it and looks after it."""
from abc import ABC, abstractmethod
from collections.abc import Callable
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.task import Future
from std_msgs.msg import String

from screw_kinematics.node.qos import latched_qos

PATIENCE = 120.0
CHECK_PERIOD = 0.25
NODE = [sys.executable, '-c',
        'import sys; from screw_kinematics.node.main import main; sys.exit(main())']


class Broken(RuntimeError):
    """The soak cannot go on."""


class Listening(ABC):
    """What every soak has: the node, other processes, a node here, of a name, that listens."""

    def __init__(self, name: str, directory: Path) -> None:
        self._directory = directory
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self._here = rclpy.create_node(name, context=self._context)
        self._executor = EventsExecutor(context=self._context)
        self._executor.add_node(self._here)
        self.diagnostics = DiagnosticArray()
        self._here.create_subscription(DiagnosticArray, '/diagnostics', self._report, 10)
        self._describe = self._here.create_publisher(String, 'robot_description', latched_qos())
        self._next_check = self._next_look = 0.0
        self._never = Future()
        self._logs: list[Any] = []

    def start(self, name: str, command: list[str]) -> subprocess.Popen[bytes]:
        """Start a process that takes commands and has a log of that name."""
        self._logs.append(open(self._directory / f'{name}.log', 'ab'))
        return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=self._logs[-1],
                                stderr=subprocess.STDOUT, env=os.environ)

    def start_node(self, parameters: dict[str, Any]) -> None:
        """Start the node."""
        file = self._directory / 'parameters.yaml'
        file.write_text(json.dumps({'/**': {'ros__parameters': parameters}}))   # JSON is YAML
        self.node = self.start('node', [*NODE, '--ros-args', '--params-file', str(file)])

    def describe(self, text: str) -> None:
        """Publish a robot description."""
        self._describe.publish(String(data=text))

    @staticmethod
    def tell(process: subprocess.Popen[bytes], name: str, *arguments: Any) -> None:
        """Send a process a command."""
        assert process.stdin is not None
        process.stdin.write((json.dumps([name, *arguments]) + '\n').encode())
        process.stdin.flush()

    def spin(self, seconds: float) -> None:
        """Take what arrives, and check it now and then."""
        end = time.monotonic() + seconds
        while (now := time.monotonic()) < end:
            # One long spin: each of its own would cost as much as what it takes.
            self._executor.spin_until_future_complete(self._never, min(CHECK_PERIOD, end - now))
            if now >= self._next_check:
                self.check()
                self._next_check = time.monotonic() + CHECK_PERIOD

    def wait(self, condition: Callable[[], object], what: str, limit: float = PATIENCE) -> None:
        """Wait for a condition; raise Broken if it never comes."""
        end = time.monotonic() + limit
        while not condition():
            if time.monotonic() > end:
                raise Broken(f'waited {limit:g} s in vain for {what}')
            self.spin(0.05)

    def check(self) -> None:
        """Check the outputs that have arrived; raise Broken if the node has ended."""
        self.check_outputs()
        if self.node.poll() is not None:
            raise Broken(f'the node ended with code {self.node.returncode}')
        now = time.monotonic()
        if now >= self._next_look:
            self._next_look = now + 1.0
            self.look()

    @abstractmethod
    def check_outputs(self) -> None:
        """Check the outputs that have arrived."""

    @abstractmethod
    def look(self) -> None:
        """See what the processes take; each second."""

    def end(self, *others: subprocess.Popen[bytes]) -> int:
        """End everything; return the exit code of the node."""
        for process in others:
            process.kill()
            process.wait()
        self.node.send_signal(signal.SIGINT)
        try:
            code = self.node.wait(30)
        except subprocess.TimeoutExpired:
            self.node.kill()
            code = self.node.wait()
        for log in self._logs:
            log.close()
        self._executor.shutdown()
        self._here.destroy_node()
        self._context.try_shutdown()
        return code

    def _report(self, array: DiagnosticArray) -> None:
        self.diagnostics = array
