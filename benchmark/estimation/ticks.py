# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
When recorded readings were taken: the ticks of the device, found with both sides in view.

Independent of the package's own clock, so that it may judge it: the most likely sequence of
ticks (Viterbi) by the steps of all positions over velocities, and by the stamps.
"""

from __future__ import annotations

import numpy as np

from screw_kinematics.motion.divided_differences import roughness

PERIODS = (0.008, 0.004, 0.002, 0.001, 0.0005)
"""Of devices, s, from the coarsest; those of real ones are such."""

SMOOTHER = 0.6
"""Share of the roughness that must be left for readings to be of ticks, not of the stamps."""

ALIKE = 1.25
"""A coarser period is taken unless a finer one is smoother by more than this."""

LOST = 0.05
"""Share of new readings that may share a tick with the one before."""

PASSES = 2
"""Searches; the second knows speeds and noise better."""

SPAN = 4
"""Ticks by which a reading may be off those of its stamp."""

BEAT = 0.005
"""What the squared deviation of a stamp counts within a period."""

STAMP_ERROR, SCALE_ERROR = 5e-4, 0.03
"""Standard deviation of stamps, s; share of a step by which velocities may be wrong."""


def reading_times(stamps: np.ndarray, positions: np.ndarray,
                  ) -> tuple[np.ndarray, np.ndarray, float]:
    """
    Return when readings were taken, on the stamps' clock, which are new ones, and the period, s.

    Stamps increase, shape (N,); positions are of shape (N, n). The time of a held reading is that
    of the reading; the device's period is 0.0 where the stamps are the readings' own.
    """
    step = float(np.median(np.diff(stamps)))
    everything = np.ones(len(stamps), bool)
    changed = np.append(True, (np.diff(positions, axis=0) != 0).any(axis=1))
    by_stamps = _rough(stamps, everything, positions)
    found: list[tuple[float, np.ndarray, np.ndarray, float]] = []
    for period in [p for p in PERIODS if p < 10 * step]:
        times: np.ndarray = stamps
        fresh: np.ndarray = everything
        for _ in range(PASSES):
            ticks, line = _search(stamps, positions, period, times, fresh)
            fresh = np.append(True, np.diff(ticks) > 0)
            times = np.polyval(line, ticks)
        if (changed & ~fresh).mean() > LOST:
            continue
        found.append((_rough(times, fresh, positions), times, fresh, period))
    smoothest = min(found, key=lambda each: each[0], default=None)
    if smoothest is None or smoothest[0] > SMOOTHER * by_stamps:
        return stamps, everything, 0.0
    _, times, fresh, period = next(
        each for each in found if each[0] <= ALIKE * smoothest[0])
    return times, fresh, period


def _rough(times: np.ndarray, fresh: np.ndarray, positions: np.ndarray) -> float:
    """Return the geometric mean of what fourth differences leave of joints that move."""
    moving = np.ptp(positions, axis=0) > 0.02
    left = roughness(times[fresh], positions[fresh][:, moving])
    return float(np.exp(np.mean(np.log(np.maximum(left, 1e-12))))) if len(left) else 0.0


def _search(stamps: np.ndarray, positions: np.ndarray, period: float, times: np.ndarray,
            fresh: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the likeliest ticks, not decreasing, and the line of the stamps over them.

    Speeds and noise are those of the readings at the times that are known so far.
    """
    near = np.rint((stamps - stamps[0]) / period)
    line = np.array([period, stamps[0]])
    for _ in range(3):
        line = np.polyfit(near, stamps, 1)
        near = np.rint((stamps - line[1]) / line[0])
    # Velocities that do not know the ticks: slopes of lines through some readings around each.
    velocity = _slopes(times, positions)
    mean = (velocity[1:] + velocity[:-1]) / 2 * line[0]
    steps = np.diff(positions, axis=0)
    noise = np.maximum(roughness(times[fresh], positions[fresh]), 1e-7)
    weight = 1 / noise**2
    own, both = (mean * mean * weight).sum(axis=1), (mean * steps * weight).sum(axis=1)
    expected = np.maximum(both / np.maximum(own, 1e-12), 1.0)
    softened = 0.5 / (1 + SCALE_ERROR**2 * own * expected**2)
    offsets = np.arange(-SPAN, SPAN + 1)
    ticks = near[:, None] + offsets
    # Two clocks that beat are apart by up to a period, for long: little of that is evidence.
    apart = np.abs(stamps[:, None] - np.polyval(line, ticks)) / STAMP_ERROR
    late = np.maximum(apart - period / STAMP_ERROR, 0.0)**2 / 2 + BEAT * apart**2
    # What a step costs depends on how many ticks passed alone: none is taken before the other.
    passed = np.diff(near)[:, None] + np.arange(-2 * SPAN, 2 * SPAN + 1)
    costs = np.where(passed < 0, np.inf, softened[:, None] * passed * (
        own[:, None] * passed - 2 * both[:, None]))
    pairs = offsets[:, None] - offsets + 2 * SPAN
    cost, rows = late[0], np.arange(len(offsets))
    back = np.zeros(ticks.shape, int)
    for k in range(1, len(stamps)):
        total = cost + costs[k - 1, pairs]
        back[k] = total.argmin(axis=1)
        cost = total[rows, back[k]] + late[k]
        cost -= cost.min()
    way = np.empty(len(stamps), int)
    way[-1] = cost.argmin()
    for k in range(len(stamps) - 1, 0, -1):
        way[k - 1] = back[k, way[k]]
    chosen = ticks[np.arange(len(stamps)), way]
    new = np.append(True, np.diff(chosen) > 0)
    return chosen, np.polyfit(chosen[new], stamps[new], 1)


def _slopes(times: np.ndarray, positions: np.ndarray, reach: int = 8) -> np.ndarray:
    """Return the slopes of lines through the readings around each."""
    def windowed(values: np.ndarray) -> np.ndarray:
        total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)])
        return total[last] - total[first]       # type: ignore[no-any-return]
    index = np.arange(len(times))
    first, last = np.maximum(index - reach, 0), np.minimum(index + reach + 1, len(times))
    count = (last - first)[:, None]
    t, q = (times - times.mean())[:, None], positions - positions.mean(axis=0)
    st, sq = windowed(t), windowed(q)
    spread = np.maximum(windowed(t * t) - st * st / count, 1e-12)
    return (windowed(t * q) - st * sq / count) / spread    # type: ignore[no-any-return]
