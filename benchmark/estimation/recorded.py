# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Estimators on a recording of somebody's own arm."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
import json
from pathlib import Path
from typing import Any

from benchmark.estimation.candidates import best, BEST_CUTOFF, run_usual, USUAL
from benchmark.estimation.reference import floor, Reference, reference_of
from benchmark.estimation.samples import Result, Samples
from benchmark.estimation.score import geometric_mean
import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from screw_kinematics.errors import ParameterError, ToolError
from screw_kinematics.recordings.joint_streams import JointStream, JointStreams
from screw_kinematics.recordings.joint_table import JointTable
from screw_kinematics.recordings.recording import JOINT_STATE, Recording
from screw_kinematics.recordings.sources import opened
from screw_kinematics.recordings.table_columns import by_number
from screw_kinematics.tools.table_options import table_format

TRUSTED = 0.25
"""The reference must miss less than this share of usual practice's error, and of the motion."""

RESOLVED = 4.0
"""Errors below so many times what the reference may miss are not told apart."""

MOVES = 0.02
"""Range of positions from which on a joint moves, rad or m."""

FEWEST, MOST_JOINTS = 500, 64


@dataclass(frozen=True)
class Recorded:
    """Samples of an arm, their reference, and what it is worth, by joint: RMS in rad/s^2."""

    names: tuple[str, ...]
    samples: Samples
    reference: Reference
    signal: np.ndarray
    missed: np.ndarray
    usual: np.ndarray

    def error(self, result: Result) -> np.ndarray:
        """Return the RMS error of the accelerations at the claimed instants, shape (n,)."""
        return np.sqrt(np.nanmean(self.errors(result)**2, axis=0))

    def errors(self, result: Result) -> np.ndarray:
        """Return the errors, NaN where the reference does not vouch."""
        return result.acceleration - self.reference.at(result.t, 2)

    @property
    def ordered(self) -> Samples:
        """Return the samples in the order of their stamps."""
        return _increasing(self.samples)

    @property
    def joints(self) -> np.ndarray:
        """Return those joints that move, and of which the reference can be trusted."""
        return np.flatnonzero((self.missed < TRUSTED * np.minimum(self.usual, self.signal))
                              & (np.ptp(self.samples.positions, axis=0) > MOVES))


def add_options(recorded: Any) -> None:
    """Add the options that say which recording, and what is known of it."""
    recorded.add_argument('--recording', metavar='FILE', help='a bag, or a table (CSV, Parquet) '
                          'with stamps, positions and, if there are, velocities')
    recorded.add_argument('--topic', default='', help='of the joint states in a bag')
    recorded.add_argument('--joints', metavar='NAME,...', default='',
                          help='which joints; by default those that come together most often')
    recorded.add_argument('--cutoff', type=float, metavar='HZ',
                          help='only what is slower is called motion; by default the spectrum '
                          'tells what the reference follows')


def compare(chosen: argparse.Namespace, names: Sequence[str], console: Console) -> None:
    """Score estimators on a recording, print the table, draw and write what is asked for."""
    with console.status('reference'):
        arm = prepare(*read(chosen), chosen.cutoff)
    console.print(_about(arm))
    joints = arm.joints
    if not len(joints):
        raise ToolError(f'{chosen.recording}: no joint that moves by more than {MOVES} rad and '
                        'whose reference can be trusted; state --cutoff HZ if you know up to '
                        'where its motion goes')
    results, rows = {}, {}
    for name in track(list(dict.fromkeys([USUAL, *names])), 'estimators', console=console):
        samples = arm.samples
        if name in (USUAL, BEST_CUTOFF):
            samples = replace(arm.ordered, velocities=None)
        result = run_usual(samples) if name == USUAL else best(
            name, samples, lambda result: geometric_mean(arm.error(result)[joints]))
        results[name], rows[name] = result, score(arm, result)
    console.print(_table(rows))
    if any(not row['resolved'] for row in rows.values()):
        console.print(f'~ some error is below {RESOLVED:g} times what the reference may miss: '
                      'read it as at most')
    if chosen.json:
        chosen.json.write_text(json.dumps(rows, indent=1))
    if chosen.plot:
        from benchmark.estimation.pictures import draw_recording
        draw_recording(arm, results, rows, chosen.plot)


def prepare(names: tuple[str, ...], samples: Samples, cutoff: float | None = None) -> Recorded:
    """Return samples with their reference and what it is worth."""
    ordered = _increasing(samples)
    reference = reference_of(ordered, cutoff)
    missed = floor(ordered, reference, within=cutoff is not None)
    arm = Recorded(names, samples, reference, np.zeros(0), missed, np.zeros(0))
    signal = np.sqrt(np.nanmean(reference.at(ordered.stamps, 2)**2, axis=0))
    usual = run_usual(replace(ordered, velocities=None))
    return replace(arm, signal=signal, usual=arm.error(usual))


def _increasing(samples: Samples) -> Samples:
    """Return samples in the order of their stamps."""
    rows, velocities = samples.increasing(), samples.velocities
    return Samples(samples.stamps[rows], samples.positions[rows],
                   None if velocities is None else velocities[rows], samples.ahead[rows])


def score(arm: Recorded, result: Result) -> dict[str, float]:
    """
    Return the scores of a result, over the joints that count.

    `score`: RMS error over usual practice's, geometric mean; `relative`: over the motion's RMS;
    `largest`: the largest error over it; `outputs` per sample; `resolved`: whether the reference
    can tell.
    """
    joints = arm.joints
    errors = arm.errors(result)[:, joints]
    rms = np.sqrt(np.nanmean(errors**2, axis=0))
    return {'score': geometric_mean(rms / arm.usual[joints]),
            'relative': geometric_mean(rms / arm.signal[joints]),
            'largest': float((np.nanmax(np.abs(errors), axis=0) / arm.signal[joints]).max()),
            'outputs': len(result.t) / len(arm.samples.stamps), 'delay': result.behind,
            'cost': result.cost,
            'resolved': bool((rms >= RESOLVED * arm.missed[joints]).all())}


def _about(arm: Recorded) -> Table:
    """Return what is known of the recording."""
    reference, samples = arm.reference, arm.samples
    late = samples.stamps[samples.increasing()] - reference.times
    clock = 'stamps are those of the readings' if not reference.period else (
        f'readings at {1 / reference.period:.0f} Hz, {1e3 * late.std():.2f} ms (RMS) from their '
        f'stamps, {1 - reference.fresh.mean():.1%} held')
    shown = Table(title=f'{len(samples.stamps)} samples in '
                        f'{np.ptp(samples.stamps):.1f} s; {clock}')
    for heading in ('joint', 'acceleration, RMS', 'followed to Hz', 'may miss', 'usual practice '
                    'errs by', 'counts'):
        shown.add_column(heading, justify='left' if heading == 'joint' else 'right')
    for j, name in enumerate(arm.names):
        shown.add_row(name, f'{arm.signal[j]:.3g}', f'{reference.cutoffs[j]:.1f}',
                      f'{arm.missed[j] / arm.signal[j]:.1%}',
                      f'{arm.usual[j] / arm.signal[j]:.1%}', 'yes' if j in arm.joints else 'no')
    return shown


def _table(rows: dict[str, dict[str, float]]) -> Table:
    shown = Table(title='acceleration error at the claimed stamp')
    for heading in ('estimator', 'over usual practice', 'over the motion', 'largest',
                    'outputs / samples', 'delay ms', 'cost us'):
        shown.add_column(heading, justify='left' if heading == 'estimator' else 'right')
    for name, row in rows.items():
        shown.add_row(name, f"{row['score']:.3f}{' ' if row['resolved'] else '~'}",
                      f"{row['relative']:.3f}", f"{row['largest']:.1f}",
                      f"{row['outputs']:.3f}", f"{1e3 * row['delay']:.0f}", f"{row['cost']:.0f}")
    return shown


def read(chosen: argparse.Namespace) -> tuple[tuple[str, ...], Samples]:
    """Return the joints of a recording, and their samples."""
    return samples_of(*read_stream(chosen))


def read_stream(chosen: argparse.Namespace) -> tuple[JointStream, tuple[str, ...]]:
    """Return the joint samples of a recording as they came, and which joints are wanted."""
    streams = JointStreams()
    asked = tuple(name for name in chosen.joints.split(',') if name)
    with opened(chosen.recording, table_format(chosen)) as recording:
        if isinstance(recording, JointTable):
            names = asked or _numbered(recording.columns(), recording.path)
            samples = recording.samples(dict.fromkeys(names, 'revolute'))
        elif isinstance(recording, Recording):
            samples = recording.samples({_topic(recording, chosen.topic)})
        for _, received, sample in samples:
            streams.take(received, sample)
    found = sorted(streams.streams.values(), key=len)
    found = [stream for stream in found if set(asked) <= set(stream.names)]
    if not found or len(found[-1]) < FEWEST:
        raise ToolError(f'{chosen.recording}: {len(found[-1]) if found else 0} samples of '
                        f'{", ".join(asked) or "joints"}; allowed: {FEWEST} or more that come '
                        'together')
    return found[-1], asked or found[-1].names


def samples_of(stream: JointStream,
               names: tuple[str, ...]) -> tuple[tuple[str, ...], Samples]:
    """Return names, and the samples of these joints."""
    columns = [stream.names.index(name) for name in names]
    positions, velocities = stream.position()[:, columns], stream.velocity()[:, columns]
    good = np.isfinite(positions).all(axis=1)
    stamps = stream.times()[good]
    measured = velocities[good]
    return names, Samples(stamps, np.unwrap(positions[good], axis=0),
                          measured if np.isfinite(measured).any() else None,
                          np.zeros(len(stamps)))


def _topic(recording: Recording, topic: str) -> str:
    """Return the topic of the joint states."""
    there = sorted({c.topic for c in recording.connections if c.kind == JOINT_STATE})
    if topic:
        recording.require_joint_states({topic})
        return topic
    if len(there) != 1:
        raise ToolError(f'{recording.path}: joint states on {", ".join(there) or "no topic"}; '
                        'name one by --topic')
    return there[0]


def _numbered(columns: Sequence[str], path: Path) -> tuple[str, ...]:
    """Return names for joints whose columns are numbered."""
    for count in range(MOST_JOINTS, 0, -1):
        names = tuple(f'joint {i + 1}' for i in range(count))
        if all(name in by_number(columns, names) for name in names):
            return names
    raise ParameterError('joints', '', f'which of {path}: {", ".join(columns)}')
