# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How real drivers read, send and stamp the positions of a device; every way by its mechanism."""

from typing import NamedTuple

import numpy as np


class Messages(NamedTuple):
    """Stamps and positions of messages; when each was read, and stamped, by true time."""

    stamps: np.ndarray
    positions: np.ndarray
    read: np.ndarray
    stamped: np.ndarray


def device(motion, rate, seconds, seed, resolution=1e-5, start=0.01):
    """Return the ticks of a device and the positions it reads: a little noise, then rounding."""
    rng = np.random.default_rng(seed)
    ticks = start + np.arange(int(rate * seconds)) / rate
    exact = motion(ticks)[0]
    noisy = exact + 0.3 * resolution * rng.normal(size=exact.shape)
    return ticks, np.round(noisy / resolution) * resolution


def on_arrival(ticks, positions, rng, mean=3e-4):
    """Stamp on arrival: a fixed latency and an exponential one; messages stay in order."""
    stamped = ticks + 1e-4 + rng.exponential(mean, len(ticks))
    for k in range(1, len(stamped)):
        stamped[k] = max(stamped[k], stamped[k - 1] + 1e-5)
    return Messages(stamped, positions, ticks, stamped)


def by_reader(ticks, positions, rng, rate):
    """Let a loop with a clock of its own take and stamp the latest reading."""
    count = int((ticks[-1] - ticks[1] - 0.05) * rate)
    stamped = ticks[1] + rng.uniform(0, 1 / rate) + np.arange(count) / rate * (1 + 3e-4)
    stamped = stamped + rng.exponential(2e-5, count)
    latest = np.searchsorted(ticks, stamped, side='right') - 1
    return Messages(stamped, positions[latest], ticks[latest], stamped)


def with_clock_set(messages, by, at):
    """Let the stamps' clock be set at a time."""
    return messages._replace(stamps=messages.stamps + by * (messages.stamped > at))


def with_losses(messages, rng, share):
    """Lose messages."""
    kept = rng.random(len(messages.stamps)) > share
    kept[:3] = True
    return Messages(*(part[kept] for part in messages))


def with_stalls(messages, length, every, apart=1e-5):
    """Hold the network up from time to time: what is late then comes in order, `apart` [s]."""
    stamped = messages.stamped.copy()
    for begin in np.arange(every, stamped[-1], every):
        late = stamped > begin
        stamped[late] = np.maximum(stamped[late], begin + length + apart * np.arange(late.sum()))
    return messages._replace(stamps=stamped, stamped=stamped)


def in_bursts(messages, size):
    """Send so many messages at once, when the last of them is there."""
    last = np.minimum(np.arange(len(messages.read)) // size * size + size - 1,
                      len(messages.read) - 1)
    stamped = messages.stamped[last]
    for k in range(1, len(stamped)):
        stamped[k] = max(stamped[k], stamped[k - 1] + 1e-5)
    return messages._replace(stamps=stamped, stamped=stamped)


def in_stretches(messages, rng, runs, pauses):
    """Let runs of messages arrive, as many as `runs` from .. to, between pauses from .. to [s]."""
    kept = np.zeros(len(messages.read), dtype=bool)
    begin = 0
    while begin < len(kept):
        end = begin + rng.integers(runs[0], runs[1], endpoint=True)
        kept[begin:end] = True
        last = messages.read[min(end, len(kept)) - 1]
        begin = max(end, np.searchsorted(messages.read, last + rng.uniform(*pauses)))
    return Messages(*(part[kept] for part in messages))
