# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A page about recorded motion, with its pictures in it: nothing else is loaded."""
from __future__ import annotations

from collections.abc import Iterator, Sequence
from datetime import datetime, timezone
from html import escape
import os
from pathlib import Path

import numpy as np

from .pictures import curves, distribution, path_views
from ...recordings.processing import Outcome, RobotOutcome
from ...recordings.summary import EDGES, MotionSummary, NEAR_SINGULAR

_STYLE = """\
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 62em; padding: 0 1em;
       color: #222; background: #fff; overflow-wrap: anywhere }
table { border-collapse: collapse; margin: .6em 0; display: block; overflow-x: auto }
td, th { border-bottom: 1px solid #ddd; padding: .2em .8em .2em 0; text-align: right;
         white-space: nowrap }
td:first-child, th:first-child { text-align: left; white-space: normal; min-width: 8em }
figure { display: inline-block; width: 29em; max-width: 100%; margin: .4em 1em .4em 0;
         vertical-align: top }
figcaption { color: #555; font-size: 13px }
svg text { font-size: 11px; fill: #333 }
summary { cursor: pointer; font-weight: 600; margin: .4em 0 }
.fault { color: #a11 }"""
_QUANTITIES = (('speed', 'speed', 'm/s'), ('turning', 'angular speed', 'rad/s'),
               ('acceleration', 'acceleration', 'm/s²'))
_SHARES = (0.5, 0.95, 0.99)
_MOST_STOPS = 20


def write_report(path: Path, outcomes: Sequence[Outcome], stop_limit: float) -> None:
    """Write the page; a hard stop decelerates by more than the limit [m/s^2]."""
    page = ''.join(_page(outcomes, stop_limit))
    unfinished = path.with_name(f'.{path.name}.unfinished')
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished.write_text(page, encoding='utf-8')
    os.replace(unfinished, path)


def _page(outcomes: Sequence[Outcome], stop_limit: float) -> Iterator[str]:
    yield ('<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">'
           '<meta name="viewport" content="width=device-width, initial-scale=1">'
           f'<title>Recorded motion</title><style>{_STYLE}</style></head><body>'
           '<h1>Recorded motion</h1>')
    robots = [robot for outcome in outcomes for robot in outcome.robots]
    yield (f'<p>{_recordings(len(outcomes))}, {sum(r.received for r in robots):,} joint samples, '
           f'{sum(r.states for r in robots):,} states. Linear quantities are of the tip, relative '
           f'to the base; a hard stop slows it down by more than {stop_limit:g} m/s²; near a '
           'singularity the least singular value of the Jacobian is below '
           f'{NEAR_SINGULAR:g} of the greatest.</p>')
    for name in dict.fromkeys(robot.name for robot in robots):
        yield from _fleet(name, [(outcome, robot) for outcome in outcomes
                                 for robot in outcome.robots if robot.name == name])
    yield '<h2>Each recording</h2>'
    for outcome in outcomes:
        yield from _recording(outcome, open_it=len(outcomes) == 1)
    yield '</body></html>\n'


def _fleet(name: str, robots: Sequence[tuple[Outcome, RobotOutcome]]) -> Iterator[str]:
    """Yield what all recordings of a robot say together."""
    whole = MotionSummary()
    for _, robot in robots:
        if robot.summary is not None:
            whole.merge(robot.summary)
    yield f'<h2>{escape(name)}</h2>'
    if not whole.seconds:
        yield '<p class="fault">no states</p>'
        return
    yield from _numbers(whole)
    for key, what, unit in _QUANTITIES:
        yield distribution(f'{name}: {what} in {_recordings(len(robots))}', f'{what} [{unit}]',
                           EDGES, np.array(getattr(whole, key)))
    yield '<table><tr><th>recording</th><th>states</th><th>99 % of the time below</th>' \
          '<th>largest</th><th>near singular</th><th>hard stops</th></tr>'
    for outcome, robot in robots:
        found = robot.summary
        if found is not None:
            yield (f'<tr><td>{escape(outcome.name)}</td><td>{robot.states:,}</td>'
                   f'<td>{found.quantile("acceleration", 0.99):.3g} m/s²</td>'
                   f'<td>{found.peaks["acceleration"][0]:.3g} m/s²</td>'
                   f'<td>{_share(found)}</td><td>{len(found.stops)}</td></tr>')
    yield '</table>'


def _recording(outcome: Outcome, open_it: bool) -> Iterator[str]:
    yield (f'<details{" open" if open_it else ""}><summary>{escape(outcome.name)}</summary>'
           f'<p>{escape(outcome.place)}, {outcome.size / 1e6:.1f} MB</p>')
    for fault in (outcome.error, *outcome.damage, *(robot.error for robot in outcome.robots)):
        if fault:
            yield f'<p class="fault">{escape(fault)}</p>'
    for robot in outcome.robots:
        yield f'<h3>{escape(robot.name)}</h3><p>{_stamps(robot)}</p>'
        found = robot.summary
        if found is None:
            continue
        yield from _numbers(found)
        history = np.array(found.history)
        yield path_views(f'{robot.name}: path of the tip, from above and from the side',
                         np.array(found.path))
        yield curves(f'{robot.name}: largest values of each stretch', 'time [s]', history[:, 0],
                     [('speed [m/s]', history[:, 1]), ('acceleration [m/s²]', history[:, 2])])
        if found.stops:
            stops = ', '.join(f'{_when(at)} ({how:.3g} m/s²)'
                              for at, how in found.stops[:_MOST_STOPS])
            yield f'<p>Hard stops: {stops}{" ..." if len(found.stops) > _MOST_STOPS else ""}</p>'
    yield '</details>'


def _numbers(found: MotionSummary) -> Iterator[str]:
    """Yield the quantiles and peaks as a table, and what is known beside them."""
    yield ('<table><tr><th></th>' + ''.join(f'<th>{100 * share:g} % below</th>'
                                            for share in _SHARES)
           + '<th>largest</th><th>when</th></tr>')
    for key, what, unit in _QUANTITIES:
        largest, at = found.peaks[key]
        cells = ''.join(f'<td>{found.quantile(key, share):.3g}</td>' for share in _SHARES)
        yield (f'<tr><td>{what} [{unit}]</td>{cells}<td>{largest:.3g}</td>'
               f'<td>{_when(at)}</td></tr>')
    low, high = found.low, found.high
    box = ', '.join(f'{axis} {low[i]:.3f} to {high[i]:.3f}' for i, axis in enumerate('xyz'))
    yield (f'</table><p>{found.seconds:,.1f} s; near a singularity {_share(found)} of the time; '
           f'workspace {box} m; {len(found.stops)} hard stops</p>')


def _recordings(count: int) -> str:
    return f'{count} recording' + ('s' if count != 1 else '')


def _share(found: MotionSummary) -> str:
    if np.isnan(found.near_singular):
        return '?'
    share = 100 * found.near_singular / max(found.seconds, 1e-9)
    return f'{share:.0f} %' if share >= 10 else f'{share:.2g} %'


def _stamps(robot: RobotOutcome) -> str:
    parts = [f'{robot.received:,} joint samples, {robot.states:,} states']
    if robot.period > 0:
        parts.append(f'{1 / robot.period:.1f} Hz, longest pause {robot.longest_pause:.3f} s')
    if robot.accuracy > 0:
        parts.append(f"the joints' accelerations are expected to be right to {robot.accuracy:.2g} "
                     f'of {robot.signal:.2g} rad/s² (RMS)')
    parts += map(escape, robot.findings)
    faults = ', '.join(f'{count} {escape(reason)}' for reason, count in robot.refused.items())
    return '; '.join(parts) + (f'; <span class="fault">not used: {faults}</span>' if faults
                               else '')


def _when(stamp: int) -> str:
    time = datetime.fromtimestamp(stamp // 10**9, timezone.utc)
    return f'{time:%Y-%m-%d %H:%M:%S}.{stamp // 10**6 % 1000:03d}'
