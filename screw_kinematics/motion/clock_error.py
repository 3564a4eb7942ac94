# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What none can know of the time of the device that read the joints: all of them err by it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Order = int
"""Of a derivative; under this name Cython 3.0.8 takes the type of C that is in the .pxd."""


@dataclass(frozen=True)
class ClockError:
    """Standard deviations of what stamps tell of a device's time."""

    time: float = 0.0    # of an instant, s
    rate: float = 0.0    # of how many seconds of the stamps' clock one of the device's takes

    def __bool__(self) -> bool:
        """Whether it errs at all."""
        return self.time > 0.0 or self.rate > 0.0

    def deviations(self, order: Order, own: Sequence[float],
                   onward: Sequence[float] = ()) -> list[list[float]]:
        """
        Return the deviations that all joints have at once: a row for each of the two.

        ``own`` is the derivative of that order of each joint's position, 0: the position itself;
        ``onward`` is the next one, none where it is not known.
        """
        found = []
        if self.time > 0.0 and len(onward):
            found.append([self.time * rate for rate in onward])
        if self.rate > 0.0 and order:
            by = order * self.rate
            found.append([by * rate for rate in own])
        return found

    def variance(self, order: Order, own: float, onward: float) -> float:
        """Return the variance that this is in a derivative of one joint's position."""
        late, fast = self.time * onward, order * self.rate * own
        return late * late + fast * fast

    def of_state(self, state: NDArray[np.float64]) -> NDArray[np.float64]:
        """
        Return the deviations of all orders, as arrays: nothing is next to the highest.

        Of positions, velocities, ... of the joints, shape (m, n), there is what they err by as the
        instant does, and as the rate does, shape (2, m, n).
        """
        onward = np.vstack([state[1:], np.zeros_like(state[:1])])
        orders = np.arange(float(len(state)))[:, None]
        return np.stack([self.time * onward, self.rate * orders * state])


EXACT = ClockError()
"""Of stamps that are right."""
