# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The drivers of all robots, in a process of their own that may be killed at any time.

Run by `benchmark.soak`, with a file of progress, a rate, a seed and the number
of nodes that listen. Commands are names of methods of `Source`, and their arguments; in the file
of progress it counts those that are done.
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

from .messages import beginning, commands, MALFORMED as ALL_KINDS, spoilt
from .robots import INPUT_DEPTH, RIVAL_NS, ROBOTS, SAMPLES, TICK_NS
from .shared import Progress, RING
from ..node.robot import message_body

HOUR_TICKS = 3600 * 1_000_000_000 // TICK_NS
MALFORMED = tuple(kind for kind in ALL_KINDS if kind != 'partial')


class Source:
    """Publishes the joint states of all robots at a rate, and what it is told to beside."""

    def __init__(self, file: Path, rate: int, seed: int, listeners: int) -> None:
        self._random = Random(seed)
        self._progress = Progress(file, len(ROBOTS))
        self._numbers = self._progress.numbers
        self._step = 1_000_000_000 // TICK_NS // rate
        self._period = 1.0 / rate
        self._node = rclpy.create_node('source')
        publishers = [[self._node.create_publisher(
            JointState, f'{robot.name}/joint_states', QoSProfile(depth=INPUT_DEPTH))
            for robot in ROBOTS] for _ in range(2)]
        self._publish, self._publish_rival = (
            [publisher.publish for publisher in each] for each in publishers)
        # What is published before the node is found does not reach it.
        while any(p.get_subscription_count() < listeners for each in publishers for p in each):
            time.sleep(0.01)
        self._bodies = [robot.bodies() for robot in ROBOTS]
        self._rivals = [robot.bodies(rival=True) for robot in ROBOTS]
        self._one_joint = [message_body(robot.chain.joint_names[:1], [0.5], [0.0])
                           for robot in ROBOTS]
        self._paused = True
        self._lossy = False
        self._rival = ''
        self._held: dict[int, bytes] = {}

    def run(self, commands: deque[list[Any]]) -> None:
        """Publish until the end of the commands."""
        # The clock went on while no source ran.
        begin = time.monotonic() - self._numbers[1] * 1e-9
        if self._numbers[1]:
            for robot in range(len(ROBOTS)):
                self._numbers[self._progress.tick(robot)] += (
                    int(begin * 1e9 / TICK_NS) // self._step * self._step)
        due = time.monotonic()
        while True:
            while commands:
                name, *arguments = commands.popleft()
                if name == 'stop':
                    return
                getattr(self, name)(*arguments)
                self._numbers[0] += 1
            now = time.monotonic()
            if self._paused or due > now + 1.0:
                due = now
            if due > now:
                time.sleep(due - now)
                continue
            self._numbers[1] = int(now * 1e9)
            if self._paused:
                time.sleep(0.01)
                for robot in range(len(ROBOTS)):
                    self._numbers[self._progress.tick(robot)] += (
                        10_000_000 // TICK_NS // self._step * self._step)
                continue
            for robot in range(len(ROBOTS)):
                self._take_step(robot)
            due += self._period

    # Commands

    def pause(self) -> None:
        """Publish nothing."""
        for robot in list(self._held):
            self._send(robot, self._held.pop(robot))
        self._paused = True

    def resume(self) -> None:
        """Publish again."""
        self._paused = False

    def lossy(self, on: bool) -> None:
        """Lose, repeat and swap 1 % of the messages each."""
        self._lossy = on

    def rival(self, kind: str) -> None:
        """Have a second publisher of 'all' joints, of 'one' joint, or none ('')."""
        self._rival = kind

    def jump(self, hours: int) -> None:
        """Set the clocks of all robots."""
        for robot in range(len(ROBOTS)):
            self._numbers[self._progress.tick(robot)] += hours * HOUR_TICKS

    def burst(self, robot: int, count: int) -> None:
        """Publish many messages at once."""
        for _ in range(count):
            self._take_step(robot)

    def malformed(self, robot: int, kind: str, count: int) -> None:
        """Publish messages with something wrong in them, good ones between."""
        for _ in range(count):
            self._take_step(robot)
            tick = self._numbers[self._progress.tick(robot)]
            self._send(robot, spoilt(kind, tick * TICK_NS, ROBOTS[robot].chain.joint_names,
                                     self._bodies[robot][0], self._random))

    # Messages

    def _take_step(self, robot: int) -> None:
        at = self._progress.tick(robot)
        tick = self._numbers[at]
        self._numbers[at] = tick + self._step
        data = self._message(tick, self._bodies[robot])
        self._numbers[self._progress.times(robot) + tick % RING] = time.monotonic_ns()
        if self._lossy:
            chance = self._random.random()
            if chance < 0.01:
                return
            if chance < 0.02:
                self._send(robot, data)
            elif chance < 0.03 and robot not in self._held:
                self._held[robot] = data
                return
        self._send(robot, data)
        if self._held and robot in self._held:
            self._send(robot, self._held.pop(robot))
        if self._rival:
            stamp = tick * TICK_NS + RIVAL_NS
            body = (self._rivals[robot][tick % SAMPLES] if self._rival == 'all'
                    else self._one_joint[robot])
            self._numbers[self._progress.published(robot)] += 1
            self._publish_rival[robot](beginning(stamp) + body)

    @staticmethod
    def _message(tick: int, bodies: list[bytes]) -> bytes:
        return beginning(tick * TICK_NS) + bodies[tick % SAMPLES]

    def _send(self, robot: int, data: bytes) -> None:
        self._numbers[self._progress.published(robot)] += 1
        self._publish[robot](data)


def main() -> None:
    """Run the source of which the arguments tell."""
    file, rate, seed, listeners = sys.argv[1:]
    rclpy.init(args=[])
    Source(Path(file), int(rate), int(seed), int(listeners)).run(commands())


if __name__ == '__main__':
    main()
