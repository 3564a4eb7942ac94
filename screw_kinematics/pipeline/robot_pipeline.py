# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
From joint samples to end-effector states: the way of a sample through one robot, without ROS.

It is :meth:`RobotPipeline.take`, which reads from top to bottom. Each step takes what the step
before has given, and gives the next thing or the reason why there is none.
"""
from __future__ import annotations

from collections.abc import Sequence

from .account import Account
from .group_motion import GroupMotion, make_motion, Motion
from .joint_groups import JointGroup, JointGroups, listed, Reading
from .kinematics import Kinematics, State
from .moving_base import MovingBase
from .settings import MotionSettings
from .stream_watch import NO_VELOCITIES, StreamWatch
from .synchronizer import Synchronizer
from ..errors import Reason, ScrewKinematicsError
from ..messages.joint_state import JointSample
from ..motion import JointEstimator


class RobotPipeline:
    """
    One robot's way from joint samples to states.

    Positions wrap at 2 pi where they are continuous; joints that seem faster than their
    ``max_velocity`` [rad/s, m/s] are refused, those measured further apart in time than
    ``max_apart`` [s] not joined. The configuration is all of the parameters but the account, which
    goes on. The base is needed where something is relative to the world.

    Examples
    --------
    >>> from screw_kinematics import Joint, SerialChain
    >>> from screw_kinematics.pipeline.kinematics import Kinematics
    >>> from screw_kinematics.pipeline.robot_program import OneTip
    >>> arm = SerialChain([Joint('q1', 'revolute', axis=(0, 0, 1), point=(-2, 0, 0))])
    >>> pipeline = RobotPipeline(arm.joint_names, MotionSettings(velocity_source='measured'))
    >>> pipeline.activate(Kinematics(OneTip(arm.compile(outputs=('twist',)))))
    >>> pipeline.take(JointSample(5, ('lamp', 'q1'), (7.0, 0.0), (0.0, 1.0))).values
    (0.0, 0.0, 1.0, -0.0, 2.0, 0.0)
    >>> pipeline.take(JointSample(6, ('q1',), (), ()))
    <Reason.WRONG_LENGTH: 'position_of_wrong_length'>

    """

    def __init__(self, joint_names: Sequence[str], settings: MotionSettings,
                 continuous: Sequence[bool] | None = None,
                 max_velocity: Sequence[float] | None = None, max_apart: float = 0.5,
                 account: Account | None = None) -> None:
        self.account = Account() if account is None else account
        self.settings = settings
        self._offset_ns = settings.stamp_offset_ns
        self.continuous = (False,) * len(joint_names) if continuous is None else (
            tuple(continuous))
        self.max_velocity = (settings.max_velocity,) * len(joint_names) if max_velocity is None \
            else tuple(max_velocity)
        self.configuration = (tuple(joint_names), settings, self.continuous, self.max_velocity,
                              max_apart)
        self._groups = JointGroups(joint_names)
        # By columns: joints that fall silent and come again go on.
        self._motions: dict[tuple[int, ...], GroupMotion] = {}
        self._watches: dict[tuple[int, ...], StreamWatch] = {}
        self._synchronizer = Synchronizer(len(joint_names), round(max_apart * 1e9))
        self._kinematics: Kinematics | None = None
        self.base: MovingBase | None = None

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the measured joints."""
        return self._groups.joint_names

    def activate(self, kinematics: Kinematics | None) -> None:
        """Set what is computed for each sample from now on, if anything; estimators go on."""
        self._kinematics = kinematics
        if kinematics is not None:
            for columns, motion in self._motions.items():
                self._motions[columns] = self._make_motion(columns, kinematics, motion)

    def take(self, sample: JointSample) -> State | Reason:
        """Take a joint sample; return the robot's state, or why there is none."""
        account = self.account
        if self._offset_ns:
            sample = sample._replace(stamp_ns=sample.stamp_ns + self._offset_ns)
        found = self._groups.read(sample)
        if not isinstance(found, Reading):
            return account.close(found, self._groups.describe(sample, found))
        reading = found         # whose type is in the .pxd
        group = reading.group
        watch = self._watches.get(group.columns) or self._begin_watch(group)
        watch.update(reading)
        kinematics = self._kinematics
        if kinematics is None:
            return account.close(Reason.NOTHING_WANTED)
        motion = self._motions.get(group.columns) or self._begin(group, kinematics)
        moving = motion.update(reading)
        if not isinstance(moving, Motion):
            return account.close(moving, self._describe(reading, moving))
        whole = moving if group.complete else self._synchronizer.add(group, moving)
        if not isinstance(whole, Motion):
            return account.close(whole)
        base = None
        if kinematics.moving_base:
            assert self.base is not None
            moved = self.base.at(whole.stamp_ns)
            if not isinstance(moved, Reason):
                base = moved
            elif kinematics.standing_base:
                account.without_base += 1
            else:
                return account.close(moved, self.base.problem())
        try:
            state = kinematics.evaluate(whole, base)
        except (ScrewKinematicsError, ArithmeticError, ValueError) as error:
            return account.close(Reason.NO_SOLUTION, str(error))
        if isinstance(state, State) and state.order < kinematics.told:
            account.incomplete += 1
        return account.close(state)

    def reset(self) -> None:
        """Start anew, as after a jump of the clock; counts stay."""
        self._synchronizer.clear()
        for group in self._groups.groups:
            group.await_messages()
        for motion in self._motions.values():
            motion.reset()
        if self.base is not None:
            self.base.reset()

    def release_stale(self, now: float, timeout: float) -> bool:
        """Forget groups of joints that are silent for a timeout [s]; return whether any was."""
        stale = self._groups.stale_groups(now, timeout)
        for group in stale:
            self._groups.release(group)
        if stale:
            self._synchronizer.keep(self._groups.groups)
        return bool(stale)

    def missing(self) -> list[str]:
        """Return the names of the joints that are not known at present."""
        return self._groups.missing()

    def describe_missing(self) -> str:
        """Return a sentence on them, and on names that are like theirs."""
        return self._groups.describe_missing()

    def doubts(self) -> list[str]:
        """Return what the estimators find odd about the samples."""
        doubts = []
        for columns, motion in self._motions.items():
            if motion.estimator is not None:
                names = [self.joint_names[column] for column in columns]
                whose = '' if len(names) == len(self.joint_names) else f'{listed(names)}: '
                doubts += [whose + doubt for doubt in motion.estimator.doubts(names)]
        return doubts if self.base is None else [*doubts, *self.base.doubts()]

    def faults(self, publishers: int) -> list[str]:
        """Return what is wrong with the streams, of topics with so many publishers."""
        faults = [f for watch in self._watches.values() for f in watch.findings(publishers)]
        return faults if self.base is None else [*faults, *self.base.faults()]

    @property
    def lost(self) -> int:
        """How many readings never came, as far as pauses in the stamps tell."""
        return sum(watch.lost for watch in self._watches.values())

    def estimators(self) -> list[JointEstimator]:
        """Return the estimators at work."""
        return [m.estimator for m in self._motions.values() if m.estimator is not None]

    def _describe(self, reading: Reading, outcome: Reason) -> str:
        """Return what to do, or which joint a reading was refused for, if that tells more."""
        if outcome is Reason.NO_VELOCITY:
            return f"velocity_source is 'measured': {NO_VELOCITIES}"
        columns = reading.group.columns
        estimator = self._motions[columns].estimator
        if outcome is not Reason.IMPLAUSIBLE_JUMP or estimator is None:
            return ''
        joint, by = estimator.farthest(tuple(reading.position))
        return f'{self.joint_names[columns[joint]]} by {by:.3g}'

    def _begin_watch(self, group: JointGroup) -> StreamWatch:
        """Return what watches a group of joints from its first reading on."""
        watch = self._watches[group.columns] = StreamWatch(
            [self.joint_names[column] for column in group.columns],
            [self.continuous[column] for column in group.columns],
            self.settings.velocity_source == 'measured')
        return watch

    def _begin(self, group: JointGroup, kinematics: Kinematics) -> GroupMotion:
        """Return the motion of a new group, in place of those that had joints of it."""
        for others in list(self._motions):
            if not set(group.columns).isdisjoint(others):
                del self._motions[others]
        self._synchronizer.keep(self._groups.groups)
        motion = self._motions[group.columns] = self._make_motion(group.columns, kinematics)
        return motion

    def _make_motion(self, columns: tuple[int, ...], kinematics: Kinematics,
                     before: GroupMotion | None = None) -> GroupMotion:
        return make_motion(self.settings, [self.continuous[c] for c in columns],
                           [self.max_velocity[c] for c in columns],
                           kinematics.order, kinematics.covariance, before,
                           joined=len(columns) < len(self.joint_names))
