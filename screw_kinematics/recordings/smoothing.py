# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The motion of all joints of a robot in one block of recorded samples."""
from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .blocks import Block, GroupSamples
from .interpolation import interpolate, NODES
from ..errors import InvalidValueError, Reason
from ..motion.smoother import smooth
from ..pipeline.settings import MotionSettings
from ..screws.se3 import Array

LEAST = 8
"""Samples that a run must have."""


class MotionBlock(NamedTuple):
    """Motion of all joints of a robot."""

    stamps: Array                     # (N,) [ns]
    received: Array                   # (N,), when their samples came [ns]
    motion: Array                     # (order + 1, N, n), positions, velocities, ...
    refused: Counter[Reason]          # samples that were not used
    variances: Array                  # (4, N, n), to the jerks'; NaN where not estimated
    period: float                     # median of those joints that come most seldom [s]
    findings: tuple[str, ...] = ()    # what is odd about the samples


class Smoother:
    """Smooths blocks of one robot, to a derivative of at most 4; may be sent elsewhere."""

    def __init__(self, settings: MotionSettings, continuous: Sequence[bool],
                 max_velocity: Sequence[float], order: int, joint_names: Sequence[str]) -> None:
        self.joint_names = tuple(joint_names)
        self.source = settings.velocity_source
        self.max_gap = settings.options['max_gap']
        self.max_velocity = tuple(max_velocity)
        self.continuous = tuple(continuous)
        self.order = order

    def __call__(self, block: Block) -> MotionBlock:
        """Return the motion at the block's instants: those of the joints that come most often."""
        refused: Counter[Reason] = Counter()
        parts = [self._motion(samples, refused) for samples in block]
        n = len(self.continuous)
        none = np.zeros(0, dtype=np.int64)
        period = max(_median_step(samples.stamps) for samples in block)
        findings = tuple(dict.fromkeys(f for part in parts for f in part.findings))
        nothing = MotionBlock(none, none, np.zeros((self.order + 1, 0, n)), refused,
                              np.zeros((4, 0, n)), period, findings)
        if sum(len(samples.columns) for samples in block) < n or not all(
                part.own.any() for part in parts):
            return nothing
        most = max(int(part.own.sum()) for part in parts)
        # Of joints that come as often the same in all blocks, whatever their ends hold of each.
        clock = next(part for part in parts if part.own.sum() >= 0.9 * most - 1)
        own = clock.own
        motion, together = np.empty((self.order + 1, int(own.sum()), n)), np.ones(own.sum(), bool)
        variances = np.empty((4, int(own.sum()), n))
        instants = clock.stamps[own]
        for samples, part in zip(block, parts):
            if part is clock:
                motion[:, :, samples.columns] = part.motion[:, own]
                variances[:, :, samples.columns] = part.variances[:, own]
                continue
            known, at = part.at(instants)
            together &= known
            motion[:, :, samples.columns] = at
            near = np.clip(np.searchsorted(part.stamps, instants), 0, len(part.stamps) - 1)
            variances[:, :, samples.columns] = part.variances[:, near]
        refused[Reason.TOO_FAR_APART] += int((~together).sum())
        return MotionBlock(instants[together], clock.received[own][together],
                           motion[:, together], refused, variances[:, together], period,
                           findings)

    def _motion(self, samples: GroupSamples, refused: Counter[Reason]) -> _GroupMotion:
        """Return the motion of joints that come together; count what was not used of the own."""
        number = np.arange(len(samples.stamps))
        own = (number >= samples.begin) & (number < samples.end)
        measured = np.isfinite(samples.velocities).all(axis=1)
        used = np.ones(len(number), bool)
        if self.source == 'measured' and self.order > 0:
            used &= measured
            refused[Reason.NO_VELOCITY] += int((own & ~used).sum())
        if self.order < (2 if self.source == 'measured' else 1):
            return self._as_measured(samples, used, own, refused)
        at = np.flatnonzero(used)
        kept = at[_long_runs(samples.stamps[at], self.max_gap)]
        refused[Reason.RUN_TOO_SHORT] += int(own[at].sum() - own[kept].sum())
        if not len(kept):
            return _GroupMotion.nothing(self.order, len(samples.columns))
        start = samples.stamps[kept[0]]
        velocities = samples.velocities[kept]
        try:
            smoothed = smooth(
                (samples.stamps[kept] - start) * 1e-9, samples.positions[kept],
                velocities if self.source != 'estimated' and np.isfinite(velocities).any()
                else None,
                continuous=[self.continuous[c] for c in samples.columns], max_gap=self.max_gap,
                max_velocity=[self.max_velocity[c] for c in samples.columns],
                joint_names=[self.joint_names[c] for c in samples.columns])
        except InvalidValueError as error:      # jumps everywhere, or one stamp for many
            late = samples.stamps[kept] <= _latest(samples.stamps, kept)[kept]
            refused[Reason.STAMP_NOT_INCREASING] += int((own[kept] & late).sum())
            refused[Reason.IMPLAUSIBLE_JUMP] += int((own[kept] & ~late).sum())
            return _GroupMotion.nothing(self.order, len(samples.columns), str(error))
        derivatives = [smoothed.position, smoothed.velocity, smoothed.acceleration,
                       smoothed.jerk]
        if self.order > 3:
            # The smoothed motion has a third derivative; the fourth is its slope.
            derivatives.append(np.gradient(smoothed.jerk, smoothed.stamps, axis=0))
        chosen = kept[smoothed.used]
        if self.source == 'measured':
            derivatives[:2] = samples.positions[chosen], samples.velocities[chosen]
        left = np.setdiff1d(kept[own[kept]], chosen)
        late = samples.stamps[left] <= _latest(samples.stamps, chosen)[left]
        refused[Reason.STAMP_NOT_INCREASING] += int(late.sum())
        refused[Reason.IMPLAUSIBLE_JUMP] += int((~late).sum())
        steps = np.diff(smoothed.stamps)
        run = np.concatenate([[0], np.cumsum((steps > self.max_gap) | (steps < 0))])
        return _GroupMotion(
            start + np.rint(smoothed.stamps * 1e9).astype(np.int64), samples.received[chosen],
            np.array(derivatives[:self.order + 1]), run, own[chosen],
            np.moveaxis(smoothed.variance, 1, 0), smoothed.findings).increasing(refused)

    def _as_measured(self, samples: GroupSamples, used: Array, own: Array,
                     refused: Counter[Reason]) -> _GroupMotion:
        at = np.flatnonzero(used)
        stamps = samples.stamps[at]
        run = np.concatenate([[0], np.cumsum(np.diff(stamps) > self.max_gap * 1e9)]
                             ) if len(at) else np.zeros(0)
        return _GroupMotion(
            stamps, samples.received[at],
            np.array([samples.positions[at], samples.velocities[at]][:self.order + 1]), run,
            own[at], np.full((4, len(at), len(samples.columns)), np.nan)).increasing(refused)


class _GroupMotion(NamedTuple):
    """Motion of joints that come together, with its context; the block's own is marked."""

    stamps: Array
    received: Array
    motion: Array
    run: Array
    own: Array
    variances: Array
    findings: tuple[str, ...] = ()

    @classmethod
    def nothing(cls, order: int, n_joints: int, *why: str) -> _GroupMotion:
        """Return the motion at no instant."""
        none = np.zeros(0, dtype=np.int64)
        return cls(none, none, np.zeros((order + 1, 0, n_joints)), none, none > 0,
                   np.zeros((4, 0, n_joints)), why)

    def increasing(self, refused: Counter[Reason]) -> _GroupMotion:
        """Return the motion without instants that do not follow those before."""
        before = np.concatenate([[-2**62], np.maximum.accumulate(self.stamps)[:-1]])
        good = self.stamps > before[:len(self.stamps)]
        refused[Reason.STAMP_NOT_INCREASING] += int((self.own & ~good).sum())
        return self if good.all() else _GroupMotion(
            self.stamps[good], self.received[good], self.motion[:, good], self.run[good],
            self.own[good], self.variances[:, good], self.findings)

    def at(self, instants: Array) -> tuple[Array, Array]:
        """Return at which instants the motion is known, and what it is there."""
        orders, count, n = self.motion.shape
        if count < NODES:
            return np.zeros(len(instants), bool), np.zeros((orders, len(instants), n))
        inside = np.clip(instants, self.stamps[0], self.stamps[-1])
        flat = np.moveaxis(self.motion, 0, 1).reshape(count, -1)
        between = interpolate(self.stamps, flat, inside).reshape(len(instants), orders, n)
        # Nothing is known between two runs.
        last = np.clip(np.searchsorted(self.stamps, inside, side='right') + 1,
                       NODES - 1, count - 1)
        known = (inside == instants) & (self.run[last] == self.run[last - NODES + 1])
        return known, np.moveaxis(between, 0, 1)


def _median_step(stamps: Array) -> float:
    """Return the median time between two samples [s]; 0 if there are no two."""
    return float(np.median(np.diff(stamps))) * 1e-9 if len(stamps) > 1 else 0.0


def _long_runs(stamps: Array, max_gap: float) -> Array:
    """Return which samples are of runs that are long enough, between pauses."""
    runs = np.cumsum(np.concatenate([[0], np.abs(np.diff(stamps)) > max_gap * 1e9]))
    return (np.bincount(runs)[runs] >= LEAST) if len(stamps) else np.zeros(0, bool)


def _latest(stamps: Array, chosen: Array) -> Array:
    """Return for each sample the latest stamp among the chosen ones before it."""
    latest: Array = np.full(len(stamps), -2**62)
    latest[chosen] = stamps[chosen]
    latest = np.maximum.accumulate(latest)
    return np.concatenate([[-2**62], latest[:-1]])
