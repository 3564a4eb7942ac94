# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What is right and wrong with the joint states of a topic."""
from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from .findings import FACT, Finding, PROBLEM, REMARK
from .readings import report_readings
from .sources import report_overlaps, report_sources, report_velocity_field
from ...recordings.joint_streams import JointStream, JointStreams
from ...screws.se3 import Array

# A pause after which the node's estimators start anew, by default [s].
_PAUSE = 0.25
# Stamps that go back by more begin anew, too [s].
_BACK = 0.5
_LATE = 0.1
_LEAST = 20


def report_streams(topic: str, streams: JointStreams,
                   wanted: Mapping[str, str]) -> Iterator[Finding]:
    """Yield what is found in the samples of a topic, of joints whose kinds are given by name."""
    if streams.malformed:
        yield Finding(PROBLEM, f'{topic}: {streams.malformed} messages cannot be read: '
                               f'{streams.last_error}')
    if not streams.streams:
        yield Finding(PROBLEM, f'{topic}: no joint state came',
                      'is the driver running, and the topic right?')
        return
    come = [name for names in streams.streams for name in names]
    missing = [name for name in wanted if name not in come]
    if missing:
        yield Finding(PROBLEM, f'{topic}: nobody publishes {", ".join(missing)}',
                      f'published are: {", ".join(sorted(set(come)))}')
    yield from report_overlaps(topic, list(streams.streams.values()), wanted)
    for stream in streams.streams.values():
        if any(name in wanted for name in stream.names):
            label = label_of(topic, stream, len(streams.streams))
            yield from _report(topic, label, stream, wanted)


def label_of(topic: str, stream: JointStream, streams: int) -> str:
    """Return what the samples are called: by their topic, and the joints where it has several."""
    if streams == 1:
        return topic
    names = ', '.join(stream.names[:3]) + (', ...' if len(stream.names) > 3 else '')
    return f'{topic} ({names})'


def _report(topic: str, label: str, stream: JointStream, wanted: Mapping[str, str],
            ) -> Iterator[Finding]:
    if stream.wrong_length:
        yield Finding(PROBLEM, f'{label}: {stream.wrong_length} messages have another number '
                               f'of positions than of names ({len(stream.names)})')
    if len(stream) < _LEAST:
        yield Finding(PROBLEM, f'{label}: only {len(stream)} usable messages',
                      f'at least {_LEAST} are needed to say more')
        return
    yield from _report_stamps(label, stream)
    columns = [i for i, name in enumerate(stream.names) if name in wanted]
    names = [stream.names[i] for i in columns]
    position = stream.position()[:, columns]
    bad = ~np.isfinite(position).all(axis=1)
    if bad.any():
        yield Finding(PROBLEM, f'{label}: {int(bad.sum())} messages have positions that are '
                               'not finite', 'they are refused')
    received = np.array(stream.received, dtype=np.int64)[~bad]
    yield from report_sources(topic, label, names, received, position[~bad])
    yield from report_readings(label, names, [wanted[name] for name in names],
                               stream.times()[~bad], position[~bad])
    yield from _report_velocity(label, names, stream.times()[~bad], position[~bad],
                                stream.velocity()[:, columns][~bad])


def _report_stamps(label: str, stream: JointStream) -> Iterator[Finding]:
    stamps = np.array(stream.stamps, dtype=np.int64)
    received = np.array(stream.received, dtype=np.int64)
    arrivals = np.diff(received) * 1e-9
    if not stamps.any():
        yield Finding(REMARK, f'{label}: stamps are zero; '
                              f'{_rate(arrivals):.1f} messages a second',
                      'time of arrival is used instead, which jitters; let the driver stamp '
                      'its measurements')
        return
    if (stamps[1:] == 0).any():      # a table may begin at 0
        yield Finding(REMARK, f'{label}: {int((stamps == 0).sum())} stamps are zero')
        stamps, received = stamps[stamps != 0], received[stamps != 0]
    steps = np.diff(stamps) * 1e-9
    ahead = steps[steps > 0]
    if len(ahead) < _LEAST // 2:
        yield Finding(PROBLEM, f'{label}: stamps do not advance',
                      'samples with an old stamp are refused')
        return
    period = float(np.median(ahead))
    spread = float(np.percentile(np.abs(ahead - period), 95))
    yield Finding(FACT, f'{label}: {1 / period:.1f} Hz, 95 % of the periods within '
                        f'{1e3 * spread:.2f} ms of {1e3 * period:.2f} ms')
    again = steps < -_BACK
    for count, what in ((int((steps == 0).sum()), 'stamps repeat the one before'),
                        (int(((steps < 0) & ~again).sum()), 'stamps go back in time')):
        if count:
            yield Finding(REMARK, f'{label}: {count} {what}', 'these samples are refused')
    if again.any():
        yield Finding(REMARK, f'{label}: stamps go back {int(again.sum())} times, by up to '
                              f'{-steps.min():.2f} s: a recording that was played again, or a '
                              'clock that was set',
                      'the estimator starts anew after each')
    pauses = ahead[ahead > _PAUSE]
    if len(pauses):
        yield Finding(REMARK, f'{label}: {len(pauses)} pauses longer than {_PAUSE} s, the '
                              f'longest {pauses.max():.2f} s',
                      'the estimator starts anew after each; raise estimator.max_gap if the '
                      'driver is meant to pause')
    if (arrivals < 0.2 * period).mean() > 0.2:
        yield Finding(REMARK, f'{label}: messages come in bursts')
    if again.any():
        return      # the age of what is played again tells nothing
    age = (received - stamps) * 1e-9
    late = float(np.median(age))
    if late < -1e-3:
        yield Finding(PROBLEM, f'{label}: stamps are {-1e3 * late:.1f} ms in the future',
                      'synchronise the clocks of the computers (chrony, PTP)')
    elif late > _LATE:
        yield Finding(REMARK, f'{label}: samples are {1e3 * late:.0f} ms old when they come',
                      'states will be as old; another clock, or a slow network?')
    else:
        yield Finding(FACT, f'{label}: samples are {1e3 * late:.2f} ms old when they come')


def _rate(arrivals: Array) -> float:
    return float(1.0 / max(float(np.median(arrivals)), 1e-9))


def _report_velocity(label: str, names: Sequence[str], time: Array, position: Array,
                     velocity: Array) -> Iterator[Finding]:
    measured = np.isfinite(velocity)
    if not measured.any():
        yield Finding(FACT, f'{label}: velocity is not measured',
                      'it is estimated from the positions')
        return
    share = measured.mean()
    if share < 1:
        yield Finding(REMARK, f'{label}: velocity is missing in {100 * (1 - share):.0f} % of '
                              'the values')
    moved = np.ptp(position, axis=0) > 1e-4
    zero = np.array([not velocity[:, i][measured[:, i]].any() for i in range(len(names))])
    filled = [name for name, is_zero in zip(names, zero & moved) if is_zero]
    if filled:
        yield Finding(REMARK, f'{label}: velocity of {", ".join(filled)} is always zero, '
                              'though the positions change',
                      'the estimator finds out; velocity_source: estimated leaves no doubt; '
                      'never use measured')
    yield from report_velocity_field(label, names, time, position, velocity)
    for i in np.flatnonzero(moved & ~zero & measured.all(axis=0)).tolist():
        lag = _lag(time, position[:, i], velocity[:, i])
        if lag is not None and lag > 2e-3:
            yield Finding(REMARK, f'{label}: velocity of {names[i]} lags its position by '
                                  f'{1e3 * lag:.0f} ms',
                          'the driver filters it; use velocity_source: estimated or auto')


def _lag(time: Array, position: Array, velocity: Array) -> float | None:
    """
    Return by how much a measured velocity is late [s], if that can be told.

    The integral of the velocity, shifted by the lag, must run parallel to the position.
    """
    advancing = np.concatenate([[True], np.diff(time) > 0])
    t, q, v = time[advancing], position[advancing], velocity[advancing]
    if len(t) < _LEAST:
        return None
    period = float(np.median(np.diff(t)))
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
    lags = np.linspace(0.0, 0.1, 101)
    inside = (t > t[0]) & (t < t[-1] - lags[-1])
    if inside.sum() < _LEAST:
        return None
    misfit = np.array([np.std(q[inside] - np.interp(t[inside] + lag, t, integral))
                       for lag in lags])
    best = int(misfit.argmin())
    if misfit[0] < 2 * misfit[best] or lags[best] < period:
        return 0.0
    return float(lags[best])
