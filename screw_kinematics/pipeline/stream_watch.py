# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Faults of a stream of joint states that no single message shows, looked for now and then."""
from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import dist, pi

import numpy as np

from .joint_groups import listed, Reading
from ..motion.units import TURNS_ON, unit_doubts, UnitDoubt, WRAP

EVERY = 17
"""Three readings in a row are looked at, of so many; a prime, so that no rhythm is missed."""

JUMP = 0.02
"""Positions that differ by less may be of one motion [rad, m]."""

BACK = 0.2
"""Share of a jump up to which a joint may miss where it came from, to have jumped back."""

HITS = 3
"""So many triples that jump there and back are two sources, not a glitch."""

ENOUGH = 20
"""So many readings tell what a velocity field holds."""

NO_VELOCITIES = "set velocity_source to 'auto', which needs none"
"""What to do where measured velocities are asked for and there are none."""

PAUSE, PERIODS = 50_000_000, 10
"""Stamps further apart than this [ns], and than so many periods, have lost what lay between."""

JUMPED = 60_000_000_000
"""Stamps further apart than this [ns] are of a clock that was set."""

FORGET = 0.99
"""Per look, so that what has stopped is no longer told."""


class StreamWatch:
    """Watches a group's readings; ``measured``: velocities are used, be they right or wrong."""

    def __init__(self, names: Sequence[str], continuous: Sequence[bool] | None = None,
                 measured: bool = False) -> None:
        self._names = names
        self._continuous = (False,) * len(names) if continuous is None else continuous
        self._measured = measured
        self._farthest = [0.0] * len(names)
        self._start: Sequence[float] | None = None
        self._resting = [0] * len(names)
        """How often each joint had moved on while its velocity was zero; -1: never again."""
        self.lost = 0
        """About how many readings never came, as far as pauses in the stamps tell."""
        self._stamp, self._period, self._pause = 0, 0, 1 << 62
        self._count = 0
        self._last: list[Sequence[float]] = []
        self._there_and_back = [0.0] * len(names)
        self._wrapped = [0] * len(names)
        """Whole turns among the steps that were looked at."""
        self._first: tuple[Sequence[float], Sequence[float]] | None = None
        self._velocities = self._as_position = self._constant = 0

    def update(self, reading: Reading) -> None:
        """Take a reading."""
        passed = reading.stamp_ns - self._stamp
        self._stamp = reading.stamp_ns
        if self._pause < passed < JUMPED:
            self.lost += round(passed / self._period) - 1
        self._count += 1
        if self._count > EVERY - 3:
            if self._count == EVERY and 0 < passed < JUMPED:
                # The mean, as some come in bursts.
                self._period = passed if not self._period else max(
                    1, self._period + (min(passed, 3 * self._period) - self._period) // 16)
                self._pause = max(PAUSE, PERIODS * self._period)
            self._last.append(reading.position)
            if self._count == EVERY:
                self._look(reading)
                self._count = 0
                self._last.clear()

    def findings(self, publishers: int) -> list[str]:
        """Return what is wrong, in sentences, of a topic with so many publishers."""
        findings = []
        jumping = [name for name, hits in zip(self._names, self._there_and_back) if hits > HITS]
        if jumping and publishers > 1:
            findings.append(f'{publishers} publishers disagree on joints {listed(jumping)}: '
                            'one of them is to be stopped')
        elif jumping:
            findings.append(f'positions of joints {listed(jumping)} jump there and back')
        for name, farthest, turns_on in zip(self._names, self._farthest, self._continuous):
            for doubt in _doubts(farthest, turns_on):
                findings.append(f'{name} {doubt.problem}: {doubt.advice}')
        findings += [f'{name} jumps by whole turns: {TURNS_ON}' for name, wrapped in zip(
            self._names, self._wrapped) if wrapped > 1]
        idle = [name for name, count in zip(self._names, self._resting) if count >= ENOUGH]
        if idle and self._measured:
            findings.append(f"velocity_source is 'measured', but the velocities of joints "
                            f'{listed(idle)} are zero while they move: {NO_VELOCITIES}')
        if self._velocities >= ENOUGH:
            if self._as_position > 0.95 * self._velocities:
                findings.append('the velocity field holds the positions')
            elif self._constant > 0.95 * self._velocities:
                findings.append('the velocity field never changes while the joints move: '
                                'a commanded maximum?')
        return findings

    def _look(self, reading: Reading) -> None:
        hits = self._there_and_back
        for k, (a, b, c) in enumerate(zip(*self._last)):
            hits[k] *= FORGET
            if abs(b - c) > JUMP and abs(a - c) < BACK * abs(b - c):
                hits[k] += 1.0
            elif not self._continuous[k] and (abs(abs(b - c) - 2 * pi) < WRAP
                                              or abs(abs(a - b) - 2 * pi) < WRAP):
                self._wrapped[k] += 1
        position, velocity = reading.position, reading.velocity
        self._farthest = [y if abs(y) > abs(x) else x
                          for x, y in zip(self._farthest, position)]
        if velocity is None:
            return
        if self._measured:
            self._look_for_idle(position, velocity)
        if not any(velocity):
            return
        if self._first is None:
            self._first = position, velocity
            return
        first, constant = self._first
        if dist(position, first) > JUMP:        # the joints have moved
            self._velocities += 1
            self._as_position += list(velocity) == list(position)
            self._constant += list(velocity) == list(constant)

    def _look_for_idle(self, position: Sequence[float], velocity: Sequence[float]) -> None:
        if self._start is None:
            self._start = position
        for k, (now, start, v) in enumerate(zip(position, self._start, velocity)):
            if v != 0.0:
                self._resting[k] = -1
            elif self._resting[k] >= 0 and abs(now - start) > JUMP:
                self._resting[k] += 1


@lru_cache(maxsize=1000)
def _doubts(farthest: float, turns_on: bool) -> list[UnitDoubt]:
    """Return what a farthest position says against its unit: often asked, seldom another."""
    return unit_doubts(np.array([farthest]), 'continuous' if turns_on else '')
