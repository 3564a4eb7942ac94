# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joint motions with exact derivatives, drawn at random by kind."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

MOVING = ('minimum jerk', 's-curve', 'trapezoidal acceleration', 'trapezoidal velocity',
          'puma', 'multi-sine')
KINDS = (*MOVING, 'standstill', 'sudden stop')

MINIMUM_JERK = (0, 0, 0, 10, -15, 6)
SEVENTH_ORDER = (0, 0, 0, 0, 35, -84, 70, -20)
# Peak acceleration of a move of unit length and duration.
PEAK = {MINIMUM_JERK: 5.7735, SEVENTH_ORDER: 7.5132}


@dataclass
class PiecewisePolynomial:
    """Pieces of a motion, begun where the one before ended; `stops` are (time, deceleration)."""

    time: float = 0.0
    state: np.ndarray = field(default_factory=lambda: np.zeros(3))
    breaks: list[float] = field(default_factory=list)
    coefficients: list[np.ndarray] = field(default_factory=list)
    stops: list[tuple[float, float]] = field(default_factory=list)

    def add(self, duration: float, coefficients: Sequence[float] | np.ndarray) -> None:
        self.breaks.append(self.time)
        padded = np.zeros(8)
        padded[:len(coefficients)] = coefficients
        self.coefficients.append(padded)
        self.time += duration

    def jerk(self, duration: float, jerk: float, acceleration: float | None = None) -> None:
        q, v, a = self.state
        a = a if acceleration is None else acceleration
        self.add(duration, [q, v, a / 2, jerk / 6])
        t = duration
        self.state = np.array([q + v * t + a * t * t / 2 + jerk * t**3 / 6,
                               v + a * t + jerk * t * t / 2, a + jerk * t])

    def rest(self, duration: float) -> None:
        self.state[1:] = 0.0
        self.jerk(duration, 0.0)

    def move(self, distance: float, duration: float, shape: Sequence[float]) -> None:
        powers = duration ** -np.arange(len(shape), dtype=float)
        coefficients = distance * np.array(shape) * powers
        coefficients[0] += self.state[0]
        self.add(duration, coefficients)
        self.state = np.array([self.state[0] + distance, 0.0, 0.0])

    def __call__(self, t: np.ndarray) -> np.ndarray:
        piece = np.clip(np.searchsorted(self.breaks, t, side='right') - 1, 0, None)
        c = np.array(self.coefficients)[piece]
        powers = (t - np.array(self.breaks)[piece])[:, None] ** np.arange(c.shape[1])
        rows = []
        for _ in range(4):
            rows.append((c * powers[:, :c.shape[1]]).sum(axis=1))
            c = c[:, 1:] * np.arange(1, c.shape[1])
        return np.stack(rows)


@dataclass
class Sines:
    """A sum of sines about an offset."""

    offset: float
    amplitude: np.ndarray
    omega: np.ndarray
    phase: np.ndarray
    stops: tuple = ()

    def __call__(self, t: np.ndarray) -> np.ndarray:
        angle = np.multiply.outer(t, self.omega) + self.phase
        rows = [(self.amplitude * self.omega**k * np.sin(angle + k * np.pi / 2)).sum(axis=-1)
                for k in range(4)]
        rows[0] += self.offset
        return np.stack(rows)


def draw(kind: str, rng: np.random.Generator, seconds: float) -> Callable:
    """Return one joint's motion: a function of time that gives (4, N)."""
    start = rng.uniform(-1.5, 1.5)
    one = np.ones(1)
    if kind == 'standstill':
        return Sines(start, 0 * one, one, 0 * one)
    if kind == 'puma':
        return Sines(start, 0.2 * one, rng.choice([1.0, 2.0, 3.0]) * one,
                     rng.uniform(0, 2 * np.pi) * one)
    if kind == 'multi-sine':
        f = rng.uniform(0.1, 5.0, 6)
        amplitude = rng.uniform(0.5, 1.5, 6) / (1 + (f / 2.5) ** 2)
        amplitude *= rng.uniform(3, 8) / np.sqrt((amplitude**2).sum() / 2)
        omega = 2 * np.pi * f
        return Sines(start, amplitude / omega**2, omega, rng.uniform(0, 2 * np.pi, 6))
    path = PiecewisePolynomial(state=np.array([start, 0.0, 0.0]))
    path.rest(rng.uniform(0.3, 0.6))
    sign = float(rng.choice([-1.0, 1.0]))
    while path.time < seconds + 1:
        _one_move(kind, rng, path, sign)
        path.rest(rng.uniform(0.2, 0.6))
        sign = -sign if rng.random() < 0.8 else sign
    return path


def _one_move(kind: str, rng: np.random.Generator, path: PiecewisePolynomial, sign: float) -> None:
    if kind in ('minimum jerk', 's-curve'):
        shape = MINIMUM_JERK if kind == 'minimum jerk' else SEVENTH_ORDER
        duration, peak = rng.uniform(0.4, 1.6), rng.uniform(2.0, 12.0)
        path.move(sign * peak * duration**2 / PEAK[shape], duration, shape)
    elif kind == 'trapezoidal acceleration':
        ramp, hold, cruise = rng.uniform(0.03, 0.12), rng.uniform(0, 0.2), rng.uniform(0, 0.5)
        jerk = sign * rng.uniform(2, 10) / ramp
        for duration, j in ((ramp, jerk), (hold, 0), (ramp, -jerk), (cruise, 0),
                            (ramp, -jerk), (hold, 0), (ramp, jerk)):
            path.jerk(duration, j)
    elif kind == 'trapezoidal velocity':
        ramp, cruise, a = rng.uniform(0.1, 0.4), rng.uniform(0.1, 0.6), sign * rng.uniform(1, 6)
        for duration, acceleration in ((ramp, a), (cruise, 0.0), (ramp, -a)):
            path.jerk(duration, 0.0, acceleration)
    elif kind == 'sudden stop':
        speed, duration = sign * rng.uniform(0.5, 1.5), rng.uniform(0.3, 0.6)
        jerk = 4 * speed / duration**2
        path.jerk(duration / 2, jerk)
        path.jerk(duration / 2, -jerk)
        path.state[2] = 0.0
        path.jerk(rng.uniform(0.2, 0.6), 0.0)
        stop = rng.uniform(0.01, 0.03)
        path.jerk(stop, 0.0, -speed / stop)
        path.stops.append((path.time, -speed / stop))
