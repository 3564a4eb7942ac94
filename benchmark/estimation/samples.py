# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What estimators are given, and what they return."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np


@dataclass(frozen=True)
class Samples:
    """Messages in the order in which they come."""

    stamps: np.ndarray                # (N,), s
    positions: np.ndarray             # (N, n)
    velocities: np.ndarray | None     # (N, n)
    ahead: np.ndarray                 # (N,), of the stamps' clock before the truth's, s

    def increasing(self) -> np.ndarray:
        """Return the rows whose stamp is later than all before."""
        before = np.maximum.accumulate(self.stamps)[:-1]
        return np.flatnonzero(np.append(True, self.stamps[1:] > before))

    def period(self) -> float:
        """Return the median step of the stamps, s."""
        return float(np.median(np.diff(self.stamps[self.increasing()])))


class Result(NamedTuple):
    """
    Estimates: rows (of the samples that led to them), claimed instants t, and what they say.

    How far the instants lie `behind` the samples (s); `cost` in us per sample; `variance` of
    position, velocity, acceleration, jerk, shape (N, 4, n), where the estimator tells it.
    """

    rows: np.ndarray
    t: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    behind: float
    cost: float
    variance: np.ndarray | None = None
