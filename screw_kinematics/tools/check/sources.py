# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether the messages of one topic come from one source, and what a velocity field holds."""
from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np

from .findings import Finding, PROBLEM, REMARK
from ...pipeline.joint_groups import listed
from ...pipeline.stream_watch import BACK, JUMP
from ...recordings.joint_streams import JointStream
from ...screws.se3 import Array

_HITS = 5           # jumps there and back that are no glitches
_SHARE = 0.005      # of the samples, at least
_NOISE = 0.25       # each of two sources moves on; of one, however parted, more jumps are left
_FIELD = 0.95       # share of the samples that tells what the velocities are
_SPEED = 1e-3       # joints that move faster are in motion [rad/s, m/s]
_STOP = ('stop one of the publishers, or let it publish elsewhere; ros2 topic info -v {} names '
         'them')


def report_sources(topic: str, label: str, names: Sequence[str], received: Array,
                   position: Array) -> Iterator[Finding]:
    """
    Yield whether two sources take turns in messages with the same names, and what each says.

    When the messages came is in ns; positions are of shape (N, n) [rad, m], finite.
    """
    jumps = _jumps(position)
    jumping = jumps > max(_HITS, _SHARE * len(position))
    if not jumping.any():
        return
    joints = listed(n for n, often in zip(names, jumping) if often)
    second = _second_source(position[:, jumping])
    left = _jumps(position[second]) + _jumps(position[~second])
    if left[jumping].sum() > _NOISE * jumps[jumping].sum():
        yield Finding(REMARK, f'{label}: positions of joints {joints} jump there and back from '
                      'sample to sample, of one noisy source',
                      'such as motion capture, or a wrong unit; what can be had of it is below')
        return
    parts = [f'one {_described(names, received[part], position[part])}'
             for part in (~second, second)]
    yield Finding(
        PROBLEM, f'{label}: two publishers disagree on joints {joints}: {", ".join(parts)}',
        _STOP.format(topic))


def _jumps(position: Array) -> Array:
    """Return how often each joint jumps there and back."""
    before, between, after = position[:-2], position[1:-1], position[2:]
    away = np.abs(between - after)
    count: Array = ((away > JUMP) & (np.abs(before - after) < BACK * away)).sum(axis=0)
    return count


def report_overlaps(topic: str, streams: Sequence[JointStream], wanted: Mapping[str, str],
                    ) -> Iterator[Finding]:
    """Yield whether messages with other names bring the same joints, and if they agree on them."""
    for one, other in combinations([s for s in streams if len(s) > _HITS], 2):
        both = [name for name in one.names if name in other.names and name in wanted]
        if not both:
            continue
        slow, fast = sorted((one, other), key=len)
        apart = []
        for name in both:
            values = [stream.position()[:, stream.names.index(name)] for stream in (slow, fast)]
            there = np.interp(slow.received, fast.received, values[1])
            if np.median(np.abs(values[0] - there)) > JUMP:
                apart.append(name)
        parts = ', '.join(
            f'{len(stream.names)} joints in {_described(both, np.array(stream.received), q)}'
            for stream in (fast, slow)
            for q in [stream.position()[:, [stream.names.index(name) for name in both]]])
        yield Finding(
            PROBLEM if apart else REMARK,
            f'{topic}: two publishers {"disagree on" if apart else "bring"} joints '
            f'{listed(apart or both)}: {parts}', _STOP.format(topic))


def report_velocity_field(label: str, names: Sequence[str], time: Array, position: Array,
                          velocity: Array) -> Iterator[Finding]:
    """
    Yield which joints' velocity fields hold their positions, or a constant.

    Stamps are in s; positions and velocities of shape (N, n), velocities NaN where there is none.
    """
    positions, constants = [], []
    steps = np.diff(time)
    for i, name in enumerate(names):
        with np.errstate(all='ignore'):
            speed = np.abs(np.diff(position[:, i])) / steps
        v, q = velocity[1:, i], position[1:, i]
        # At rest and near zero both may be right; where a joint moves they are not.
        moving = np.isfinite(v) & np.isfinite(speed) & (speed > _SPEED)
        if moving.sum() < 20 or np.ptp(q[moving]) < JUMP or not v[moving].any():
            continue
        if (np.abs(v - q)[moving] <= 1e-9).mean() > _FIELD:
            positions.append(name)
        elif (v[moving] == np.median(v[moving])).mean() > _FIELD and (
                speed[moving].max() > 1.5 * speed[moving].min()):
            constants.append(f'{name} ({np.median(v[moving]):g})')
    for found, what in (
            (positions, 'holds the positions'),
            (constants, 'never changes while they move: the commanded or the greatest speed?')):
        if found:
            yield Finding(PROBLEM, f'{label}: the velocity field of joints {listed(found)} {what}',
                          'set velocity_source: estimated, and let the driver fill the field '
                          'with what it measures, or leave it empty')


def _second_source(position: Array) -> Array:
    """Return which samples are of the source that speaks less often, shape (N,)."""
    rows = [tuple(row) for row in position.tolist()]
    said, count = Counter(rows).most_common(1)[0]
    same = np.array([row == said for row in rows])
    # What stays at one place all the time is told by that, wherever the other passes.
    if np.ptp(np.flatnonzero(same)) > 0.8 * len(rows) and (
            (same[1:] != same[:-1]).sum() > 0.5 * min(count, len(rows) - count)):
        return same if count <= len(rows) / 2 else ~same
    second = np.zeros(len(position), bool)
    last: list[Array | None] = [position[0], None]
    for i, row in enumerate(position[1:], start=1):
        gaps = [np.inf if one is None else float(np.abs(row - one).max()) for one in last]
        which = int(gaps[1] < gaps[0]) if last[1] is not None else int(gaps[0] > JUMP)
        second[i], last[which] = bool(which), row
    return second if second.sum() <= len(position) / 2 else ~second


def _described(names: Sequence[str], received: Array, position: Array) -> str:
    """Return how often a source speaks, and whether what it says ever changes."""
    spans = np.diff(received)
    rate = f'{1e9 / float(np.median(spans)):.0f} messages a second' if len(spans) and (
        np.median(spans) > 0) else f'{len(received)} messages'
    if np.ptp(position, axis=0).any():
        return f'{rate} of a motion'
    if not position.any():
        return f'{rate} of zeros (a forgotten joint_state_publisher?)'
    values = ', '.join(f'{name} {q:.3g}' for name, q in list(zip(names, position[0]))[:3])
    return f'{rate} that never change ({values}{", ..." if len(names) > 3 else ""})'
