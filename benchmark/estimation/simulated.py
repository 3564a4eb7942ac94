# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Simulated recordings: a motion, measured in one way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import takewhile
import math
import zlib

from benchmark.estimation.conditions import Condition
from benchmark.estimation.motions import draw
from benchmark.estimation.samples import Samples
import numpy as np

from screw_kinematics.tools.stamping import stampings

N_JOINTS = 7
SECONDS = 4.0
NO_CLOCK = ('made_up', 'clock_set')
"""Ways of stamping by a clock that goes wrong: what they say is taken for what it was then."""

SLOW_NOISE = 5e-3
"""Amplitude of each of four sines from 3 to 30 Hz in a coherent velocity, rad/s."""

VELOCITY_NOISE = 1e-3
"""White noise of velocities that are wrong otherwise, rad/s."""

Motion = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Recording:
    """
    Samples as they arrive, the same in order with the stamps of their reading, the truth.

    `latency` is how old new readings are when they are stamped, on average, s.
    """

    arrived: Samples
    ordered: Samples
    joints: list[Motion]
    latency: float = 0.0

    def truth(self, t: np.ndarray) -> np.ndarray:
        """Return the true (4, N, n) at times t."""
        return np.stack([joint(t) for joint in self.joints], axis=-1)

    def stops(self) -> list[tuple[int, float, float]]:
        """Return joint, end and deceleration of each sudden stop."""
        return [(j, end, deceleration) for j, joint in enumerate(self.joints)
                for end, deceleration in getattr(joint, 'stops', ())]


@dataclass(frozen=True)
class Smaller:
    """A motion with a share of its amplitude about where it begins."""

    motion: Motion
    share: float

    def __call__(self, t: np.ndarray) -> np.ndarray:
        start = np.zeros((4, 1))
        start[0] = self.motion(np.zeros(1))[0]
        return start + self.share * (self.motion(t) - start)


def record(kind: str, condition: Condition, seed: int) -> Recording:
    """Measure seven joints that move in one kind of way."""
    motion_seed = zlib.crc32(kind.encode())
    rng = np.random.default_rng([motion_seed, seed])
    joints: list[Motion] = [draw(kind, rng, SECONDS) for _ in range(N_JOINTS)]
    if condition.amplitude != 1.0:
        joints = [Smaller(joint, condition.amplitude) for joint in joints]
    rng = np.random.default_rng([motion_seed, seed, zlib.crc32(repr(condition).encode())])
    faults = np.random.default_rng([motion_seed, seed, 13])
    if condition.stamps:
        return _stamped_by_driver(condition, joints, seed, rng, faults)
    count, period = int(SECONDS * condition.rate), 1 / condition.rate
    wobble = rng.uniform(-0.5, 0.5, count) * condition.jitter
    t = 0.01 + (np.arange(count) + wobble) * period
    stamps = t + rng.normal(0, 1, count) * condition.stamp_error
    taken = stamps
    if condition.burst > 1:
        place = np.arange(count) % condition.burst
        last = np.minimum(np.arange(count) - place + condition.burst, count) - 1
        stamps = stamps[last] + 20e-6 * place
    for k in range(1, count):
        stamps[k] = max(stamps[k], stamps[k - 1] + 1e-6)
    q = _positions(condition, joints, t, rng, faults)
    v = _velocities(condition, stamps, q, np.stack(
        [joint(t - condition.lag)[1] for joint in joints], axis=-1), rng)
    order: np.ndarray = np.arange(count)
    if condition.faults:
        order = order[(rng.random(count) > 0.03) | (order < 5)]
    ordered = _samples(taken, q, v, order)
    if condition.faults:
        order = np.sort(np.concatenate([order, order[rng.random(len(order)) < 0.01]]))
        k = 3
        while k < len(order) - 1:
            if rng.random() < 0.01:
                order[k], order[k + 1] = order[k + 1], order[k]
                k += 1
            k += 1
    latency = float((stamps - taken).mean()) if condition.burst > 1 else 0.0
    return Recording(_samples(stamps, q, v, order), ordered, joints, latency)


def _samples(stamps: np.ndarray, q: np.ndarray, v: np.ndarray | None,
             rows: np.ndarray) -> Samples:
    return Samples(stamps[rows], q[rows], None if v is None else v[rows], np.zeros(len(rows)))


def _stamped_by_driver(condition: Condition, joints: list[Motion], seed: int,
                       rng: np.random.Generator, faults: np.random.Generator) -> Recording:
    """Measure as a driver that stamps in a way of its own."""
    messages = np.array(list(takewhile(
        lambda message: message.sent < SECONDS,
        stampings(condition.stamps, condition.rate, 0.02, seed))))
    readings, stamps, sent = messages.T
    t, which = np.unique(readings, return_inverse=True)
    q = _positions(condition, joints, t, rng, faults)
    # How old readings are on average nobody can know: that part of it is not an error.
    fresh = np.append(True, np.diff(readings) > 0)
    latency = float((sent - readings)[fresh].mean())
    ahead = np.full(len(stamps), latency)
    if condition.stamps in NO_CLOCK:
        ahead += stamps - sent
    return Recording(Samples(stamps, q[which], None, ahead),
                     Samples(t, q, None, np.zeros(len(t))), joints, latency)


def _positions(condition: Condition, joints: list[Motion], t: np.ndarray,
               rng: np.random.Generator, faults: np.random.Generator) -> np.ndarray:
    """Return what the encoders read."""
    q, v = np.stack([joint(t)[:2] for joint in joints], axis=-1)
    angle = q
    for per_turn, size in condition.ripple:
        q = q + size * np.sin(per_turn * angle + faults.uniform(0, 2 * np.pi, q.shape[1]))
    if condition.speed_noise:
        q = q + condition.speed_noise * np.abs(v) * faults.normal(size=q.shape)
    if condition.resolution:
        noisy = q + condition.dither * condition.resolution * rng.normal(size=q.shape)
        q = np.round(noisy / condition.resolution) * condition.resolution
    if condition.glitch:
        places = np.arange(len(t) // 10, len(t) - 10, 5)
        for j in range(q.shape[1]):
            for k in np.sort(faults.choice(places, 20, replace=False)):
                odd = slice(k, k + condition.together)
                q[odd, j] = q[k - 1, j] if condition.glitch == 'repeated' else (
                    q[odd, j] + faults.choice([-1.0, 1.0]) * condition.glitch)
    return q


def _velocities(condition: Condition, stamps: np.ndarray, q: np.ndarray,
                true_velocity: np.ndarray, rng: np.random.Generator) -> np.ndarray | None:
    way = condition.velocity
    if way is None:
        return None
    if way == 'zero':
        return np.zeros_like(q)
    if isinstance(way, float):
        return true_velocity + rng.normal(0, way, q.shape)
    v = np.zeros_like(q)
    if way in ('differenced', 'filtered'):
        v[1:] = np.diff(q, axis=0) / np.diff(stamps)[:, None]
    else:
        v = true_velocity * (1.02 if way == 'scaled' else 1.0) + rng.normal(
            0, VELOCITY_NOISE, q.shape)
    if way == 'coherent':
        for k, frequencies in enumerate(rng.uniform(3.0, 30.0, (4, q.shape[1]))):
            v = v + SLOW_NOISE * np.sin(2 * np.pi * frequencies * stamps[:, None] + k)
    if way in ('filtered', 'low-passed'):
        gain = 1 - math.exp(-2 * math.pi * 30 / condition.rate)
        for k in range(1, len(v)):
            v[k] = v[k - 1] + gain * (v[k] - v[k - 1])
    return v
