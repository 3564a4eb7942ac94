# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What one update costs, beside numpy.add on two 7-vectors, the yardstick of the machine."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import thread_time
from typing import NamedTuple

import numpy as np
from rich.table import Table

from screw_kinematics.motion import MotionEstimator
from screw_kinematics.pipeline.group_motion import GroupMotion, make_motion
from screw_kinematics.pipeline.joint_groups import JointGroup, Reading
from screw_kinematics.pipeline.settings import MotionSettings

PERIOD = 1e-3
ENCODER_STEP = 1e-5
SETTLE = 3000
"""Samples before the measurement."""

CHUNK = 200
"""Updates measured together, beside as many of the yardstick: whatever is done now and then
is in it."""

CASES: tuple[tuple[str, int, float, bool], ...] = (
    ('position only', 7, 0.0, False), ('with velocity', 7, 0.0, True),
    ('delay 20 ms', 7, 0.02, False), ('delay 20 ms, with velocity', 7, 0.02, True),
    ('position only', 40, 0.0, False),
)
"""Name, joints, delay (s), whether velocities are measured."""


class Cost(NamedTuple):
    """CPU time of one update and of numpy.add, us, and their ratio."""

    update: float
    add: float
    ratio: float


def yardstick(repetitions: int = CHUNK) -> float:
    """Return the time of numpy.add on two 7-vectors, us."""
    a, b, add = np.ones(7), np.ones(7), np.add
    begin = thread_time()
    for _ in range(repetitions):
        add(a, b)
    return 1e6 * (thread_time() - begin) / repetitions


def samples(joints: int, count: int) -> list[tuple[float, list[float], list[float]]]:
    """Return stamps, positions and velocities at a regular clock, as lists: so messages come."""
    random = np.random.default_rng(5)
    t = PERIOD * np.arange(count)
    angle = 2.0 * t[:, None] + random.uniform(0, 2 * np.pi, joints)
    q = np.round(np.sin(angle) / ENCODER_STEP) * ENCODER_STEP
    v = 2.0 * np.cos(angle) + random.normal(0, 1e-3, angle.shape)
    return list(zip(t.tolist(), q.tolist(), v.tolist()))


def measure(joints: int, delay: float, velocity: bool, chunks: int,
            node: bool = False) -> Cost:
    """Return what an update, or a sample in the node, costs once the gains have converged."""
    group = JointGroup(tuple(range(joints)), True)
    motion = make_motion(MotionSettings(delay=delay), [False] * joints, [20.0] * joints, 2,
                         False)
    estimator = motion.estimator if node else MotionEstimator(joints, delay)
    assert isinstance(estimator, MotionEstimator)
    recording: list[tuple] = list(samples(joints, SETTLE + chunks * CHUNK))
    update: Callable = estimator.update
    if node:
        recording = [(round(1e9 * t), q, v) for t, q, v in recording]
        update = partial(_update, motion, group)
    rows = []
    for first in range(0, len(recording), CHUNK):
        chunk = [(t, q, v if velocity else None) for t, q, v in recording[first:first + CHUNK]]
        begin = thread_time()
        for t, q, v in chunk:
            update(t, q, v)
        cost = 1e6 * (thread_time() - begin) / CHUNK
        if first >= SETTLE:
            rows.append((cost, yardstick()))
    # What else runs on the machine only adds: the fastest tenth tells the cost itself.
    cost, add = np.percentile(rows, 10, axis=0).tolist()
    return Cost(cost, add, cost / add)


def _update(motion: GroupMotion, group: JointGroup, stamp_ns: int, q: list[float],
            v: list[float] | None) -> object:
    return motion.update(Reading(group, stamp_ns, q, v))


def table(chunks: int = 60) -> Table:
    """Measure all cases; return them as a table."""
    shown = Table(title='one update at 1 kHz, regular stamps (CPU time, fastest tenth of runs)')
    for heading in ('joints', 'samples', 'update us', '/ np.add', 'in the node us', '/ np.add',
                    'np.add us'):
        shown.add_column(heading, justify='left' if heading == 'samples' else 'right')
    for name, joints, delay, velocity in CASES:
        cost, within = (measure(joints, delay, velocity, chunks, node) for node in (False, True))
        shown.add_row(
            str(joints), name, f'{cost.update:.1f}', f'{cost.ratio:.0f}', f'{within.update:.1f}',
            f'{within.ratio:.0f}', f'{cost.add:.2f}')
    return shown
