# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What none can know of the time of the device that read the joints: all of them err by it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class ClockError(NamedTuple):
    """Standard deviations of what stamps tell of a device's time."""

    time: float = 0.0    # of an instant, s
    rate: float = 0.0    # of how many seconds of the stamps' clock one of the device's takes

    def deviations(self, order: int, own: Sequence[float],
                   onward: Sequence[float] = ()) -> list[list[float]]:
        """
        Return the deviations that all joints have at once: a row for each of the two.

        ``own`` is the derivative of that order of each joint's position, 0: the position itself;
        ``onward`` is the next one, none where it is not known.
        """
        found = []
        if self.time and len(onward):
            found.append([self.time * rate for rate in onward])
        if self.rate and order:
            found.append([order * self.rate * rate for rate in own])
        return found

    def of_state(self, state: NDArray[np.float64]) -> NDArray[np.float64]:
        """
        Return the same of all orders, as arrays: nothing is next to the highest.

        Of positions, velocities, ... of the joints, shape (m, n), there is what they err by as the
        instant does, and as the rate does, shape (2, m, n).
        """
        onward = np.vstack([state[1:], np.zeros_like(state[:1])])
        orders = np.arange(float(len(state)))[:, None]
        return np.stack([self.time * onward, self.rate * orders * state])


EXACT = ClockError()
"""Of stamps that are right."""
