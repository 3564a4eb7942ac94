# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How the node and each robot are doing, for /diagnostics and for the log."""
from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
import re
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node
from rclpy.time import Time

from .robot import Robot
from .robot_status import base_of, ERROR, faults_of, OK, RobotCounts, RobotStatus, WARN
from .topic_inputs import BaseInput, JointInput, TopicInput
from .. import core
from ..errors import Reason, ScrewKinematicsError
from ..motion.units import times

LOG_PERIOD = 5.0

LOOK_PERIOD = 1.0
"""How often news are looked for [s]; it takes as long as some messages."""

STOOD = 1.0
"""Without time for its housekeeping for longer than this, the node stood still [s]."""

Inputs = Mapping[str, TopicInput[Any]]
"""By topic."""


class Diagnostics:
    """
    What was reported before, so that rates and news can be told.

    ``times_deaf`` is how often another node has taken the place of one that the middleware had
    left deaf.
    """

    def __init__(self, node: Node, times_deaf: int = 0) -> None:
        self._node, self.times_deaf = node, times_deaf
        self._reported: dict[str, RobotCounts] = {}
        self._unreadable: dict[str, int] = {}
        self._logged: Counter[tuple[str, Reason]] = Counter()
        self._last_log = -LOG_PERIOD
        self._looked = -LOOK_PERIOD
        self._incomplete: dict[str, float] = {}
        self._kept = time.monotonic()
        self._stood = (0, 0.0)
        self._faulty: dict[tuple[str, str], float] = {}
        self._core = core.build()

    def join(self, node: Node) -> None:
        """Go over to another node, in place of one that was left deaf."""
        self._node = node
        self.times_deaf += 1
        self._kept = time.monotonic()

    def log_core(self) -> None:
        """Log whether the core is compiled."""
        logger = self._node.get_logger()
        (logger.info if self._core.compiled else logger.warning)(str(self._core))

    def report(self, now: Time, state: str, inputs: Inputs, robots: Collection[Robot],
               faults: Sequence[str], failure: ScrewKinematicsError | None) -> DiagnosticArray:
        """
        Return the message for /diagnostics, at a time by the node's clock.

        The state is that of its life cycle; faults are what is wrong with the node's own
        configuration, though it runs; the failure is why the latest transition failed.
        """
        array = DiagnosticArray()
        array.header.stamp = now.to_msg()
        array.status = [
            self._of_node(state, inputs, [robot.name for robot in robots], faults, failure),
            *(self._of_robot(now, state, robot, _publishers(robot, inputs)) for robot in robots)]
        return array

    def log_news(self, inputs: Inputs, robots: Iterable[Robot]) -> None:
        """Log what was refused since the last time, at most every few seconds; and what is new."""
        now = time.monotonic()
        if now - self._looked < LOOK_PERIOD:
            return
        self._looked = now
        for robot in robots:
            self._log_missing(robot, now)
            self._log_faults(robot, inputs, now)
        if now - self._last_log < LOG_PERIOD:
            return
        counts: Counter[tuple[str, Reason]] = Counter()
        words: dict[tuple[str, Reason], str] = {}
        for topic, each in inputs.items():
            counts.update({(topic, reason): n for reason, n in each.refused.items()})
        for robot in robots:
            base = base_of(robot)
            accounts = [(robot.name, robot.account, faults_of(robot)), *(
                (f'wrenches of {sensor.settings.name}', sensor.account, sensor.account.refused)
                for sensor in robot.publishers.sensors.values())]
            if base is not None:
                accounts.append((f'base of {robot.name}', base.account, base.account.refused))
            for name, account, refused in accounts:
                counts.update({(name, reason): n for reason, n in refused.items()})
                words |= {(name, reason): account.told(reason) for reason in refused}
        news = counts - self._logged
        if news:
            self._node.get_logger().warning('refused messages: ' + ', '.join(
                f'{whose[0]}: {words.get(whose, whose[1])}, {times(n)}'
                for whose, n in sorted(news.items())))
            self._last_log = now
        self._logged = counts

    def note_stop(self, period: float) -> None:
        """
        Note, and log, that the node had no time for long.

        This is called again after a period [s], if there is time.
        """
        late, self._kept = time.monotonic() - self._kept - period, time.monotonic()
        if late > STOOD:
            times_stood, longest = self._stood
            self._stood = times_stood + 1, max(longest, late)
            self._node.get_logger().warning(
                f'stood still for {late:.1f} s: stopped, or without a processor; of the joint '
                'states that came meanwhile those that the queue of a topic held are worked off '
                'now, the older ones are lost')

    def _log_missing(self, robot: Robot, now: float) -> None:
        """Log once that messages come and joints are missing, when that lasts."""
        # Where all that came was refused for a fault, that is told.
        received = robot.account.received - faults_of(robot).total()
        if robot.pipeline is None or not received or not robot.pipeline.missing():
            self._incomplete.pop(robot.name, None)
            return
        since = self._incomplete.setdefault(robot.name, now)
        if now - since >= LOG_PERIOD:
            self._incomplete[robot.name] = float('inf')
            self._node.get_logger().warning(f'{robot.name}: {robot.pipeline.describe_missing()}')

    def _log_faults(self, robot: Robot, inputs: Inputs, now: float) -> None:
        """Log once what is wrong with a robot's streams, when that lasts."""
        if robot.pipeline is None:
            return
        for fault in robot.pipeline.faults(_publishers(robot, inputs)):
            # The numbers in a sentence grow; what it is about is the same.
            key = robot.name, re.sub(r'[-+.\de]+', '', fault)
            if now - self._faulty.setdefault(key, now) >= LOG_PERIOD:
                self._faulty[key] = float('inf')
                self._node.get_logger().warning(f'{robot.name}: {fault}')

    def _of_node(self, state: str, inputs: Inputs, robots: list[str],
                 faults: Sequence[str], failure: ScrewKinematicsError | None,
                 ) -> DiagnosticStatus:
        level, message = (OK, state) if self._core.compiled else (WARN, str(self._core))
        values: dict[str, Any] = {'state': state, 'robots': ', '.join(robots),
                                  'core': self._core.state}
        if self._stood[0]:
            values['stood still'] = f'{times(self._stood[0])}, for {self._stood[1]:.1f} s at most'
        if self.times_deaf:
            values['joined the middleware anew'] = times(self.times_deaf)
        for topic, each in inputs.items():
            values[f'{topic} publishers'] = each.publishers
            values[f'{topic} received'] = each.received
            values[f'{topic} without stamp'] = each.unstamped
            for reason, n in each.refused.items():
                values[f'{topic} refused {reason}'] = n
            if isinstance(each, BaseInput):
                values[f'{topic} type'] = each.kind or 'none yet'
            if each.problem:
                level, message = WARN, each.problem
            refused = each.refused.total()
            if refused > self._unreadable.get(topic, 0):
                level, message = WARN, f'messages refused on {topic}: {each.last_error}'
            self._unreadable[topic] = refused
        if faults:
            level, message = WARN, '; '.join(faults)
        if failure is not None:
            level, message = ERROR, str(failure)
        return self._status('node', level, message, values)

    def _of_robot(self, now: Time, state: str, robot: Robot,
                  publishers: int) -> DiagnosticStatus:
        status = RobotStatus(robot, now.nanoseconds, self._reported.get(robot.name))
        self._reported[robot.name] = status.counts
        level, message = status.judge(state, publishers)
        # As its topics are named, so that robots of different namespaces differ.
        hardware = f'{self._node.get_namespace()}/{robot.name}'.lstrip('/')
        return self._status(robot.name, level, message, status.values(), hardware)

    def _status(self, part: str, level: bytes, message: str, values: Mapping[str, Any],
                hardware: str = 'none') -> DiagnosticStatus:
        return DiagnosticStatus(
            level=level, name=f'{self._node.get_fully_qualified_name()}: {part}',
            message=message, hardware_id=hardware,
            values=[KeyValue(key=key, value=str(value)) for key, value in values.items()])


def _publishers(robot: Robot, inputs: Inputs) -> int:
    """Return how many publishers a topic of the robot's joint states has at most."""
    return max([each.publishers for each in inputs.values()
                if isinstance(each, JointInput) and robot in each.robots], default=0)
