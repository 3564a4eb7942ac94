# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The drivers of all robots, in a process of their own, and the mishaps on their way.

Arguments: the file of the log, when the motion began [ns since 1970], and seconds between two
settings of a clock. Commands come on standard input, one JSON list on a line: the name of a method
of `Drivers`, and its arguments.
"""
from collections import deque
import json
import math
from pathlib import Path
from random import Random
import struct
import sys
import threading
import time
from typing import Any

import rclpy
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from .log import LENGTH, SentLog
from .robots import FieldRobot, RATE, ROBOTS, SAMPLES
from ...node.robot import message_body

MALFORMED = ('nan', 'infinite', 'short', 'long', 'truncated', 'noise', 'empty', 'unknown',
             'twice', 'negative', 'partial')
LATE = 0.05
"""What could not be sent for so long is not read at all, as by a driver that stood still [s]."""

_stamp = struct.Struct('<iI').pack
_HEAD = b'\0\1\0\0'


class Driver:
    """The driver of one robot."""

    def __init__(self, node: Any, number: int, robot: FieldRobot, log: SentLog, epoch: int,
                 every: float) -> None:
        self._node, self._number, self._log, self._epoch = node, number, log, epoch
        self.robot = robot
        self._bodies = robot.bodies()
        self._messages = robot.way(every)
        self._next = next(self._messages)
        self._entries, self._counts = log.entries[number], log.counts[number]
        self.silent_until = 0.0
        self._publisher: Any = None
        self.connect()

    def connect(self) -> None:
        """Make the publisher anew."""
        if self._publisher is not None:
            self._node.destroy_publisher(self._publisher)
        self._publisher = self._node.create_publisher(
            JointState, f'{self.robot.name}/joints', QoSProfile(depth=1000))

    def disconnect(self, until: float) -> None:
        """Remove the publisher until a time [s since the beginning]."""
        self._node.destroy_publisher(self._publisher)
        self._publisher, self.silent_until = None, until

    def step(self, now: float, drivers: 'Drivers') -> float:
        """Send what is due by now [s since the beginning]; return when the next one is."""
        while (message := self._next).sent <= now:
            self._next = next(self._messages)
            if self._publisher is None:
                if now >= self.silent_until:
                    self.connect()
                continue
            if message.sent < now - LATE:
                continue
            stamp = self._epoch + round(message.stamp * 1e9)
            drivers.pass_on(self, self._note(stamp, message.instant) + self._bodies[
                round(message.reading * RATE) % SAMPLES])
        return message.sent

    def _note(self, stamp: int, instant: float) -> bytes:
        """Enter a message into the log; return its beginning."""
        k = int(self._counts[1])
        self._entries[k % LENGTH] = stamp, instant, time.monotonic_ns()
        self._counts[1] = k + 1
        return _HEAD + _stamp(*divmod(stamp, 1_000_000_000))

    def send(self, data: bytes) -> None:
        """Publish a message."""
        if self._publisher is not None:
            self._counts[0] += 1
            self._publisher.publish(data)

    def bad_message(self, kind: str, random: Random, now: float) -> bytes:
        """Return a message with something wrong in it."""
        names = list(self.robot.chains[0].joint_names)
        position = [0.5] * len(names)
        if kind in ('nan', 'infinite'):
            position[random.randrange(len(names))] = math.nan if kind == 'nan' else -math.inf
        elif kind == 'short':
            position.pop()
        elif kind == 'long':
            position.append(0.5)
        elif kind == 'unknown':
            names = [f'unknown{random.randrange(10**6)}' for _ in names]
        elif kind == 'twice':
            names[0] = names[-1]
        elif kind == 'partial':
            names, position = names[:-1], position[:-1]
        stamp = self._epoch + round(now * 1e9)
        data = _HEAD + _stamp(*divmod(stamp, 1_000_000_000)) + message_body(names, position, [])
        if kind == 'truncated':
            # Less would be a whole message: the middleware fills up to four bytes.
            return data[:random.randrange(4, len(data) - 12)]
        if kind == 'noise':
            return _HEAD + random.randbytes(random.randrange(4, 600))
        if kind == 'empty':
            return _HEAD + bytes(24)
        if kind == 'negative':
            return _HEAD + _stamp(-5, 0) + self._bodies[0]
        return data


class Drivers:
    """All drivers, and what happens to their messages."""

    def __init__(self, file: Path, epoch: int, every: float) -> None:
        self._random = Random(1)
        self._node = rclpy.create_node('drivers')
        self._begin = time.monotonic() - (time.time_ns() - epoch) * 1e-9
        log = SentLog(file, len(ROBOTS))
        self._drivers = [Driver(self._node, k, robot, log, epoch, every)
                         for k, robot in enumerate(ROBOTS)]
        self._share = dict.fromkeys(('dropped', 'doubled', 'swapped', 'malformed'), 0.0)
        self._held: dict[Driver, bytes] = {}

    def run(self, commands: deque[list[Any]]) -> None:
        """Send until the end of the commands."""
        while True:
            while commands:
                name, *arguments = commands.popleft()
                if name == 'stop':
                    return
                getattr(self, name)(*arguments)
            due = min(driver.step(self._now(), self) for driver in self._drivers)
            time.sleep(max(0.0, min(due - self._now(), 0.01)))

    def mishaps(self, shares: dict[str, float]) -> None:
        """Let these shares of the messages be dropped, doubled, swapped or malformed."""
        self._share |= shares

    def restart(self, robot: int, seconds: float) -> None:
        """Take the publisher of a robot away for some time."""
        self._drivers[robot].disconnect(self._now() + seconds)

    def pass_on(self, driver: Driver, data: bytes) -> None:
        """Publish a driver's message, or what becomes of it."""
        share, chance = self._share, self._random.random()
        if chance < share['dropped']:
            return
        chance -= share['dropped']
        if 0 <= chance < share['swapped'] and driver not in self._held:
            self._held[driver] = data
            return
        driver.send(data)
        chance -= share['swapped']
        if 0 <= chance < share['doubled']:
            driver.send(data)
        chance -= share['doubled']
        if 0 <= chance < share['malformed']:
            driver.send(driver.bad_message(
                self._random.choice(MALFORMED), self._random, self._now()))
        if self._held and driver in self._held:
            driver.send(self._held.pop(driver))

    def _now(self) -> float:
        return time.monotonic() - self._begin


def _read_commands(commands: deque[list[Any]]) -> None:
    for line in sys.stdin:
        commands.append(json.loads(line))
    commands.append(['stop'])


def main() -> None:
    """Run the drivers that the arguments tell of."""
    file, epoch, every = sys.argv[1:]
    rclpy.init(args=[])
    commands: deque[list[Any]] = deque()
    drivers = Drivers(Path(file), int(epoch), float(every))
    threading.Thread(target=_read_commands, args=(commands,), daemon=True).start()
    drivers.run(commands)


if __name__ == '__main__':
    main()
