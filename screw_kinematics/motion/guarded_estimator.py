# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What all estimators share: the guard at the door, the counts, and the run's length."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .guard import SampleGuard
from .joint_motion import Array, CovarianceSource, JointMotion
from ..errors import InvalidValueError

ESTIMATE = 'estimate'
WARMING_UP = 'warming up'


class GuardedEstimator(ABC):
    """
    Base of the estimators: refuses bad samples, restarts where needed, accounts for each sample.

    Parameters
    ----------
    n_joints:
        Number of joints.
    delay:
        Estimates describe the instant `delay` seconds before the latest sample.
    min_samples:
        Samples of a run before the first estimate.
    **limits:
        `max_gap`, `continuous`, ... of `SampleGuard`.

    """

    def __init__(
        self, n_joints: int, *, delay: float = 0.0, min_samples: int = 8, **limits: Any
    ) -> None:
        if n_joints < 1:
            raise InvalidValueError(f'n_joints is {n_joints}; allowed: 1 or more')
        if not 0.0 <= delay <= 1.0:
            raise InvalidValueError(f'delay is {delay} s; allowed: 0 to 1 s')
        if min_samples < 1:
            raise InvalidValueError(f'min_samples is {min_samples}; allowed: 1 or more')
        self.n_joints = n_joints
        self.delay = float(delay)
        self.min_samples = int(min_samples)
        self.last_outcome = WARMING_UP
        """``'estimate'``, ``'warming up'``, or ``'refused: '`` and the reason."""
        self.stamp = 0.0
        """The instant that the latest estimate describes, s."""
        self._guard = SampleGuard(n_joints, **limits)
        self._state = np.zeros((4, n_joints))

    def update(
        self, stamp: float, position: ArrayLike, velocity: ArrayLike | None = None
    ) -> JointMotion | None:
        """
        Take one sample; return the motion it leads to, or ``None`` (see `last_outcome`).

        Parameters
        ----------
        stamp:
            Time of the sample, s. Subtract a start time in integer nanoseconds first: a float
            that counts from 1970 resolves only 0.24 us.
        position: shape (n_joints,)
            Measured positions, rad or m.
        velocity: shape (n_joints,)
            Measured velocities, rad/s or m/s; NaN or ``None`` where not measured.

        """
        return self.motion() if self.push(stamp, position, velocity) else None

    def push(
        self, stamp: float, position: ArrayLike, velocity: ArrayLike | None = None
    ) -> bool:
        """
        Take one sample, as `update` does; return whether there is an estimate.

        It is then asked for by `motion`, or by `values`, which costs less.
        """
        guard = self._guard
        dt = guard.admit(stamp, np.array(position, float))
        if dt < 0.0:
            self.last_outcome = f'refused: {guard.last_refusal}'
            return False
        measured = None
        if velocity is not None:
            measured = np.array(velocity, float)
            if measured.shape != guard.position.shape:
                measured = None
        state = None
        if dt == 0.0:
            self._start(stamp, guard.position, measured)
        else:
            state = self._advance(stamp, dt, guard.position, measured)
        if state is None:
            self.last_outcome = WARMING_UP
            return False
        self._state = state
        self.last_outcome = ESTIMATE
        return True

    def motion(self) -> JointMotion:
        """Return the estimate that the latest sample led to; it stays as it is."""
        return JointMotion(self.stamp, self._state, self._covariance_source())

    def values(self) -> Sequence[float]:
        """Return positions, velocities, accelerations and jerks of that estimate in a row."""
        values: list[float] = self._state.ravel().tolist()
        return values

    def reset(self) -> None:
        """Forget every sample; the counts stay."""
        self._guard.reset()
        self.last_outcome = WARMING_UP

    def warm_up(self) -> None:
        """Do now what would otherwise delay the first samples (compilation, tables)."""

    @property
    def refusals(self) -> Mapping[str, int]:
        """How many samples were refused, by reason."""
        return self._guard.refusals

    @property
    def last_refusal(self) -> str | None:
        """Why the latest refused sample was refused."""
        return self._guard.last_refusal

    @property
    def restarts(self) -> Mapping[str, int]:
        """How many runs ended early, by reason."""
        return self._guard.restarts

    @property
    def velocity_used(self) -> Array:
        """Whether the measured velocity of each joint enters the estimate, shape (n_joints,)."""
        return np.zeros(self.n_joints, bool)

    def doubts(self, joint_names: Sequence[str] | None = None) -> list[str]:
        """Return what is odd about the samples, as short sentences."""
        return []

    @abstractmethod
    def _start(self, stamp: float, position: Array, velocity: Array | None) -> None:
        """Begin a run with this sample."""

    @abstractmethod
    def _advance(
        self, stamp: float, dt: float, position: Array, velocity: Array | None
    ) -> Array | None:
        """
        Take the next sample of the run, `dt` > 0 after the one before.

        Returns
        -------
        The state (4, n) at the instant `stamp`, an attribute to be set; None if there is none.

        """

    def _covariance_source(self) -> CovarianceSource:
        """Return the covariance of the latest state, or a function that returns it."""
        return None
