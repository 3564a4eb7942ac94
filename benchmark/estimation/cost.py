# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What one update costs, beside numpy.add on two 7-vectors, the yardstick of the machine."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import thread_time
from typing import NamedTuple

import numpy as np
from rich.table import Table

from screw_kinematics.motion import MotionEstimator
from screw_kinematics.motion.compiled import load

PERIOD = 1e-3
ENCODER_STEP = 1e-5
SETTLE = 3000
"""Samples before the measurement."""

CHUNK = 20
"""Updates measured together; a measurement of the yardstick stands on either side."""

CASES: tuple[tuple[str, int, float, bool], ...] = (
    ('position only', 7, 0.0, False), ('with velocity', 7, 0.0, True),
    ('delay 20 ms', 7, 0.02, False), ('delay 20 ms, with velocity', 7, 0.02, True),
    ('position only', 40, 0.0, False),
)
"""Name, joints, delay (s), whether velocities are measured."""


class Cost(NamedTuple):
    """Medians: us of one update, of numpy.add at the same moments, and their ratio."""

    update: float
    add: float
    ratio: float


def yardstick(repetitions: int = 500) -> float:
    """Return the time of numpy.add on two 7-vectors, us."""
    a, b, add = np.ones(7), np.ones(7), np.add
    begin = thread_time()
    for _ in range(repetitions):
        add(a, b)
    return 1e6 * (thread_time() - begin) / repetitions


def samples(joints: int, velocity: bool) -> Iterator[tuple[float, list[float], list[float]]]:
    """Give stamps, positions and velocities at a regular clock, as a driver would."""
    random = np.random.default_rng(5)
    phase = random.uniform(0, 2 * np.pi, joints)
    count = 0
    while True:
        t = PERIOD * np.arange(count, count + CHUNK)
        angle = 2.0 * t[:, None] + phase
        q = np.round(np.sin(angle) / ENCODER_STEP) * ENCODER_STEP
        v = 2.0 * np.cos(angle) + random.normal(0, 1e-3, angle.shape)
        yield from zip(t.tolist(), q.tolist(), v.tolist())
        count += CHUNK


def measure(joints: int, delay: float, velocity: bool, compiled: bool, chunks: int) -> Cost:
    """Return what an update costs once the gains have converged."""
    estimator = MotionEstimator(joints, delay)
    if compiled:
        estimator.warm_up()
    else:
        estimator._use(None)
    source = samples(joints, velocity)
    update: Callable = estimator.update
    rows = []
    for chunk in range(-SETTLE // CHUNK, chunks):
        ready = [(t, q, v if velocity else None) for t, q, v in (
            next(source) for _ in range(CHUNK))]
        before = yardstick() if chunk >= 0 else 0.0
        begin = thread_time()
        for t, q, v in ready:
            update(t, q, v)
        cost = 1e6 * (thread_time() - begin) / CHUNK
        if chunk >= 0:
            add = 0.5 * (before + yardstick())
            rows.append((cost, add, cost / add))
    return Cost(*np.median(rows, axis=0).tolist())


def table(chunks: int = 200) -> Table:
    """Measure all cases; return them as a table."""
    shown = Table(title='one update at 1 kHz, regular stamps (medians)')
    for heading in ('joints', 'samples', 'with', 'us', 'np.add us', 'update / np.add'):
        shown.add_column(heading, justify='left' if heading in ('samples', 'with') else 'right')
    for name, joints, delay, velocity in CASES:
        for compiled in (False, True) if load() is not None else (False,):
            cost = measure(joints, delay, velocity, compiled, chunks)
            shown.add_row(
                str(joints), name, 'Numba' if compiled else 'NumPy', f'{cost.update:.1f}',
                f'{cost.add:.2f}', f'{cost.ratio:.0f}')
    return shown
