# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What every estimator of joint rates returns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Union

import numpy as np
from numpy.typing import NDArray

from .bank_covariance import BankCovariance
from .clock_error import EXACT

Array = NDArray[np.float64]
CovarianceSource = Union[Callable[[], Array], BankCovariance, None]


class JointMotion:
    """
    Motion of n joints at one instant: position and its first three derivatives.

    Read-only. Arrays are made when they are first asked for, so that nobody pays for what is not
    needed.

    Parameters
    ----------
    stamp : float
        The instant the values describe, in s, in the time base of the samples.
    values : sequence of float, length 4 n
        Positions (rad or m), then velocities, accelerations, jerks (per s, s^2, s^3).
    covariance : callable, optional
        A function without arguments that returns it, shape (n, 4, 4); None where it is not known
        (the covariance is then NaN).

    Attributes
    ----------
    stamp, values
        As given.
    stamp_ns : int
        The instant in ns, where the estimator was given ns; else 0.
    clock_error : ClockError
        What none can know of the time of the device that read the joints, of all joints alike.
        The covariance has what it adds to each.

    Examples
    --------
    >>> motion = JointMotion(1.5, [0.1, 0.2, 0.3, 0.0])
    >>> motion.velocity
    array([0.2])

    """

    __slots__ = ('_covariance', '_state', 'clock_error', 'stamp', 'stamp_ns', 'values')

    def __init__(self, stamp: float, values: Sequence[float],
                 covariance: CovarianceSource = None) -> None:
        self.stamp = stamp
        self.stamp_ns = 0
        self.clock_error = EXACT
        self.values = values
        self._state: Array | None = None
        self._covariance: CovarianceSource | Array = covariance

    @property
    def state(self) -> Array:
        """Return the values, shape (4, n): rows are position and its derivatives."""
        if self._state is None:
            self._state = np.array(self.values).reshape(4, -1)
            self._state.flags.writeable = False
        return self._state

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
        if not isinstance(covariance, np.ndarray):
            covariance = (np.full((len(self.values) // 4, 4, 4), np.nan) if covariance is None
                          else covariance())
            covariance.flags.writeable = False
            self._covariance = covariance
        return covariance

    @property
    def variances(self) -> list[float]:
        """Variances of positions, velocities, ... in a row, as the diagonals of the covariance."""
        if isinstance(self._covariance, BankCovariance):
            return self._covariance.variances()
        found: list[float] = np.diagonal(self.covariance, axis1=1, axis2=2).T.ravel().tolist()
        return found

    def variances_after(self, dt: float, order: int) -> list[float]:
        """
        Return the variances of one derivative where the motion's own ones carry it on.

        Parameters
        ----------
        dt : float
            By so much, s; may be negative.
        order : int
            The derivative of the positions, 0 to 3.

        Returns
        -------
        list of float, length n
            Those of each joint; NaN where not known.

        """
        steps = np.array([1.0, dt, dt**2 / 2, dt**3 / 6])[:4 - order]
        found: list[float] = (self.covariance[:, order:, order:] @ steps @ steps).tolist()
        return found

    def __repr__(self) -> str:
        """Show the stamp and the rows."""
        return f'JointMotion(stamp={self.stamp!r}, state={self.state!r})'
