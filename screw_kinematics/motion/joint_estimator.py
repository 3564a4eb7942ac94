# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What all estimators share: which samples are taken, and how they are told the result."""

from __future__ import annotations

from abc import abstractmethod
from array import array
from collections.abc import Iterable, Mapping, Sequence
from math import hypot, nan

from numpy import ndarray
from numpy.typing import ArrayLike

from .admission import Admission
from .joint_motion import JointMotion
from .numbers import delay_of, Row, whole
from .units import times
from ..errors import InvalidValueError, Reason

EPOCH_SPAN_NS = 10**16
"""Beyond 116 days a float of seconds resolves less than 2 ns."""

LARGEST_VELOCITY = 1e6
"""Velocities beyond this (rad/s or m/s) count as not measured."""


class JointEstimator:
    """
    Base of the estimators: admits samples, restarts where needed, accounts for each sample.

    Parameters
    ----------
    n_joints : int
        Number of joints.
    delay : float
        Estimates describe the instant `delay` seconds before the latest sample.
    admission : Admission
        What decides which samples are taken.
    min_samples : int
        Samples of a run before the first estimate.

    """

    def __init__(self, n_joints: int, delay: float, admission: Admission,
                 min_samples: int = 8) -> None:
        self.n_joints = int(n_joints)
        self.delay = delay_of(delay)
        self.min_samples = whole('min_samples', min_samples)
        self.reason: Reason | None = Reason.SETTLING
        """Why the latest sample led to no estimate; None if it did."""
        self._admission = admission
        self._delay_ns = round(self.delay * 1e9)
        self._epoch_ns = 0

    def update(self, stamp: float, position: ArrayLike,
               velocity: ArrayLike | None = None) -> JointMotion | None:
        """
        Take one sample; return the motion it leads to, or None (see `reason`).

        Parameters
        ----------
        stamp : float
            Time of the sample, s. Subtract a start time in integer nanoseconds first, or use
            `step`: a float that counts from 1970 resolves only 0.24 us.
        position : array, shape (n_joints,)
            Measured positions, rad or m.
        velocity : array, shape (n_joints,)
            Measured velocities, rad/s or m/s; NaN or None where not measured.

        Returns
        -------
        JointMotion or None
            None while settling, or where the sample was refused.

        """
        outcome = self._take(float(stamp), _row(position),
                             None if velocity is None else _row(velocity))
        if isinstance(outcome, JointMotion):
            self.reason = None
            return outcome
        self.reason = outcome
        return None

    def step(self, stamp_ns: int, position: Sequence[float],
             velocity: Sequence[float] | None = None) -> JointMotion | Reason:
        """
        Take one sample with a stamp in ns; return the motion it leads to, or why there is none.

        The motion's `stamp_ns` is exact; its `stamp` counts from an epoch of the estimator.

        Parameters
        ----------
        stamp_ns : int
            Time of the sample, ns.
        position, velocity : sequence of float, length n_joints
            As for `update`.

        Returns
        -------
        JointMotion or Reason
            The motion, or why there is none.

        """
        since = stamp_ns - self._epoch_ns
        if not -EPOCH_SPAN_NS < since < EPOCH_SPAN_NS:
            self.reset()
            self._epoch_ns, since = stamp_ns, 0
        outcome = self._take(since * 1e-9, tuple(position),
                             None if velocity is None else tuple(velocity))
        if isinstance(outcome, JointMotion):
            self.reason = None
            outcome.stamp_ns = stamp_ns - self._delay_ns
        else:
            self.reason = outcome
        return outcome

    def reset(self) -> None:
        """Forget every sample; the counts stay."""
        self._admission.reset()
        self.reason = Reason.SETTLING

    def farthest(self, position: Row) -> tuple[int, float]:
        """
        Return the joint that is farthest from where it was last.

        Parameters
        ----------
        position : tuple of float, length n_joints
            Positions, rad or m, of a sample that was refused for instance.

        Returns
        -------
        int, float
            The joint's number, and how far it is from its latest position that was taken.

        """
        return self._admission.farthest(position)

    @property
    def refusals(self) -> Mapping[Reason, int]:
        """How many samples were refused, by reason."""
        return self._admission.refusals

    @property
    def restarts(self) -> Mapping[str, int]:
        """How many runs ended early, by reason."""
        return self._admission.restarts

    @property
    def velocity_used(self) -> Sequence[bool]:
        """Whether the measured velocity of each joint enters the estimate."""
        return [False] * self.n_joints

    def doubts(self, joint_names: Sequence[str] | None = None) -> list[str]:
        """
        Return what is odd about the samples, as short sentences.

        Parameters
        ----------
        joint_names : sequence of str, optional
            What to call the joints; by default their indices.

        Returns
        -------
        list of str
            One sentence each; empty if there is nothing.

        """
        admission = self._admission
        if not admission.restarts['gap']:
            return []
        return [f'pauses of up to {admission.longest_gap:.3g} s, longer than max_gap '
                f'{admission.max_gap:g} s: begun anew {times(admission.restarts["gap"])}']

    @abstractmethod
    def _take(self, stamp: float, position: Row,
              velocity: Row | None) -> JointMotion | Reason:
        """Take one sample, stamp in s; return the motion it leads to, or why there is none."""

    def _measured(self, velocity: Row) -> Row | None:
        """Return velocities, NaN where there is none; None if there are too few or many."""
        if len(velocity) != self.n_joints:
            return None
        if hypot(*velocity) < LARGEST_VELOCITY:
            return velocity
        return tuple([v if abs(v) < LARGEST_VELOCITY else nan for v in velocity])


def _row(values: ArrayLike) -> Row:
    """Return numbers in a row."""
    try:
        if isinstance(values, ndarray):
            return tuple(values.ravel().tolist())
        return tuple(array('d', values))    # type: ignore[arg-type]
    except TypeError:
        raise InvalidValueError(
            f'positions and velocities of a sample are numbers in a row; got {values!r}') from None


def listed(names: Iterable[object], chosen: Iterable[bool]) -> str:
    """Return the names of those that are chosen."""
    return ', '.join(str(name) for name, one in zip(names, chosen) if one)
