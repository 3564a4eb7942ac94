# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A payload that was found: how well, what would tell more, and as parameters of the node."""
from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import floor, log10
from typing import NamedTuple

import numpy as np

from ..check.findings import FACT, Finding, PROBLEM, REMARK
from ...pipeline.payload import is_inertia
from ...pipeline.settings import RobotSettings
from ...recordings.clock_offset import ClockOffset
from ...recordings.payload_fit import nearest_body, PayloadFit
from ...screws.se3 import Array

_MASS = 0.01            # standard deviation that calls for more motion: share of the mass
_CENTER = 1e-3          # of the centre [m]
_INERTIA = 0.1          # share of a typical moment of inertia
_TYPICAL_RADIUS = 0.05  # of gyration about the centre, beyond its own distance [m]
_UNEXPLAINED = 0.3      # share of what weight alone leaves that a payload should not leave
_HEAVY = 0.05           # and share of the weight
_FREE_FALL = 9.81       # m/s^2
_CONTACT = 0.01         # share of the wrenches


class Identified(NamedTuple):
    """A payload that was found for a robot, on a topic, in a link; and the clocks, if apart."""

    robot: RobotSettings
    topic: str
    link: str
    fit: PayloadFit
    clock: ClockOffset | None


def report(found: Identified) -> Iterator[Finding]:
    """Yield how well it is known, and what would tell more."""
    fit, topic = found.fit, found.topic
    (force, torque), (before, turning) = fit.rms(fit.left), fit.rms(fit.unloaded)
    seconds = float(fit.stamps[-1] - fit.stamps[0]) * 1e-9
    yield Finding(FACT, f'{topic} in {found.link}: {fit.used.sum()} wrenches of {seconds:.1f} s; '
                        f'left are {force:.3g} N and {torque:.3g} N m; with the weight alone '
                        f'taken off {before:.3g} N and {turning:.3g} N m')
    if found.clock is not None:
        yield Finding(REMARK, f'{topic}: {found.clock.told()}; stamp_offset below makes up for it')
    if force > max(_UNEXPLAINED * before, _HEAVY * fit.payload.mass * _FREE_FALL):
        yield Finding(PROBLEM, f'{topic}: no rigid payload explains {100 * force / before:.0f} % '
                      'of what weight alone leaves: contact, a cable, or another link',
                      'move freely; name the link by --frame')
    left_out = 1 - float(fit.used.mean())
    if left_out > _CONTACT:
        yield Finding(REMARK, f'{topic}: {100 * left_out:.1f} % of the wrenches were left '
                      'out, as if there was contact')
    if not _tells_inertia(fit):
        yield Finding(REMARK, 'the motion tells nothing of the inertia: none is taken')
    elif not is_inertia(fit.payload.inertia):
        yield Finding(REMARK, "the inertia found is no body's; the nearest one is taken")
    yield from _more_motion(fit)


def _more_motion(fit: PayloadFit) -> Iterator[Finding]:
    """Yield which parameters are hardly known, and the motion that would tell them."""
    mass, deviations = fit.payload.mass, fit.deviations
    if deviations[0] > _MASS * mass:
        yield Finding(REMARK, f'mass is known to {deviations[0]:.2g} kg only',
                      'turn the sensor so that its other axes point down, one after the other')
    weak = [axis for axis, s in zip('xyz', deviations[1:4]) if s > _CENTER]
    if weak:
        yield Finding(REMARK, f'centre is known to {1e3 * deviations[1:4].max():.2g} mm only, '
                      f'along {", ".join(weak)}',
                      f'tilt the sensor so that gravity acts across its axis {", ".join(weak)}')
    typical = _typical_inertia(fit)
    for axis, k, swing in zip('xyz', _DIAGONAL, np.sqrt(np.diag(fit.turning))):
        if deviations[4 + k] > _INERTIA * typical:
            yield Finding(REMARK, f'moment of inertia about {axis} is known to '
                          f'{deviations[4 + k]:.2g} kg m^2 only, from {swing:.2g} rad/s^2',
                          f'turn to and fro about the {axis} axis of the sensor, faster')


def _typical_inertia(fit: PayloadFit) -> float:
    """Return a moment of inertia about the centre that such a body may have [kg m^2]."""
    return fit.payload.mass * (float(np.linalg.norm(fit.payload.center)) + _TYPICAL_RADIUS)**2


def _tells_inertia(fit: PayloadFit) -> bool:
    return bool(all(fit.deviations[4 + k] < _typical_inertia(fit) for k in _DIAGONAL))


def as_yaml(found: Identified, findings: Sequence[Finding]) -> str:
    """Return a file of parameters for the node, with all findings as comments."""
    fit, robot = found.fit, found.robot
    lines = []
    for finding in findings:
        lines.append(f'# {finding.level}: {finding.what}')
        if finding.advice:
            lines.append(f'#   -> {finding.advice}')
    s = fit.deviations
    name, _, tip = robot.name.partition('.')
    deep = '      ' if tip else '    '
    lines += ['kinematic_state_publisher:', '  ros__parameters:', f'    {name}:',
              *([f'      {tip}:'] if tip else [])]
    lines += [deep + '  ' + line for line in (
        f'wrench_topic: {found.topic}',
        f'wrench_frame: {found.link}',
        f'wrench_by: {"load" if fit.sign > 0 else "sensor"}',
        f'wrench_bias: {_list(fit.bias, s[10:])}',
        f'gravity: {[float(x) for x in robot.gravity]}' if not tip else '',
        'payload:',
        f'  mass: {_list([fit.payload.mass], s[:1], plain=True)}',
        f'  center: {_list(fit.payload.center, s[1:4])}',
        f'  inertia: {_inertia(fit)}') if line]
    if found.clock is not None:
        offset = robot.motion.stamp_offset - found.clock.offset
        lines.append(f'      stamp_offset: {offset:.6f}')
    return '\n'.join(lines) + '\n'


_DIAGONAL = (0, 3, 5)


def _list(values: Sequence[float] | Array, deviations: Array, plain: bool = False) -> str:
    """Return numbers to two digits of their standard deviations, and these as a comment."""
    texts = [f'{value + 0.0:.{places}f}' for value, places in zip(values, _places(deviations))]
    spread = ', '.join(f'{deviation:.1g}' for deviation in deviations)
    return f'{texts[0] if plain else "[" + ", ".join(texts) + "]"}     # +- {spread}'


def _places(deviations: Array) -> list[int]:
    """Return the decimal places that standard deviations leave a meaning."""
    return [min(max(1 - floor(log10(max(s, 1e-12))), 1), 12) for s in deviations]


def _inertia(fit: PayloadFit) -> str:
    """Return the inertia as a list that is, to the digits printed, that of a body."""
    deviations = fit.deviations[4:10]
    if not _tells_inertia(fit):
        return _list([0.0] * 6, deviations)
    body = fit.payload.inertia
    if not is_inertia(body):
        body = nearest_body(body)
    places = _places(deviations)
    while not is_inertia([round(x, p) for x, p in zip(body, places)]) and max(places) < 15:
        places = [p + 1 for p in places]
    texts = ', '.join(f'{x + 0.0:.{p}f}' for x, p in zip(body, places))
    return f'[{texts}]     # +- {", ".join(f"{s:.1g}" for s in deviations)}'
