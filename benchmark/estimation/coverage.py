# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How often the truth lies within the intervals that estimates claim."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any

from benchmark.estimation.conditions import ALL
from benchmark.estimation.reference import Reference, twin_of
from benchmark.estimation.samples import Samples
from benchmark.estimation.simulated import record
import numpy as np
from rich.box import SIMPLE
from rich.table import Table

from screw_kinematics import models
from screw_kinematics.motion import MotionEstimator

INTERVALS = ((1.0, 0.63, 0.73), (1.96, 0.92, 0.98))
"""Half width in standard deviations, and the share of samples that must be inside."""

DELAYS = (0.0, 0.02, 0.05)
QUANTITIES = ('q\'', 'q"', 'twist', 'accel')
OFFSETS = 21
WARM_UP = 0.5
"""Seconds that are not counted."""

Deviations = dict[str, np.ndarray]
"""Errors over the standard deviations that were claimed, by quantity."""


ARMS = {6: 'puma560', 7: 'panda'}
"""Arms whose tip is moved, by the number of their joints."""


@cache
def arm(joints: int) -> Any:
    """Return an arm whose tip moves with so many joints, if there is one."""
    name = ARMS.get(joints)
    return name and models.load(f'package://screw_kinematics/config/robots/{name}.yaml')


def deviations(samples: Samples, truth: Any, delay: float,
               offsets: tuple[float, float] = (0.0, 0.0)) -> Deviations:
    """
    Return the errors of joints and tip over what is claimed of them.

    `truth` gives position, velocity and acceleration (3 or more, N, n) at times, NaN where it is
    not known. A constant latency nobody can know from the samples; the best of some `offsets`
    between two is allowed, s.
    """
    estimator = MotionEstimator(samples.positions.shape[1], delay)
    motions, at = [], []
    for stamp, ahead, *sample in zip(
            samples.stamps.tolist(), samples.ahead, samples.positions,
            [None] * len(samples.stamps) if samples.velocities is None else samples.velocities):
        motion = estimator.update(stamp, *sample)
        if motion is not None and motion.stamp > samples.stamps[0] + WARM_UP:
            motions.append(motion)
            at.append(motion.stamp - ahead)
    state = np.array([motion.state for motion in motions])
    variance = np.array([np.diagonal(motion.covariance, axis1=1, axis2=2).T
                         for motion in motions])
    # What is claimed of the instant, as it moves the joints' velocities and accelerations.
    together = np.array([motion.clock_error.of_state(motion.state) for motion in motions])
    q, v, a = min((truth(np.array(at) + offset)[:3] for offset in np.linspace(
        *offsets, OFFSETS if any(offsets) else 1)),
        key=lambda true: float(np.nanmean((state[:, 1] - true[1])**2)))
    known = np.isfinite(a).all(axis=1)
    q, v, a = q[known], v[known], a[known]
    state, variance, together = state[known], variance[known], together[known]
    found = {QUANTITIES[0]: (state[:, 1] - v) / np.sqrt(variance[:, 1]),
             QUANTITIES[1]: (state[:, 2] - a) / np.sqrt(variance[:, 2])}
    chain = arm(q.shape[1])
    if chain:
        jacobian = chain.jacobian(q)
        true, own = chain.state(q, v, a), chain.state(q, state[:, 1], state[:, 2])
        for order, what in ((1, QUANTITIES[2]), (2, QUANTITIES[3])):
            common = together[:, :, order]
            spread = np.einsum('kij,kj->ki', jacobian**2,
                               variance[:, order] - (common**2).sum(axis=1))
            spread += (np.einsum('kij,klj->kli', jacobian, common)**2).sum(axis=1)
            found[what] = (own.classical(order) - true.classical(order)) / np.sqrt(spread)
    return found


def simulated(condition: str, seeds: Sequence[int], delay: float,
              kinds: Iterable[str]) -> Deviations:
    """Return the deviations of some kinds of motion, measured in one way."""
    found: dict[str, list[np.ndarray]] = {what: [] for what in QUANTITIES}
    for seed in seeds:
        for kind in kinds:
            recording = record(kind, ALL[condition], seed)
            # Of drivers it is taken off already, and given back; of bursts it is not.
            latency = recording.latency
            ratios = deviations(recording.arrived, recording.truth, delay, (
                (-latency, 0.0) if ALL[condition].burst > 1 else (0.0, latency)))
            for what, ratio in ratios.items():
                found[what].append(ratio)
    return {what: np.concatenate(ratios) for what, ratios in found.items()}


def of_twin(samples: Samples, reference: Reference, seed: int, delay: float) -> Deviations:
    """Return the deviations on samples like recorded ones, whose truth is known."""
    twin, half = twin_of(samples, reference, seed), reference.period / 2
    return deviations(twin.samples, lambda t: [twin.truth.at(t, k) for k in range(3)], delay,
                      (-half, half))


def shares(ratios: np.ndarray) -> tuple[float, ...]:
    """Return which shares of the deviations lie within the intervals."""
    return tuple(float((np.abs(ratios) <= width).mean()) for width, *_ in INTERVALS)


def table(rows: Iterable[tuple[str, Sequence[Deviations]]]) -> Table:
    """Return shares in percent, with a mark where they are not what they must be."""
    shown = Table(title='truth within the 68 and 95 % intervals, % of samples '
                        '(* not 63 to 73, or 92 to 98)', box=SIMPLE, padding=(0, 1, 0, 0))
    shown.add_column('condition', no_wrap=True)
    for delay in DELAYS:
        for what in QUANTITIES:
            shown.add_column(f'{what}\n{1e3 * delay:.0f} ms', justify='right')
    for name, by_delay in rows:
        shown.add_row(name, *(_cell(found.get(what)) for found in by_delay
                              for what in QUANTITIES))
    return shown


def _cell(ratios: np.ndarray | None) -> str:
    if ratios is None:
        return ''
    return ' '.join(f"{100 * share:.0f}{'' if low <= share <= high else '*'}"
                    for share, (_, low, high) in zip(shares(ratios), INTERVALS))
