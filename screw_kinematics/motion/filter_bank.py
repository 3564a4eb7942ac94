# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Which filters a bank has, and what its numbers mean; its loops are in the core."""

from __future__ import annotations

from ..core.bank import Bank

FILTERS = (*((4, f) for f in (2.0, 3.5, 6.0, 10.5, 18.0, 32.0, 56.0, 98.0, 170.0, 300.0)),
           *((3, f) for f in (20.0, 40.0, 80.0, 140.0, 400.0)))
"""Order of the model and bandwidth, Hz, of the filters that see the past only."""

WIDE = 0.5
"""Handicap of wide filters: what the innovation's log variance counts more in their score."""

SMOOTHING_FILTERS = tuple((order, f) for order, f in FILTERS if order == 4)
SMOOTHING_WIDE = 0.7
"""The same for filters that are smoothed: what predicts best is too wide to smooth with."""


def make_bank(n_joints: int, delay: float) -> Bank:
    """Return a bank for estimates of the instant `delay` s before the latest sample."""
    if delay > 0.0:
        return Bank(n_joints, SMOOTHING_FILTERS, SMOOTHING_WIDE, delay)
    return Bank(n_joints, FILTERS, WIDE, 0.0)
