# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Ways in which drivers stamp their readings: when a joint was read, and what the message says.

A device reads its encoders at regular ticks. What reaches ROS depends on who stamps, and
when: the device itself, the loop that takes the latest reading, or whoever receives it.
"""
from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import count
from typing import NamedTuple

import numpy as np

from ..errors import ParameterError

Random = np.random.Generator


class Stamping(NamedTuple):
    """Times of one message, since the beginning of the motion [s]."""

    reading: float    # when the joints were where the message says
    stamp: float      # what the message says that was
    sent: float       # when the message comes


def stampings(way: str, rate: float, begin: float = 0.0, seed: int = 0) -> Iterator[Stamping]:
    """
    Yield the messages of a driver, without end, in the order in which they come.

    Examples
    --------
    >>> next(stampings('exact', 100.0, begin=0.5))
    Stamping(reading=0.5, stamp=0.5, sent=0.5)

    """
    if way not in WAYS:
        raise ParameterError('stamps', way, ', '.join(WAYS))
    return WAYS[way](rate, begin, np.random.default_rng(seed))


def _exact(rate: float, begin: float, _: Random) -> Iterator[Stamping]:
    """Each reading has the stamp of its tick."""
    for tick in count(round(begin * rate)):
        yield Stamping(tick / rate, tick / rate, tick / rate)


def _arrival(rate: float, begin: float, rng: Random, mean: float = 3e-4) -> Iterator[Stamping]:
    """Stamped by who receives it, some tenths of a millisecond later."""
    sent = -np.inf
    for reading, *_ in _exact(rate, begin, rng):
        sent = max(reading + 1e-4 + rng.exponential(mean), sent + 1e-5)     # in order
        yield Stamping(reading, sent, sent)


def _reader(rate: float, begin: float, rng: Random, device: float = 1000.0,
            ) -> Iterator[Stamping]:
    """Let a loop take the latest reading of a 1 kHz device and stamp it by its own clock."""
    period = (1 + 3e-4) / rate      # no two clocks run alike
    for tick in count(round(begin / period)):
        taken = tick * period + rng.exponential(2e-5)
        yield Stamping(np.floor(taken * device) / device, taken, taken)


def _held(rate: float, begin: float, rng: Random) -> Iterator[Stamping]:
    """As reader, of a device that is four times slower than the loop: readings repeat."""
    return _reader(rate, begin, rng, device=rate / 4)


def _rounded(rate: float, begin: float, rng: Random) -> Iterator[Stamping]:
    """Right, but in whole milliseconds; the sampling wobbles by a tenth of its period."""
    for reading, *_ in _exact(rate, begin, rng):
        reading += rng.uniform(-0.1, 0.1) / rate
        yield Stamping(reading, round(reading, 3), reading)


def _made_up(rate: float, begin: float, rng: Random) -> Iterator[Stamping]:
    """Count stamps up by the nominal period, in a loop that sleeps a little longer."""
    reading = begin
    for tick in count(round(begin * rate)):
        reading += (1 + rng.uniform(0, 0.02)) / rate + abs(rng.normal(0, 5e-5))
        yield Stamping(reading, tick / rate, reading)


def _bursts(rate: float, begin: float, rng: Random) -> Iterator[Stamping]:
    """Four messages come at once, stamped when they do."""
    messages = _arrival(rate, begin, rng)
    while True:
        together = [next(messages) for _ in range(4)]
        last = together[-1].sent
        for k, message in enumerate(together):
            yield Stamping(message.reading, last + 1e-5 * k, last + 1e-5 * k)


def _lost(rate: float, begin: float, rng: Random) -> Iterator[Stamping]:
    """As arrival, and one message in twenty is lost."""
    return (message for message in _arrival(rate, begin, rng) if rng.random() > 0.05)


def _stalls(rate: float, begin: float, rng: Random) -> Iterator[Stamping]:
    """As arrival, over a network that stops for 25 ms every 0.8 s and then catches up."""
    sent = -np.inf
    for message in _arrival(rate, begin, rng, mean=1e-4):
        within = message.sent % 0.8
        sent = max(message.sent + (0.025 - within if within < 0.025 else 0.0), sent + 1e-5)
        yield Stamping(message.reading, sent, sent)


def _clock_set(rate: float, begin: float, rng: Random) -> Iterator[Stamping]:
    """Right, by a clock that is set every 2 s, 5 ms on and back in turn."""
    for reading, *_ in _exact(rate, begin, rng):
        yield Stamping(reading, reading + 0.005 * (int(reading / 2) % 2), reading)


WAYS: dict[str, Callable[[float, float, Random], Iterator[Stamping]]] = {
    'exact': _exact, 'arrival': _arrival, 'reader': _reader, 'held': _held,
    'rounded': _rounded, 'made_up': _made_up, 'bursts': _bursts, 'lost': _lost,
    'stalls': _stalls, 'clock_set': _clock_set}
"""Ways of stamping, by name."""


def help_text() -> str:
    """Return what each way does, a line each."""
    return '\n'.join(f'  {name:10} {(way.__doc__ or "").strip()}' for name, way in WAYS.items())
