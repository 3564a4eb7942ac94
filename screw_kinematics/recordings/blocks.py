# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Recorded joint samples cut into blocks, each of which is smoothed by itself.

A block holds some thousand samples of its own and, on both sides, the context that smoothing
them needs. Where blocks are cut depends on the samples alone, so the results are the same to
the bit whoever smooths which of them.
"""
from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from .recording import Sample
from ..errors import MalformedMessageError, Reason
from ..messages.joint_state import JointSample
from ..pipeline.account import Account
from ..pipeline.joint_groups import JointGroup, JointGroups
from ..screws.se3 import Array

BLOCK = 20_000
"""Samples of its own that a block has, of the joints that come most often."""

CONTEXT = 1.0
"""How far a block reaches into its neighbours [s]; smoothed values depend on less."""

LEAST_CONTEXT = 32
"""How far at least [samples], for joints that come seldom."""

_JUMP_BACK = 500_000_000    # as the node's estimators: further back is a new beginning [ns]


class GroupSamples(NamedTuple):
    """Samples of joints that come together, in one block."""

    columns: tuple[int, ...]    # which joints of the robot they are
    stamps: Array               # (N,) [ns]
    received: Array             # (N,), when they came [ns]
    positions: Array            # (N, n)
    velocities: Array           # (N, n), NaN where there is none
    begin: int                  # from here to end they are the block's own, the others its context
    end: int


Block = tuple[GroupSamples, ...]


@dataclass
class _Pending:
    """Samples of a group that wait to be cut; the first ones are context, cut before."""

    group: JointGroup
    numbers: list[int] = field(default_factory=list)
    stamps: list[int] = field(default_factory=list)
    received: list[int] = field(default_factory=list)
    positions: list[tuple[float, ...]] = field(default_factory=list)
    velocities: list[tuple[float, ...]] = field(default_factory=list)
    begin: int = 0

    def context(self) -> int:
        """Return how many samples cover the context, at the pace of the latest ones."""
        steps = np.diff(np.array(self.stamps[-1000:], dtype=np.int64))
        period = float(np.median(steps[steps > 0])) * 1e-9 if (steps > 0).any() else CONTEXT
        return min(max(int(CONTEXT / period), LEAST_CONTEXT), BLOCK)

    def cut(self, end: int) -> GroupSamples:
        """Return a block that ends before a sample."""
        return GroupSamples(
            self.group.columns, np.array(self.stamps, dtype=np.int64),
            np.array(self.received, dtype=np.int64), np.array(self.positions, dtype=float),
            np.array(self.velocities, dtype=float), self.begin, end)

    def forget(self, end: int, context: int) -> None:
        """Keep what the next block needs beside its own samples."""
        keep = max(end - context, 0)
        for samples in (self.numbers, self.stamps, self.received, self.positions,
                        self.velocities):
            del samples[:keep]    # type: ignore[attr-defined]
        self.begin = end - keep


def cut(samples: Iterable[Sample], groups: JointGroups, account: Account) -> Iterator[Block]:
    """Yield the blocks of one robot; the account counts the samples, and why some are not used."""
    pending: dict[JointGroup, _Pending] = {}
    for number, (_, received, sample) in enumerate(samples):
        account.received += 1
        read = _read(groups, sample)
        if isinstance(read, Reason):
            account.refused[read] += 1
            if read not in account.details:
                account.details[read] = (str(sample) if isinstance(sample, MalformedMessageError)
                                         else groups.describe(sample, read))
            continue
        group, stamp, position, velocity = read
        own = pending.get(group)
        stamp = stamp or received
        if own is None or own.stamps and stamp < own.stamps[-1] - _JUMP_BACK:
            # Joints that come otherwise from now on, or a clock that was set back: nothing
            # before belongs to what follows.
            if own is not None or pending.keys() - set(groups.groups):
                yield _all(pending)
                pending.clear()
            own = pending[group] = _Pending(group)
        own.numbers.append(number)
        own.stamps.append(stamp)
        own.received.append(received)
        own.positions.append(position)
        own.velocities.append(velocity)
        if len(own.stamps) - own.begin >= BLOCK and len(own.stamps) % 256 == 0:
            yield from _cut(own, pending)
    if pending:
        yield _all(pending)


def _read(groups: JointGroups, sample: JointSample | MalformedMessageError,
          ) -> tuple[JointGroup, int, tuple[float, ...], tuple[float, ...]] | Reason:
    """Return the joints that a sample brings, and their stamp, positions and velocities."""
    if isinstance(sample, MalformedMessageError):
        return Reason.MALFORMED
    if sample.stamp_ns < 0:
        return Reason.STAMP_NEGATIVE
    reading = groups.read(sample)
    if isinstance(reading, Reason):
        return reading
    velocity = reading.velocity
    return reading.group, reading.stamp_ns, tuple(reading.position), (
        tuple(velocity) if velocity is not None
        else (float('nan'),) * len(reading.position))


def _cut(pace: _Pending, pending: dict[JointGroup, _Pending]) -> Iterator[Block]:
    """Yield a block if there is enough for one, with its context."""
    contexts = {group: part.context() for group, part in pending.items()}
    cuts = {group: part.numbers[-min(contexts[group], len(part.numbers))]
            for group, part in pending.items()}
    number = min(cuts.values())
    if len(pace.stamps) - pace.begin >= 2 * BLOCK:
        number = cuts[pace.group]       # without those that come no more
    if bisect_left(pace.numbers, number) - pace.begin < BLOCK:
        return
    ends = {group: bisect_left(part.numbers, number) for group, part in pending.items()}
    yield tuple(part.cut(ends[group]) for group, part in pending.items())
    for group, part in pending.items():
        part.forget(ends[group], contexts[group])


def _all(pending: dict[JointGroup, _Pending]) -> Block:
    return tuple(part.cut(len(part.stamps)) for part in pending.values())
