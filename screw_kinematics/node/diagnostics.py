# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How the node and each robot are doing, for /diagnostics and for the log."""
from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
import time
from typing import Any, TYPE_CHECKING

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from .robot import Robot
from ..pipeline.joint_groups import NO_JOINT

if TYPE_CHECKING:
    from .node import KinematicStatePublisher

LOG_PERIOD = 5.0
HARMLESS = (NO_JOINT,)
"""Reasons to refuse a message that are no fault: a gripper's message is none of the arm's."""

OK, WARN, ERROR, STALE = (DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR,
                          DiagnosticStatus.STALE)


class Diagnostics:
    """What was reported before, so that rates and news can be told."""

    def __init__(self) -> None:
        self._since: dict[str, tuple[float, int, int, int]] = {}
        self._unreadable: dict[str, int] = {}
        self._logged: Counter[str] = Counter()
        self._last_log = -LOG_PERIOD

    def report(self, node: KinematicStatePublisher) -> DiagnosticArray:
        """Return the message for /diagnostics."""
        array = DiagnosticArray()
        array.header.stamp = node.get_clock().now().to_msg()
        array.status = [self._of_node(node)]
        array.status += [self._of_robot(node, robot) for robot in node.robots.values()]
        return array

    def log_refusals(self, node: KinematicStatePublisher) -> None:
        """Log what was refused since the last time, at most every few seconds."""
        now = time.monotonic()
        if now - self._last_log < LOG_PERIOD:
            return
        counts: Counter[str] = Counter()
        for topic, joint_input in node.inputs.items():
            counts.update({f'{topic}: {reason}': n for reason, n in joint_input.refused.items()})
        for name, robot in node.robots.items():
            counts.update({f'{name}: {reason}': n for reason, n in _faults(robot).items()})
        news = counts - self._logged
        if news:
            node.get_logger().warning('refused messages: ' + ', '.join(
                f'{what} ({n} times)' for what, n in sorted(news.items())))
            self._last_log = now
        self._logged = counts

    def _of_node(self, node: KinematicStatePublisher) -> DiagnosticStatus:
        level, message = OK, node.state
        values: dict[str, Any] = {'state': node.state, 'robots': ', '.join(node.robots)}
        for topic, joint_input in node.inputs.items():
            values[f'{topic} publishers'] = joint_input.publishers
            values[f'{topic} received'] = joint_input.received
            values[f'{topic} without stamp'] = joint_input.unstamped
            for reason, n in joint_input.refused.items():
                values[f'{topic} refused {reason}'] = n
            refused = joint_input.refused.total()
            if refused > self._unreadable.get(topic, 0):
                level, message = WARN, f'unreadable messages on {topic}: {joint_input.last_error}'
            self._unreadable[topic] = refused
        if node.unknown_parameters:
            level, message = WARN, '; '.join(node.unknown_parameters)
        if node.failure is not None:
            level, message = ERROR, str(node.failure)
        return _status(node, 'node', level, message, values)

    def _of_robot(self, node: KinematicStatePublisher, robot: Robot) -> DiagnosticStatus:
        account, pipeline = robot.account, robot.pipeline
        faults = _faults(robot).total()
        now = time.monotonic()
        then, received, outputs, faults_before = self._since.get(
            robot.name, (now, account.received, account.outputs, faults))
        self._since[robot.name] = (now, account.received, account.outputs, faults)
        period = max(now - then, 1e-9)
        new, new_faults = account.received - received, faults - faults_before
        values: dict[str, Any] = {
            'input rate [Hz]': round(new / period, 2),
            'output rate [Hz]': round((account.outputs - outputs) / period, 2),
            'received': account.received,
            'used': account.used,
            'refused': account.refused.total()}
        values |= {f'refused {reason}': n for reason, n in account.refused.items()}
        values |= {f'used {reason}': n for reason, n in account.waiting.items()}
        values['outputs listened to'] = ', '.join(robot.topics.wanted)
        doubts: list[str] = []
        missing: list[str] = []
        if pipeline is not None:
            missing = pipeline.missing()
            values['model'] = repr(robot.model)
            values['joints missing'] = ', '.join(missing)
            age = node.get_clock().now().nanoseconds - pipeline.stamp_ns
            values['age of last output [s]'] = (
                round(age * 1e-9, 4) if pipeline.stamp_ns else 'none yet')
            values |= _estimation(robot)
            values |= robot.posture_report()
            doubts = pipeline.doubts()
            values['doubts'] = '; '.join(doubts)

        if robot.model_error:
            level = ERROR if robot.model is None else WARN
            message = robot.model_error
        elif pipeline is None:
            level = WARN
            message = f'waiting for a description on {robot.settings.description_topic!r}'
        elif node.state != 'active':
            level, message = OK, f'{node.state}: not listening'
        elif missing:
            nothing = len(missing) == len(pipeline.joint_names)
            level = STALE if nothing else WARN
            message = f'no joint states of {", ".join(missing)}'
        elif 0 < new <= new_faults:
            level, message = ERROR, f'every message is refused: {_most_frequent(robot)}'
        elif new_faults > 0:
            level, message = WARN, f'{new_faults} messages refused: {_most_frequent(robot)}'
        else:   # doubts are no fault: the estimator has already acted on them
            level = OK
            message = '; '.join(['running', *doubts]) if robot.topics.wanted else (
                'ready; nobody listens')
        # As its topics are named, so that robots of different namespaces differ.
        hardware = f'{node.get_namespace()}/{robot.name}'.lstrip('/')
        return _status(node, robot.name, level, message, values, hardware)


def _faults(robot: Robot) -> Counter[str]:
    return Counter({reason: n for reason, n in robot.account.refused.items()
                    if reason not in HARMLESS})


def _most_frequent(robot: Robot) -> str:
    reason = _faults(robot).most_common(1)[0][0]
    error = robot.pipeline.last_error if robot.pipeline is not None else ''
    return f'{reason} ({error})' if error else reason


def _estimation(robot: Robot) -> dict[str, Any]:
    """Return where velocity and acceleration come from."""
    motion = robot.settings.motion
    assert robot.pipeline is not None
    values: dict[str, Any] = {
        'estimator': motion.estimator, 'estimator delay [s]': motion.delay,
        'acceleration': 'estimated'}
    estimators = robot.pipeline.estimators()
    used = [bool(u) for e in estimators for u in e.velocity_used]
    values['velocity'] = 'measured' if motion.velocity_source == 'measured' else (
        f'estimated, with the measured one of {sum(used)} of {len(used)} joints'
        if motion.velocity_source == 'auto' and any(used) else 'estimated')
    restarts: Counter[str] = Counter()
    for estimator in estimators:
        restarts.update(estimator.restarts)
    values |= {f'restarts {reason}': n for reason, n in restarts.items()}
    return values


def _status(node: KinematicStatePublisher, part: str, level: bytes, message: str,
            values: dict[str, Any], hardware: str = 'none') -> DiagnosticStatus:
    return DiagnosticStatus(
        level=level, name=f'{node.get_fully_qualified_name()}: {part}', message=message,
        hardware_id=hardware, values=list(_pairs(values.items())))


def _pairs(items: Iterable[tuple[str, Any]]) -> Iterable[KeyValue]:
    return (KeyValue(key=key, value=str(value)) for key, value in items)
