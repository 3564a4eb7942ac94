# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How the node and each robot are doing, for /diagnostics and for the log."""
from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
import re
import time
from typing import Any, NamedTuple

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node
from rclpy.time import Time

from .robot import Robot
from .topic_inputs import BaseInput, JointInput, TopicInput
from .. import core
from ..errors import Reason, ScrewKinematicsError
from ..motion import MotionEstimator
from ..motion.units import times
from ..pipeline.joint_groups import listed
from ..pipeline.moving_base import MovingBase
from ..pipeline.stream_watch import NO_VELOCITIES

LOG_PERIOD = 5.0
HARMLESS = (Reason.NO_JOINT, Reason.JOINTS_MISSING)
"""Reasons to refuse a message that are no fault: a gripper's message is none of the arm's."""

ADVICE = {Reason.NO_VELOCITY: f"velocity_source is 'measured': {NO_VELOCITIES}"}
"""What is to be said beyond a reason, whatever the message."""

STOOD = 1.0
"""Without time for its housekeeping for longer than this, the node stood still [s]."""

FOREIGN_AGE = 10.0
"""Outputs that keep coming and are older than this, or so far ahead, are of another clock [s]."""

Inputs = Mapping[str, TopicInput[Any]]
"""By topic."""

OK, WARN, ERROR, STALE = (DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR,
                          DiagnosticStatus.STALE)


class Diagnostics:
    """
    What was reported before, so that rates and news can be told.

    Parameters
    ----------
    node : rclpy.node.Node
        Whose name and namespace are in the reports, and which logs.

    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._reported: dict[str, _Counts] = {}
        self._unreadable: dict[str, int] = {}
        self._logged: Counter[str] = Counter()
        self._last_log = -LOG_PERIOD
        self._incomplete: dict[str, float] = {}
        self._kept = time.monotonic()
        self._stood = (0, 0.0)
        self._faulty: dict[tuple[str, str], float] = {}
        self._core = core.build()

    def log_core(self) -> None:
        """Log whether the core is compiled."""
        logger = self._node.get_logger()
        (logger.info if self._core.compiled else logger.warning)(str(self._core))

    def report(self, now: Time, state: str, inputs: Inputs, robots: Collection[Robot],
               faults: Sequence[str], failure: ScrewKinematicsError | None) -> DiagnosticArray:
        """
        Return the message for /diagnostics.

        Parameters
        ----------
        now : Time
            By the node's clock.
        state : str
            Of its life cycle.
        inputs : mapping from str to TopicInput
            By topic.
        robots : collection of Robot
            In the order of their parameter.
        faults : sequence of str
            What is wrong with the node's own configuration, though it runs.
        failure : ScrewKinematicsError, optional
            Why the latest transition failed.

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
        for robot in robots:
            self._log_missing(robot, now)
            self._log_faults(robot, inputs, now)
        if now - self._last_log < LOG_PERIOD:
            return
        counts: Counter[str] = Counter()
        for topic, each in inputs.items():
            counts.update({f'{topic}: {reason}': n for reason, n in each.refused.items()})
        for robot in robots:
            counts.update({f'{robot.name}: {_told(reason)}': n
                           for reason, n in _faults(robot).items()})
            base = _base(robot)
            if base is not None:
                counts.update({f'base of {robot.name}: {reason}': n
                               for reason, n in base.account.refused.items()})
        news = counts - self._logged
        if news:
            self._node.get_logger().warning('refused messages: ' + ', '.join(
                f'{what} ({times(n)})' for what, n in sorted(news.items())))
            self._last_log = now
        self._logged = counts

    def note_stop(self, period: float) -> None:
        """
        Note, and log, that the node had no time for long.

        Parameters
        ----------
        period : float
            After which this is called again, if there is time [s].

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
        if robot.pipeline is None or not robot.account.received or not robot.pipeline.missing():
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
        counts = _Counts(robot)
        since = self._reported.get(robot.name, counts)
        self._reported[robot.name] = counts
        level, message = _judgement(robot, state, counts, since, _age(now, robot), publishers)
        # As its topics are named, so that robots of different namespaces differ.
        hardware = f'{self._node.get_namespace()}/{robot.name}'.lstrip('/')
        return self._status(robot.name, level, message, _values(now, robot, counts, since),
                            hardware)

    def _status(self, part: str, level: bytes, message: str, values: Mapping[str, Any],
                hardware: str = 'none') -> DiagnosticStatus:
        return DiagnosticStatus(
            level=level, name=f'{self._node.get_fully_qualified_name()}: {part}',
            message=message, hardware_id=hardware,
            values=[KeyValue(key=key, value=str(value)) for key, value in values.items()])


class _Counts:
    """Counts of a robot at one time."""

    def __init__(self, robot: Robot) -> None:
        account = robot.account
        self.time = time.monotonic()
        self.received, self.outputs = account.received, account.outputs
        self.faults = _faults(robot).total()
        self.without_base = account.without_base
        base = _base(robot)
        self.base_refused = 0 if base is None else base.account.refused.total()
        self.used_later = account.used_later.total()
        self.wrenches = {tip: _WrenchCounts(sensor.account.received,
                                            sensor.account.refused.total(), sensor.compensated)
                         for tip, sensor in robot.publishers.sensors.items()}


class _WrenchCounts(NamedTuple):
    """Counts of a force sensor at one time."""

    received: int
    refused: int
    compensated: int


def _publishers(robot: Robot, inputs: Inputs) -> int:
    """Return how many publishers a topic of the robot's joint states has at most."""
    return max([each.publishers for each in inputs.values()
                if isinstance(each, JointInput) and robot in each.robots], default=0)


def _values(now: Time, robot: Robot, counts: _Counts, since: _Counts) -> dict[str, Any]:
    """Return what is reported of a robot, by name."""
    account, pipeline = robot.account, robot.pipeline
    period = max(counts.time - since.time, 1e-9)
    values: dict[str, Any] = {
        'input rate [Hz]': round((counts.received - since.received) / period, 2),
        'output rate [Hz]': round((counts.outputs - since.outputs) / period, 2),
        'received': account.received,
        'used': account.used,
        'refused': account.refused.total()}
    values |= {f'refused {reason}': n for reason, n in account.refused.items()}
    values |= {f'used {reason}': n for reason, n in account.used_later.items()}
    if account.incomplete:
        values['outputs without derivatives not known yet'] = account.incomplete
    for sensor in robot.publishers.sensors.values():
        topic = sensor.settings.wrench_topic
        values |= {f'{topic} wrenches': sensor.account.received,
                   f'{topic} compensated': sensor.compensated}
        values |= {f'{topic} refused {reason}': n for reason, n in sensor.account.refused.items()}
        values |= {f'{topic} missing {reason}': n for reason, n in sensor.left_out.items()}
    base = _base(robot)
    if base is not None:
        values['base motion received'] = base.account.received
        values |= {f'base motion refused {reason}': n
                   for reason, n in base.account.refused.items()}
        values['base motion relative to'] = base.world or 'not known yet'
        values['outputs without those relative to the world'] = account.without_base
    values['outputs listened to'] = ', '.join(robot.publishers.wanted_names)
    if pipeline is None:
        return values
    values['model'] = repr(robot.model)
    values['lost by their stamps'] = pipeline.lost
    values['joints missing'] = listed(pipeline.missing())
    age = _age(now, robot)
    outputs = counts.outputs - since.outputs
    values['age of last output [s]'] = (
        'none yet' if age is None else 'not of this clock'
        if _is_foreign(robot, outputs, age) else round(age, 4))
    values |= _estimation(robot)
    values |= robot.posture_report()
    values['doubts'] = '; '.join(pipeline.doubts())
    return values


def _judgement(robot: Robot, state: str, counts: _Counts, since: _Counts,
               age: float | None, publishers: int) -> tuple[bytes, str]:
    """Return level and message of a robot: what is worst."""
    pipeline = robot.pipeline
    new, outputs = counts.received - since.received, counts.outputs - since.outputs
    new_faults = counts.faults - since.faults
    if robot.model_error:
        return (ERROR if robot.model is None else WARN), robot.model_error
    if pipeline is None:
        return WARN, f'waiting for a description on {robot.settings.description_topic!r}'
    if state != 'active':
        return OK, f'{state}: not listening'
    faults = pipeline.faults(publishers)
    if 0 < new <= new_faults:
        return ERROR, '; '.join([f'every message is refused: {_most_frequent(robot)}', *faults])
    if new and faults:
        return WARN, '; '.join(faults)
    base = pipeline.base
    if base is not None and counts.base_refused > since.base_refused:
        return WARN, f'messages of the base refused: {base.problem()}'
    if base is not None and counts.without_base > since.without_base:
        return WARN, f'outputs relative to the world are left out: {base.problem()}'
    missing = pipeline.missing()
    if missing:
        nothing = len(missing) == len(pipeline.joint_names)
        return (STALE if nothing else WARN), pipeline.describe_missing()
    if new_faults > 0:
        return WARN, f'{new_faults} messages refused: {_most_frequent(robot)}'
    if not robot.publishers.wanted:
        return OK, 'ready; nobody listens'
    complaints = [text for tip in robot.publishers.sensors if robot.wants_wrench(tip)
                  for text in _wrench_complaints(robot, tip, counts, since)]
    if outputs and complaints:
        return WARN, '; '.join(complaints)
    doubts = pipeline.doubts()
    if new and not outputs:
        return (WARN if doubts else OK), '; '.join(
            [f'no output: {_most_frequent_use(robot)}', *doubts])
    if _is_foreign(robot, outputs, age):
        assert age is not None
        return WARN, (f'stamps are not of this clock: {abs(age):.6g} s '
                      f'{"old" if age > 0 else "ahead"}; is use_sim_time as it should be?')
    # Doubts are no fault: the estimator has already acted on them.
    return OK, '; '.join(['running', *doubts])


def _wrench_complaints(robot: Robot, tip: int, counts: _Counts, since: _Counts) -> list[str]:
    """Return what is wrong with a force sensor whose compensated wrench is wanted."""
    sensor = robot.publishers.sensors[tip]
    topic, account = sensor.settings.wrench_topic, sensor.account
    now = counts.wrenches[tip]
    before = since.wrenches.get(tip, now)
    complaints = []
    if now.refused > before.refused:
        reason, _ = account.refused.most_common(1)[0]
        complaints.append(f'{topic}: {now.refused - before.refused} wrenches refused: {reason} '
                          f'({account.details.get(reason, "")})')
    latest = sensor.latest_ns
    if not now.received:
        complaints.append(f'{topic}: no wrench has come')
    elif latest is not None and now.compensated == before.compensated:
        apart = (robot.stamp_ns - latest) * 1e-9
        if abs(apart) > sensor.settings.stale_timeout:
            complaints.append(f'{topic}: the latest wrench is {abs(apart):.6g} s '
                              f'{"older" if apart > 0 else "newer"} than the latest joint states')
    return complaints


def _is_foreign(robot: Robot, outputs: int, age: float | None) -> bool:
    """Return whether the stamps of outputs, so many of them new, are of another clock."""
    limit = FOREIGN_AGE + robot.settings.motion.delay
    return age is not None and (age < -limit or outputs > 0 and age > limit)


def _age(now: Time, robot: Robot) -> float | None:
    """Return how old the latest output is by the node's clock [s]; None if there is none."""
    return (now.nanoseconds - robot.stamp_ns) * 1e-9 if robot.stamp_ns else None


def _base(robot: Robot) -> MovingBase | None:
    return None if robot.pipeline is None else robot.pipeline.base


def _faults(robot: Robot) -> Counter[Reason]:
    return Counter({reason: n for reason, n in robot.account.refused.items()
                    if reason not in HARMLESS})


def _told(reason: Reason) -> str:
    return f'{reason}, {ADVICE[reason]},' if reason in ADVICE else str(reason)


def _most_frequent(robot: Robot) -> str:
    reason = _faults(robot).most_common(1)[0][0]
    detail = robot.account.details.get(reason) or ADVICE.get(reason, '')
    return f'{reason} ({detail})' if detail else str(reason)


def _most_frequent_use(robot: Robot) -> str:
    uses = robot.account.used_later.most_common(1)
    return str(uses[0][0]) if uses else 'nothing used'


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
    values |= {'repeated positions': sum(e.clock.held for e in estimators
                                         if isinstance(e, MotionEstimator))}
    return values
