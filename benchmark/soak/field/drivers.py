# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The drivers of all robots, in a process of their own, and the mishaps on their way.

Arguments: the file of the log, when the motion began [ns since 1970], seconds between two settings
of a clock, how deep the queues of the publishers are, how many robots there are. Commands are
names of methods of `Drivers`, and their arguments.
"""
from collections import deque
from pathlib import Path
from random import Random
import sys
import time
from typing import Any

import rclpy
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from .log import LENGTH, SentLog
from .robots import FieldRobot, RATE, ROBOTS, SAMPLES
from ..messages import beginning, commands, MALFORMED as ALL_KINDS, spoilt

MALFORMED = tuple(kind for kind in ALL_KINDS if kind != 'unstamped')
LATE = 0.05
"""What could not be sent for so long is not read at all, as by a driver that stood still [s]."""


class Driver:
    """The driver of one robot."""

    def __init__(self, node: Any, number: int, robot: FieldRobot, log: SentLog, epoch: int,
                 every: float, depth: int) -> None:
        self._node, self._number, self._log, self._epoch = node, number, log, epoch
        self._depth = depth
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
            JointState, f'{self.robot.name}/joints', QoSProfile(depth=self._depth))

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
        return beginning(stamp)

    def send(self, data: bytes) -> None:
        """Publish a message."""
        if self._publisher is not None:
            self._counts[0] += 1
            self._publisher.publish(data)

    def spoilt(self, kind: str, random: Random, now: float) -> bytes:
        """Return a message with something wrong in it."""
        return spoilt(kind, self._epoch + round(now * 1e9), self.robot.chains[0].joint_names,
                      self._bodies[0], random)


class Drivers:
    """All drivers, and what happens to their messages."""

    def __init__(self, file: Path, epoch: int, every: float, depth: int, robots: int) -> None:
        self._random = Random(1)
        self._node = rclpy.create_node('drivers')
        self._begin = time.monotonic() - (time.time_ns() - epoch) * 1e-9
        log = SentLog(file, robots)
        self._drivers = [Driver(self._node, k, robot, log, epoch, every, depth)
                         for k, robot in enumerate(ROBOTS[:robots])]
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
            driver.send(driver.spoilt(
                self._random.choice(MALFORMED), self._random, self._now()))
        if self._held and driver in self._held:
            driver.send(self._held.pop(driver))

    def _now(self) -> float:
        return time.monotonic() - self._begin


def main() -> None:
    """Run the drivers that the arguments tell of."""
    file, epoch, every, depth, robots = sys.argv[1:]
    rclpy.init(args=[])
    Drivers(Path(file), int(epoch), float(every), int(depth), int(robots)).run(commands())


if __name__ == '__main__':
    main()
