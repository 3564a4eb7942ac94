# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How one robot of the node is doing, by what was counted since the last report."""
from __future__ import annotations

from collections import Counter
import time
from typing import Any, NamedTuple

from diagnostic_msgs.msg import DiagnosticStatus

from .robot import Robot
from ..errors import Reason
from ..motion import MotionEstimator
from ..pipeline.joint_groups import listed
from ..pipeline.moving_base import MovingBase
from ..pipeline.robot_pipeline import RobotPipeline

HARMLESS = (Reason.NO_JOINT, Reason.JOINTS_MISSING)
"""Reasons to refuse a message that are no fault: a gripper's message is none of the arm's."""

FOREIGN_AGE = 10.0
"""Outputs that keep coming and are older than this, or so far ahead, are of another clock [s]."""

OK, WARN, ERROR, STALE = (DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR,
                          DiagnosticStatus.STALE)

Verdict = tuple[bytes, str]
"""A level of the diagnostics, and the message."""


class RobotCounts:
    """Counts of a robot at one time."""

    def __init__(self, robot: Robot) -> None:
        account = robot.account
        self.time = time.monotonic()
        self.received, self.outputs = account.received, account.outputs
        self.foreign = False
        """Whether stamps of the latest outputs were not of this clock."""
        self.faults = faults_of(robot)
        self.without_base = account.without_base
        base = base_of(robot)
        self.base_refused = 0 if base is None else base.account.refused.total()
        self.refused, self.used_later = Counter(account.refused), Counter(account.used_later)
        self.wrenches = {tip: _WrenchCounts(sensor.account.received,
                                            sensor.account.refused.total(), sensor.compensated)
                         for tip, sensor in robot.publishers.sensors.items()}


class _WrenchCounts(NamedTuple):
    """Counts of a force sensor at one time."""

    received: int
    refused: int
    compensated: int


class RobotStatus:
    """How a robot is doing now, by the node's clock, and since the report before, if any."""

    def __init__(self, robot: Robot, now_ns: int, since: RobotCounts | None) -> None:
        self._robot = robot
        self.counts = RobotCounts(robot)
        self._since = since or self.counts
        # How old the latest output is [s]; None if there is none.
        self._age = (now_ns - robot.stamp_ns) * 1e-9 if robot.stamp_ns else None
        self._new_messages = self.counts.received - self._since.received
        self._new_outputs = self.counts.outputs - self._since.outputs
        self._new_faults = self.counts.faults - self._since.faults
        self.counts.foreign = self._foreign_age() is not None

    def values(self) -> dict[str, Any]:
        """Return what is reported of a robot, by name."""
        robot, counts, since = self._robot, self.counts, self._since
        account, pipeline = robot.account, robot.pipeline
        period = max(counts.time - since.time, 1e-9)
        values: dict[str, Any] = {
            'input rate [Hz]': round(self._new_messages / period, 2),
            'output rate [Hz]': round(self._new_outputs / period, 2),
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
            values |= {f'{topic} refused {reason}': n
                       for reason, n in sensor.account.refused.items()}
            values |= {f'{topic} missing {reason}': n for reason, n in sensor.left_out.items()}
        base = base_of(robot)
        if base is not None:
            values['base motion received'] = base.account.received
            values |= {f'base motion refused {reason}': n
                       for reason, n in base.account.refused.items()}
            values['base motion relative to'] = base.world or 'not known yet'
            values['outputs without those relative to the world'] = account.without_base
        values['outputs listened to'] = ', '.join(robot.publishers.wanted_names)
        if robot.at_work:
            values['at work'] = robot.at_work
        if pipeline is None:
            return values
        values['model'] = repr(robot.model)
        values['lost by their stamps'] = pipeline.lost
        values['joints missing'] = listed(pipeline.missing())
        values['age of last output [s]'] = (
            'none yet' if self._age is None else 'not of this clock'
            if self._foreign_age() is not None else round(self._age, 4))
        values |= _estimation(robot)
        values |= robot.posture_report()
        values['doubts'] = '; '.join(pipeline.doubts())
        return values

    def judge(self, state: str, publishers: int) -> Verdict:
        """
        Return level and message: what is worst.

        The state is that of the node's life cycle; publishers are so many as a topic of the
        robot's joint states has, at most.
        """
        pipeline = self._robot.pipeline
        if pipeline is None or self._robot.model_error or state != 'active':
            return self._of_model(state)
        return (self._of_messages(pipeline, publishers) or self._of_base(pipeline.base)
                or self._of_joints(pipeline, publishers) or self._of_outputs(pipeline))

    def _of_model(self, state: str) -> Verdict:
        robot = self._robot
        if robot.model_error:
            return (ERROR if robot.model is None else WARN), robot.model_error
        if robot.pipeline is None:
            return WARN, robot.at_work or (
                f'waiting for a description on {robot.settings.description_topic!r}')
        return OK, f'{state}: not listening'

    def _of_messages(self, pipeline: RobotPipeline, publishers: int) -> Verdict | None:
        """Judge whether messages are good for anything."""
        faults = pipeline.faults(publishers)
        if 0 < self._new_messages <= self._new_faults.total():
            return ERROR, '; '.join(
                [f'every message is refused: {self._most_frequent_fault(publishers)}', *faults])
        return (WARN, '; '.join(faults)) if self._new_messages and faults else None

    def _of_base(self, base: MovingBase | None) -> Verdict | None:
        counts, since = self.counts, self._since
        if base is not None and counts.base_refused > since.base_refused:
            return WARN, f'messages of the base refused: {base.problem()}'
        if base is not None and counts.without_base > since.without_base:
            return WARN, f'outputs relative to the world are left out: {base.problem()}'
        return None

    def _of_joints(self, pipeline: RobotPipeline, publishers: int) -> Verdict | None:
        """Judge whether all joints are told, by every message."""
        missing = pipeline.missing()
        if missing:
            nothing = len(missing) == len(pipeline.joint_names)
            return (STALE if nothing else WARN), pipeline.describe_missing()
        if self._new_faults:
            return WARN, (f'{self._new_faults.total()} messages refused: '
                          f'{self._most_frequent_fault(publishers)}')
        return None

    def _of_outputs(self, pipeline: RobotPipeline) -> Verdict:
        robot = self._robot
        if not robot.publishers.wanted:
            return OK, 'ready; nobody listens'
        complaints = [text for tip in robot.publishers.sensors if robot.wants_wrench(tip)
                      for text in self._wrench_complaints(tip)]
        if self._new_outputs and complaints:
            return WARN, '; '.join(complaints)
        doubts = pipeline.doubts()
        if self._new_messages and not self._new_outputs:
            if robot.at_work:
                return OK, f'no output yet: {robot.at_work}'
            return (WARN if doubts else OK), '; '.join(
                [f'no output: {self._most_frequent_use()}', *doubts])
        age = self._foreign_age()
        if age is not None:
            return WARN, (f'stamps are not of this clock: {abs(age):.6g} s '
                          f'{"old" if age > 0 else "ahead"}; is use_sim_time as it should be?')
        # Doubts are no fault: the estimator has already acted on them.
        return OK, '; '.join(['running', *doubts])

    def _wrench_complaints(self, tip: int) -> list[str]:
        """Return what is wrong with a force sensor whose compensated wrench is wanted."""
        sensor = self._robot.publishers.sensors[tip]
        topic = sensor.settings.wrench_topic
        now = self.counts.wrenches[tip]
        before = self._since.wrenches.get(tip, now)
        complaints = []
        if now.refused > before.refused:
            complaints.append(f'{topic}: {now.refused - before.refused} wrenches refused: '
                              f'{sensor.account.latest}')
        latest = sensor.latest_ns
        if not now.received:
            complaints.append(f'{topic}: no wrench has come')
        elif latest is not None and now.compensated == before.compensated:
            apart = (self._robot.stamp_ns - latest) * 1e-9
            if abs(apart) > sensor.settings.stale_timeout:
                complaints.append(
                    f'{topic}: the latest wrench is {abs(apart):.6g} s '
                    f'{"older" if apart > 0 else "newer"} than the latest joint states')
        return complaints

    def _most_frequent_fault(self, publishers: int) -> str:
        reason = self._new_faults.most_common(1)[0][0]
        if reason is Reason.STAMP_NOT_INCREASING and publishers > 1:
            return f'{reason} (the topic has {publishers} publishers)'
        return self._robot.account.told(reason)

    def _most_frequent_use(self) -> str:
        """Return what became of most of the messages that led to no output."""
        counts, since = self.counts, self._since
        became = counts.used_later - since.used_later or counts.refused - since.refused
        return str(became.most_common(1)[0][0]) if became else 'nothing used'

    def _foreign_age(self) -> float | None:
        """Return how old outputs are by stamps of another clock [s]; None if it is this one."""
        limit = FOREIGN_AGE + self._robot.settings.motion.delay
        age = self._age
        # One that is old is of this clock where the stream has but ended.
        comes = self._new_outputs > 0 or self._since.foreign
        return age if age is not None and (age < -limit or comes and age > limit) else None


def base_of(robot: Robot) -> MovingBase | None:
    """Return what is known of the motion of a robot's base; None: it does not move."""
    return None if robot.pipeline is None else robot.pipeline.base


def faults_of(robot: Robot) -> Counter[Reason]:
    """Return how often a robot refused a message for which reason that is a fault."""
    return Counter({reason: n for reason, n in robot.account.refused.items()
                    if reason not in HARMLESS})


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
