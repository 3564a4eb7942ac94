# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether positions are new readings, in the model's units, of joints that do not wrap."""
from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from .findings import FACT, Finding, PROBLEM, REMARK
from ...motion.units import unit_doubts
from ...screws.se3 import Array

_BEFORE = 8             # samples that tell how fast a joint moves
_STEPS = 3.0            # of the encoder that a moving joint makes from sample to sample
_HELD = 0.2             # share of repeated readings from which on they are the rule


def report_readings(label: str, names: Sequence[str], kinds: Sequence[str], time: Array,
                    position: Array) -> Iterator[Finding]:
    """Yield what is found in positions of shape (N, n) [rad, m], finite, over stamps [s]."""
    steps = np.abs(np.diff(position, axis=0))
    still = [name for name, moved in zip(names, np.ptp(position, axis=0)) if moved == 0]
    if len(still) == len(names):
        yield Finding(REMARK, f'{label}: positions do not change at all',
                      'move the robot to learn more')
        return
    quantum = np.array([column[column > 0].min() if column.any() else np.nan
                        for column in steps.T])
    yield Finding(FACT, f'{label}: smallest step of a position {np.nanmin(quantum):.2g}, '
                        f'largest {steps.max():.2g} rad or m')
    if still:
        yield Finding(REMARK, f'{label}: {", ".join(still)} did not move')
    yield from _repeats(label, time, position, quantum)
    for i, (name, kind) in enumerate(zip(names, kinds)):
        for doubt in unit_doubts(position[:, i], kind):
            yield Finding(PROBLEM, f'{label}: {name} ({kind}) {doubt.problem}', doubt.advice)


def _repeats(label: str, time: Array, position: Array, quantum: Array) -> Iterator[Finding]:
    """Yield how many readings are those of the sample before, though the robot moves."""
    before = np.abs(position[_BEFORE:] - position[:-_BEFORE]) / _BEFORE
    moving = (before > _STEPS * np.nan_to_num(quantum, nan=np.inf)).any(axis=1)
    same = np.concatenate([[False], (position[1:] == position[:-1]).all(axis=1), [False]])
    begins = np.flatnonzero(same[1:] & ~same[:-1]) + 1      # of stretches that repeat a reading
    ends = np.flatnonzero(~same[1:] & same[:-1]) + 1        # the first new reading behind each
    held_for: list[int] = []
    for begin, end in zip(begins.tolist(), ends.tolist()):
        at = begin - 1 - _BEFORE
        if at < 0 or end >= len(position) or not moving[at]:
            continue
        # What moves on makes up for the time that it was held; what stopped does not.
        joint = int(np.argmax(before[at] / np.nan_to_num(quantum, nan=np.inf)))
        held = end - begin
        if abs(position[end, joint] - position[begin, joint]) > (1 + held / 2) * before[at, joint]:
            held_for.append(held)
    if not held_for:
        return
    count, longest = sum(held_for), max(held_for)
    steps = np.diff(time)
    period = float(np.median(steps[steps > 0]))
    lasting = f'; the longest for {1e3 * longest * period:.0f} ms' if longest > 1 else ''
    if count > _HELD * moving.sum():
        changes = 1 / (period * (1 + float(np.median(held_for))))
        yield Finding(
            REMARK, f'{label}: positions change {changes:.1f} times a second only, though '
            f'messages come {1 / period:.1f} times{lasting}',
            'readings are held: let the driver send each once, when it is read; until then the '
            'estimator needs a delay, see below')
    else:
        yield Finding(
            REMARK, f'{label}: {count} positions repeat the one before while the robot moves'
            f'{lasting}', 'a reading that is sent twice with a fresh stamp: let the driver send '
            'each once; until then a delay lets the estimator tell, see below')
