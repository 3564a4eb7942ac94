# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How far the velocity field of each joint deserves to be believed."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .joint_motion import Array
from .velocity_block import NEIGHBOURS
from .velocity_evidence import DIFFERENCED, judge, LAGGING, MOVED, OF_A_RUN, RATIO, ROWS, WINDOWS

PAUSE = 0.1
"""A pause in the velocities after which old ones are forgotten, s."""

BLOCK, BLOCK_TIME, LONGEST_BLOCK = 8, 0.04, 64
"""Samples are judged together when there are `BLOCK`, and after the first blocks when these span
`BLOCK_TIME` s too, or there are `LONGEST_BLOCK`."""

FIRST_BLOCKS = 12
"""The blocks from which the noise is first known."""

LARGEST = 1e6
"""Velocities beyond this (rad/s or m/s) count as not measured."""

MISSING = 1e30
"""Ratio of variances for a velocity that is used, but missing in a sample."""


class VelocityTrust:
    """
    Noise of position and velocity, and whether the velocity is what it claims to be.

    White noise of both is read from sixth divided differences; a velocity that lags, is filled
    with zeros, or otherwise is not the derivative of the position shows in the leaky integral of
    velocity minus position step; one that the driver merely differenced from the position shows
    in what is left when the differenced position is taken from it: the position's noise, with
    the opposite sign.

    Attributes
    ----------
    ratio: shape (n,)
        Variance of the velocity's noise over the position's, in scaled units; infinite where the
        velocity is not used. None where no joint's is used.
    known:
        What `velocity_evidence.judge` has found.

    """

    def __init__(self, n_joints: int) -> None:
        self.n_joints = n_joints
        self.known = np.zeros((ROWS, n_joints))
        self.start()

    def start(self) -> None:
        """Begin a run; what is known of the noise stays."""
        self._forget_samples()
        self._judged = -math.inf
        self._blocks = 0
        self.ratio: Array | None = None
        known = self.known = self.known.copy()
        known[OF_A_RUN] = 0.0
        known[RATIO] = np.inf

    def _forget_samples(self) -> None:
        self._stamps: list[float] = []
        self._positions: list[Array] = []
        self._velocities: list[Array] = []

    @property
    def run(self) -> tuple[list[float], list[Array], list[Array], float, int]:
        """Return stamps, positions, velocities not yet judged; last judgement; their number."""
        return self._stamps, self._positions, self._velocities, self._judged, self._blocks

    @run.setter
    def run(self, run: tuple[list[float], list[Array], list[Array], float, int]) -> None:
        """Go on after these samples."""
        self._stamps, self._positions, self._velocities, self._judged, self._blocks = run

    @property
    def lagging(self) -> NDArray[np.bool_]:
        """Which velocities disagree with the positions for longer than noise would, shape (n,)."""
        return self.known[LAGGING] > 0.0

    @property
    def differenced(self) -> NDArray[np.bool_]:
        """Which velocities repeat the noise of differenced positions, shape (n,)."""
        return self.known[DIFFERENCED] > 0.0

    @property
    def idle(self) -> NDArray[np.bool_]:
        """Which velocities were never non-zero though the joint moved, shape (n,)."""
        return (self.known[MOVED] == 0.0) & (self.known[WINDOWS] > 0.0) & (self._blocks > 0)

    def push(
        self, stamp: float, position: Array, velocity: Array | None
    ) -> tuple[Array | None, Array | None]:
        """
        Take one sample.

        Returns
        -------
        The velocity with zeros where it is not measured, and `ratio` with infinity there; a pair
        of None if no joint's velocity is of use.

        """
        if velocity is None:
            return None, None
        whole = math.hypot(*velocity.tolist()) < LARGEST
        if not whole:
            velocity = np.where(np.abs(velocity) < LARGEST, velocity, np.nan)
        stamps = self._stamps
        if stamps and stamp - stamps[-1] > PAUSE:
            self._forget_samples()
            stamps = self._stamps
        stamps.append(stamp)
        self._positions.append(position)
        self._velocities.append(velocity)
        if len(stamps) >= NEIGHBOURS + BLOCK and (
                stamp - self._judged >= BLOCK_TIME or self._blocks < FIRST_BLOCKS
                or len(stamps) >= NEIGHBOURS + LONGEST_BLOCK):
            self._judge()
            self._judged = stamp
        ratio = self.ratio
        if ratio is None:
            return None, None
        if not whole:
            measured = np.isfinite(velocity)
            velocity = np.where(measured, velocity, 0.0)
            if (np.isfinite(ratio) & ~measured).any():
                ratio = np.where(measured | np.isinf(ratio), ratio, MISSING)
        return velocity, ratio

    def _judge(self) -> None:
        """Judge the samples; the last ones stay as neighbours of those to come."""
        shape = len(self._stamps), self.n_joints
        self.known, changed = judge(
            np.array(self._stamps), np.concatenate(self._positions).reshape(shape),
            np.concatenate(self._velocities).reshape(shape), self.known, self._blocks)
        self._blocks += 1
        for kept in self._stamps, self._positions, self._velocities:
            del kept[:-NEIGHBOURS]
        if changed:
            ratio = self.known[RATIO]
            self.ratio = ratio if np.isfinite(ratio).any() else None
