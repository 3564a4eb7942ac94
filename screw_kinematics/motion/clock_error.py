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
                   onward: Sequence[float]) -> tuple[list[float], list[float]]:
        """
        Return what all joints err by at once: as the instant does, and as the rate does.

        ``own`` is the derivative of that order of each joint's position, 0: the position itself;
        ``onward`` is the next one, empty where it is not known, as what the instant adds is then.
        """
        by = order * self.rate
        return [self.time * rate for rate in onward], [by * rate for rate in own]

    def variance(self, order: Order, own: float, onward: float) -> float:
        """Return the variance that this is for one joint: as numbers, which takes an eighth."""
        late, fast = self.time * onward, order * self.rate * own
        return late * late + fast * fast

    def of_state(self, state: NDArray[np.float64]) -> NDArray[np.float64]:
        """
        Return the deviations of all orders, as arrays: nothing is next to the highest.

        Of positions, velocities, ... of the joints, shape (m, n), there is what they err by as the
        instant does, and as the rate does, shape (2, m, n).
        """
        onward = [*state[1:], np.zeros_like(state[0])]
        return np.array([self.deviations(order, *rows) for order, rows in enumerate(
            zip(state, onward))]).swapaxes(0, 1)


EXACT = ClockError()
"""Of stamps that are right."""
