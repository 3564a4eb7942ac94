# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The drivers of all robots, in a process of their own that may be killed at any time.

Run by `benchmark.soak`, with a file of progress, a rate, a seed and the number
of nodes that listen; takes commands, one JSON
list on a line: a number, the name of a method of `Source`, and its arguments.
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

import rclpy
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from .robots import INPUT_DEPTH, RIVAL_NS, ROBOTS, SAMPLES, TICK_NS
from .shared import Progress, RING
from ..node.robot import message_body

HOUR_TICKS = 3600 * 1_000_000_000 // TICK_NS
MALFORMED = ('nan', 'infinite', 'short', 'long', 'truncated', 'noise', 'empty', 'unknown',
             'twice', 'unstamped', 'negative')

_stamp = struct.Struct('<iI').pack
_HEAD = b'\0\1\0\0'


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

    def run(self, commands: deque[list]) -> None:
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
                number, name, *arguments = commands.popleft()
                if name == 'stop':
                    return
                getattr(self, name)(*arguments)
                self._numbers[0] = number
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
            self._send(robot, self._bad_message(robot, kind))

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
            self._publish_rival[robot](_HEAD + _stamp(*divmod(stamp, 1_000_000_000)) + body)

    @staticmethod
    def _message(tick: int, bodies: list[bytes]) -> bytes:
        return (_HEAD + _stamp(*divmod(tick * TICK_NS, 1_000_000_000)) + bodies[tick % SAMPLES])

    def _send(self, robot: int, data: bytes) -> None:
        self._numbers[self._progress.published(robot)] += 1
        self._publish[robot](data)

    def _bad_message(self, robot: int, kind: str) -> bytes:
        tick = self._numbers[self._progress.tick(robot)]
        names = list(ROBOTS[robot].chain.joint_names)
        n, random = len(names), self._random
        position, velocity = [0.5] * n, [0.0] * n
        if kind in ('nan', 'infinite'):
            position[random.randrange(n)] = math.nan if kind == 'nan' else -math.inf
        elif kind == 'short':
            position.pop()
        elif kind == 'long':
            position.append(0.5)
        elif kind == 'unknown':
            names = [f'unknown{random.randrange(10**6)}' for _ in names]
        elif kind == 'twice':
            names[0] = names[-1]
        data = (_HEAD + _stamp(*divmod(tick * TICK_NS, 1_000_000_000))
                + message_body(names, position, velocity))
        if kind == 'truncated':
            # Less would be a whole message: the middleware fills up to four bytes.
            return data[:random.randrange(4, len(data) - 12)]
        if kind == 'noise':
            return _HEAD + random.randbytes(random.randrange(4, 600))
        if kind == 'empty':
            return _HEAD + bytes(24)
        if kind == 'unstamped':
            return _HEAD + bytes(8) + self._bodies[robot][0]
        if kind == 'negative':
            return _HEAD + _stamp(-5, 0) + self._bodies[robot][0]
        return data


def _read_commands(commands: deque[list]) -> None:
    for line in sys.stdin:
        commands.append(json.loads(line))
    commands.append([0, 'stop'])


def main() -> None:
    """Run the source of which the arguments tell."""
    file, rate, seed, listeners = sys.argv[1:]
    rclpy.init(args=[])
    commands: deque[list] = deque()
    source = Source(Path(file), int(rate), int(seed), int(listeners))
    threading.Thread(target=_read_commands, args=(commands,), daemon=True).start()
    source.run(commands)


if __name__ == '__main__':
    main()
