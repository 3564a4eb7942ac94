# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What every estimator of joint rates returns, and the protocol it obeys."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
CovarianceSource = Union[Array, Callable[[], Array], None]


class JointMotion:
    """
    Motion of `n` joints at one instant: position and its first three derivatives.

    Read-only. The covariance is computed when it is first asked for, so that a consumer who does
    not need it does not pay for it.

    Parameters
    ----------
    stamp:
        The instant the values describe, in s, in the time base of the samples.
    state: shape (4, n)
        Rows: position (rad or m), velocity, acceleration, jerk (per s, s^2, s^3).
    covariance:
        Array of shape (n, 4, 4) or a function without arguments that returns it; ``None`` when
        the estimator has no notion of it (the covariance is then NaN).

    Examples
    --------
    >>> motion = JointMotion(1.5, np.array([[0.1], [0.2], [0.3], [0.0]]))
    >>> motion.velocity
    array([0.2])

    """

    __slots__ = ('_covariance', 'state', 'stamp')

    def __init__(self, stamp: float, state: Array, covariance: CovarianceSource = None) -> None:
        state.setflags(write=False)
        self.stamp = stamp
        self.state = state
        self._covariance = covariance

    @property
    def position(self) -> Array:
        """Joint positions, shape (n,), rad or m; continuous joints are unwrapped."""
        return self.state[0]  # type: ignore[no-any-return]

    @property
    def velocity(self) -> Array:
        """Joint velocities, shape (n,), rad/s or m/s."""
        return self.state[1]  # type: ignore[no-any-return]

    @property
    def acceleration(self) -> Array:
        """Joint accelerations, shape (n,), rad/s^2 or m/s^2."""
        return self.state[2]  # type: ignore[no-any-return]

    @property
    def jerk(self) -> Array:
        """Joint jerks, shape (n,), rad/s^3 or m/s^3."""
        return self.state[3]  # type: ignore[no-any-return]

    @property
    def covariance(self) -> Array:
        """Covariance of (q, q', q'', q''') of each joint, shape (n, 4, 4), units of the rows."""
        covariance = self._covariance
        if covariance is None:
            covariance = np.full((self.state.shape[1], 4, 4), np.nan)
        elif not isinstance(covariance, np.ndarray):
            covariance = covariance()
        covariance.flags.writeable = False
        self._covariance = covariance
        return covariance

    def __repr__(self) -> str:
        """Show the stamp and the rows."""
        return f'JointMotion(stamp={self.stamp!r}, state={self.state!r})'


class RateEstimator(Protocol):
    """Anything that turns joint samples into joint motion, one sample at a time."""

    def update(
        self, stamp: float, position: ArrayLike, velocity: ArrayLike | None = None
    ) -> JointMotion | None:
        """
        Take one sample; return the motion it leads to, or ``None``.

        Parameters
        ----------
        stamp:
            Time of the sample, s. Subtract a start time in integer nanoseconds first: a float
            that counts from 1970 resolves only 0.24 us.
        position: shape (n,)
            Measured positions, rad or m.
        velocity: shape (n,)
            Measured velocities, rad/s or m/s; NaN or ``None`` where not measured.

        """
        ...

    def reset(self) -> None:
        """Forget every sample."""
        ...
