# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
From joint samples to end-effector states: the logic of one robot in the node, without ROS.

A sample goes through naming (which joints does it bring), motion (positions, velocities,
accelerations at one instant) and the compiled chain. Every sample ends as used or as refused,
and the reasons are counted.
"""
from __future__ import annotations

from collections.abc import Callable, Sequence
from math import hypot
from typing import Any, Protocol

from .account import Account
from .group_motion import GroupMotion, LARGEST, MotionSettings
from .joint_groups import JointGroups, Layout
from .silence import Silence
from .synchronizer import Rounds
from ..errors import ScrewKinematicsError

WRONG_LENGTH = 'position_of_wrong_length'
NOT_FINITE = 'position_not_finite'
NO_SOLUTION = 'no_state_at_this_posture'
OVERFLOW = 'state_not_finite'


class Program(Protocol):
    """What a compiled robot offers."""

    order: int
    inputs: int

    @property
    def evaluate(self) -> Callable[[Sequence[float]], Sequence[float]]:
        """Return the outputs from positions, velocities, ... of the joints."""


class RobotPipeline:
    """
    One robot's way from joint samples to the values of its outputs.

    Parameters
    ----------
    joint_names : sequence of str
        The measured joints.
    settings : MotionSettings
    continuous : sequence of bool, optional
        For each joint whether its position wraps at 2 pi; by default none does.
    max_apart : float
        Joints measured further apart in time than this are not joined [s].
    account : Account, optional
        Goes on with these counts.

    Examples
    --------
    >>> from screw_kinematics import Joint, SerialChain
    >>> arm = SerialChain([Joint('q1', 'revolute', axis=(0, 0, 1), point=(-2, 0, 0))])
    >>> pipeline = RobotPipeline(arm.joint_names, MotionSettings(velocity_source='measured'))
    >>> pipeline.want(arm.compile(outputs=('twist',)))
    >>> pipeline.take(5, ('lamp', 'q1'), (7.0, 0.0), (0.0, 1.0))
    (0.0, 0.0, 1.0, -0.0, 2.0, 0.0)
    >>> pipeline.take(6, ('q1',), (), ()), dict(pipeline.account.refused)
    (None, {'position_of_wrong_length': 1})

    """

    def __init__(self, joint_names: Sequence[str], settings: MotionSettings,
                 continuous: Sequence[bool] | None = None, max_apart: float = 0.5,
                 account: Account | None = None) -> None:
        self.account = Account() if account is None else account
        self.last_error = ''
        self.stamp_ns = 0
        self.motion: Sequence[float] = ()
        self._joints = JointGroups(joint_names)
        self._continuous = tuple(continuous) if continuous is not None else (
            (False,) * len(joint_names))
        self._motions: dict[tuple[int, ...], GroupMotion] = {}      # by columns of the joints
        self._rounds = Rounds(len(joint_names))
        self._silence = Silence()
        self._names: tuple[str, ...] | None = None
        self._layout: Layout | None = None
        self._group_motion: GroupMotion | None = None
        self._program: Program | None = None
        self._order, self._covariance = 0, False
        self.configure(settings, max_apart)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the measured joints."""
        return self._joints.joint_names

    def want(self, program: Program | None, covariance: bool = False) -> None:
        """
        Set what is evaluated for each sample from now on; estimators go on.

        Parameters
        ----------
        program : Program or None
            None: nothing is wanted, samples are only accounted for.
        covariance : bool
            Whether :meth:`variances` will be asked for.

        """
        self._program = program
        self._covariance = covariance
        self._order = 0 if program is None else program.order
        for motion in self._motions.values():
            motion.want(self._order, covariance)

    def configure(self, settings: MotionSettings, max_apart: float) -> None:
        """Go over to other settings; joint motion goes on where its settings are the same."""
        self._rounds.max_apart_ns = round(max_apart * 1e9)
        if getattr(self, 'settings', settings) != settings:
            self._motions.clear()
            self._rounds.clear()
            self._names = None
        self.settings = settings

    def take(self, stamp_ns: int, names: tuple[str, ...], position: Sequence[float],
             velocity: Sequence[float]) -> Sequence[float] | None:
        """
        Take a joint sample; return what the program makes of it.

        Parameters
        ----------
        stamp_ns : int
            Time of the measurement [ns].
        names : tuple of str
            Joint names; while it is the same object, nothing is looked up.
        position : sequence of float
            [rad, m].
        velocity : sequence of float
            [rad/s, m/s]; empty or NaN where not measured.

        Returns
        -------
        sequence of float or None
            Values of the program's outputs at the instant ``self.stamp_ns``.

        """
        account = self.account
        account.received += 1
        if names is not self._names:
            self._look_up(names)
        layout = self._layout
        if layout is None:
            return self._refuse(self._why_not)
        if len(position) != layout.length:
            return self._refuse(WRONG_LENGTH)
        q = layout.pick(position)
        if not hypot(*q) < LARGEST:     # NaN, infinite, or absurd
            return self._refuse(NOT_FINITE)
        group, group_motion = layout.group, self._group_motion
        group.messages += 1
        program = self._program
        if program is None:
            account.waiting['nothing_wanted'] += 1
            return None
        if group_motion is None:
            group_motion = self._group_motion = self._make_motion(group.columns)
        motion = group_motion.update(
            stamp_ns, q, layout.pick(velocity) if len(velocity) == layout.length else None)
        if motion is None:
            if group_motion.refusal is not None:
                return self._refuse(group_motion.refusal)
            account.waiting['estimator_settling'] += 1
            return None
        instant = group_motion.stamp_ns
        if not group.complete:
            joined = self._rounds.add(group, instant, motion)
            if joined is None:
                account.waiting['merged_with_later_ones'] += 1
                return None
            if isinstance(joined, str):
                return self._refuse(joined)
            instant, motion = joined
        try:
            values = program.evaluate(
                motion if len(motion) == program.inputs else motion[:program.inputs])
        except (ScrewKinematicsError, ArithmeticError, ValueError) as error:
            self.last_error = str(error)
            return self._refuse(NO_SOLUTION)
        total = sum(values)
        if total - total != 0.0:
            return self._refuse(OVERFLOW)
        self.stamp_ns = instant
        self.motion = motion
        account.outputs += 1
        return values

    def reset(self) -> None:
        """Start anew, as after a jump of the clock; counts stay."""
        self._rounds.clear()
        self._silence.clear()
        for motion in self._motions.values():
            motion.reset()

    def release_silent(self, now: float, timeout: float) -> bool:
        """
        Forget groups of joints that come no more: they are missing from then on.

        Parameters
        ----------
        now : float
            Any clock [s].
        timeout : float
            Silence after which a group is forgotten [s].

        Returns
        -------
        bool
            Whether there was one.

        """
        silent = self._silence.of(self._joints.groups, now, timeout)
        for group in silent:
            self._joints.release(group)
            self._names = None
        self._rounds.keep(self._joints.groups)
        return bool(silent)

    def missing(self) -> list[str]:
        """Return the names of the joints that are not known at present."""
        return self._joints.missing()

    def variances(self, derivative: int) -> list[float]:
        """
        Return the variance of each joint's position (0), velocity (1), acceleration (2), ...

        Returns
        -------
        list of float
            In squared units of the quantity; NaN where it is not known.

        """
        out = [float('nan')] * len(self.joint_names)
        measured = derivative == 1 and self.settings.velocity_source == 'measured'
        for columns, of_group in self._motions.items():
            if of_group.motion is not None and not measured:
                values = of_group.motion.covariance[:, derivative, derivative].tolist()
                for column, value in zip(columns, values):
                    out[column] = value
        return out

    def doubts(self) -> list[str]:
        """Return what the estimators find odd about the samples."""
        return [doubt for columns, motion in self._motions.items()
                if motion.estimator is not None
                for doubt in motion.estimator.doubts([self.joint_names[c] for c in columns])]

    def estimators(self) -> list[Any]:
        """Return the estimators at work."""
        return [m.estimator for m in self._motions.values() if m.estimator is not None]

    def _look_up(self, names: tuple[str, ...]) -> None:
        found = self._joints.find(names)
        self._names = names
        if isinstance(found, str):
            self._layout, self._why_not = None, found
            return
        self._layout = found
        self._group_motion = self._motions.get(found.group.columns)

    def _make_motion(self, columns: tuple[int, ...]) -> GroupMotion:
        """Return the motion of a new group, in place of those that had joints of it."""
        for others in list(self._motions):
            if not set(columns).isdisjoint(others):
                del self._motions[others]
        self._rounds.keep(self._joints.groups)
        motion = self._motions[columns] = GroupMotion(
            self.settings, [self._continuous[c] for c in columns], self._order,
            self._covariance)
        return motion

    def _refuse(self, reason: str) -> Sequence[float] | None:
        self.account.refused[reason] += 1
        return None
