# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How joints are measured: rate, resolution, stamps, velocity field, message faults."""

from __future__ import annotations

from dataclasses import dataclass, field
import math
import zlib

from benchmark.estimation.motions import draw
import numpy as np

N_JOINTS = 7
SECONDS = 4.0


@dataclass(frozen=True)
class Condition:
    """
    One way of measuring.

    Attributes
    ----------
    rate: Hz
    resolution: of the encoder, rad; noise of 0.3 of it is added before rounding
    stamp_error: standard deviation of the stamp, s
    velocity: standard deviation of a measured velocity, rad/s; or 'zero' (filled with zeros),
        'differenced' (from the positions), 'filtered' (that, low-passed at 30 Hz); None: absent
    lag: of the velocity, s
    faults: 3 % of messages dropped, 1 % doubled, 1 % swapped
    jitter: of the sampling instants, as a share of the period; the stamp knows it
    burst: samples that arrive, and are stamped, together: 20 us apart, when the last is taken
    latency: mean of an exponential one, s; messages are stamped on arrival, in order
    reader: a loop of this rate, Hz, with a clock of its own, takes and stamps the latest reading
    stall: of the network, s, every 0.8 s; what is held up arrives, and is stamped, at once

    Of latencies only the part that varies is in the stamps: nobody can know a constant one.

    """

    rate: float
    resolution: float = 1e-5
    stamp_error: float = 20e-6
    velocity: float | str | None = None
    lag: float = 0.0
    faults: bool = False
    jitter: float = 0.1
    burst: int = field(default=1, repr=False)     # noise is seeded by the rest
    latency: float = field(default=0.0, repr=False)
    reader: float = field(default=0.0, repr=False)
    stall: float = field(default=0.0, repr=False)


CONDITIONS = {
    '100 Hz': Condition(100),
    '100 Hz, velocity': Condition(100, 1e-4, velocity=5e-3),
    '250 Hz, network': Condition(250, stamp_error=100e-6, faults=True),
    '500 Hz, velocity': Condition(500, velocity=5e-3),
    '500 Hz, coarse': Condition(500, 1e-4),
    '1 kHz': Condition(1000, 1e-6),
    '1 kHz, velocity': Condition(1000, 1e-4, velocity=5e-3),
    '1 kHz, simulator': Condition(1000, 0.0, 0.0, 1e-9),
    '250 Hz, late velocity': Condition(250, 1e-6, velocity=1e-3, lag=5e-3, faults=True),
    '500 Hz, zero velocity': Condition(500, velocity='zero'),
    '100 Hz, hobby servo': Condition(100, 1.5e-3, 200e-6),
    '500 Hz, differenced velocity': Condition(500, 1e-4, velocity='differenced'),
    '500 Hz, filtered velocity': Condition(500, 1e-4, velocity='filtered'),
    '250 Hz, stamped on arrival': Condition(250, 1e-6, 200e-6, faults=True, jitter=0.0),
    '500 Hz, bursts of five': Condition(500, 1e-5, 50e-6, jitter=0.0, burst=5),
}


STAMPING = {
    '500 Hz, late arrival': Condition(500, stamp_error=0.0, jitter=0.0, latency=1e-3),
    '1 kHz, another clock reads': Condition(1000, stamp_error=0.0, jitter=0.0, reader=1000),
    '500 Hz, read at 93 Hz': Condition(500, stamp_error=0.0, jitter=0.0, reader=93),
    '500 Hz, held at 1 kHz': Condition(500, stamp_error=0.0, jitter=0.0, reader=1000),
    '500 Hz, stalls': Condition(500, stamp_error=0.0, jitter=0.0, latency=1e-4, stall=0.025),
}
"""Ways of stamping that tell little of when a joint was read."""


@dataclass(frozen=True)
class Recording:
    """Samples as they arrive, the same in order (and not in bursts), and the truth."""

    stamps: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray | None
    ordered: tuple
    joints: list

    def truth(self, t: np.ndarray) -> np.ndarray:
        """Return the true (4, N, n) at times t."""
        return np.stack([joint(t) for joint in self.joints], axis=-1)


def record(kind: str, condition: Condition, seed: int) -> Recording:
    """Measure seven joints that move in one kind of way."""
    motion_seed = zlib.crc32(kind.encode())
    rng = np.random.default_rng([motion_seed, seed])
    joints = [draw(kind, rng, SECONDS) for _ in range(N_JOINTS)]
    rng = np.random.default_rng([motion_seed, seed, zlib.crc32(repr(condition).encode())])
    count, period = int(SECONDS * condition.rate), 1 / condition.rate
    wobble = rng.uniform(-0.5, 0.5, count) * condition.jitter
    t = 0.01 + (np.arange(count) + wobble) * period
    stamps = t + rng.normal(0, 1, count) * condition.stamp_error
    taken = stamps
    if condition.burst > 1:
        place = np.arange(count) % condition.burst
        last = np.minimum(np.arange(count) - place + condition.burst, count) - 1
        stamps = stamps[last] + 20e-6 * place
    if condition.latency:
        stamps = stamps + rng.exponential(condition.latency, count)
        for begin in np.arange(0.9, SECONDS, 0.8) if condition.stall else ():
            late = (stamps > begin) & (stamps < begin + condition.stall)
            stamps[late] = begin + condition.stall
        stamps = np.maximum.accumulate(stamps) - condition.latency
    for k in range(1, count):
        stamps[k] = max(stamps[k], stamps[k - 1] + 1e-6)
    truth = np.stack([joint(t) for joint in joints], axis=-1)
    q = truth[0]
    if condition.resolution:
        noisy = q + 0.3 * condition.resolution * rng.normal(size=q.shape)
        q = np.round(noisy / condition.resolution) * condition.resolution
    v = _velocity(condition, stamps, q, np.stack(
        [joint(t - condition.lag)[1] for joint in joints], axis=-1), rng)
    order = np.arange(count)
    if condition.reader:
        read = t[1] + np.arange(int((t[-1] - t[1] - 0.05) * condition.reader)) / (
            condition.reader * (1 + 3e-4))
        order = np.searchsorted(t, read, side='right') - 1
        fresh = np.append(True, np.diff(order) > 0)
        return Recording(read - (read - t[order])[fresh].mean(), q[order], None,
                         (t[order[fresh]], q[order[fresh]], None), joints)
    if condition.faults:
        order = order[(rng.random(count) > 0.03) | (order < 5)]
    ordered = (taken[order], q[order], None if v is None else v[order])
    if condition.faults:
        order = np.sort(np.concatenate([order, order[rng.random(len(order)) < 0.01]]))
        k = 3
        while k < len(order) - 1:
            if rng.random() < 0.01:
                order[k], order[k + 1] = order[k + 1], order[k]
                k += 1
            k += 1
    return Recording(
        stamps[order], q[order], None if v is None else v[order], ordered, joints)


def _velocity(condition: Condition, stamps: np.ndarray, q: np.ndarray, true_velocity: np.ndarray,
              rng: np.random.Generator) -> np.ndarray | None:
    if condition.velocity is None:
        return None
    if condition.velocity == 'zero':
        return np.zeros_like(q)
    if isinstance(condition.velocity, float):
        return true_velocity + rng.normal(0, condition.velocity, q.shape)
    v = np.zeros_like(q)
    v[1:] = np.diff(q, axis=0) / np.diff(stamps)[:, None]
    if condition.velocity == 'filtered':
        gain = 1 - math.exp(-2 * math.pi * 30 / condition.rate)
        for k in range(1, len(v)):
            v[k] = v[k - 1] + gain * (v[k] - v[k - 1])
    return v
