# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Equations of parallel robots as text and LaTeX."""
from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations
from typing import Any

import numpy as np

from .layout import LaTeX, Text
from .request import near_notes, printable, Request
from ...errors import ParameterError, ToolError

_FIELDS = (('w', 'v'), ('alpha', 'A'), ('rho', 'J'))
_ORDERS = {'screws': 0, 'jacobian': 1, 'twist': 1, 'coriolis_lie': 2, 'accel': 2,
           'reduced_accel': 2, 'jerk': 3, 'reduced_jerk': 3}


def parallel_files(robot: Any, request: Request) -> dict[str, str]:
    """
    Return a parallel robot's screws, wrenches, and equations of velocity to jerk.

    A state's reduced and classical forms ask for the same equations, which are of the
    reduced one; the Jacobian is in those of the velocity.
    """
    from ...symbolic.parallel import ParallelFormulas
    for quantity in request.quantities:
        if quantity.name not in _ORDERS:
            raise ToolError(f'{robot.name}: {quantity.name}: for parallel robots there are '
                            + ', '.join(_ORDERS))
    for option, default in (('axes', 'base'), ('pole', 'tip')):
        if getattr(request, option) != default:
            raise ParameterError(option, getattr(request, option),
                                 f'{default!r} for parallel robots')
    order = max(_ORDERS[quantity.name] for quantity in request.quantities)
    write: Text = Text() if request.language == 'text' else LaTeX()
    formulas = ParallelFormulas(robot, request.tolerance)
    notes = near_notes(robot.limbs, request.tolerance)
    blocks = [write.comment([*_heading(robot, formulas, request.title, order), *notes])]
    for limb in formulas.limbs:
        blocks += ['', write.comment([f'{limb.name}: unit screws [w; v] about p'])]
        blocks.append(write.rows(
            (write.named('$', f'_{k}'), write.vector(screw), joint) for k, (joint, screw)
            in enumerate(zip(limb.joints, limb.screws), start=1)))
        if order > 1:
            pairs = [write.bracket(write.named('$', f'_{i + 1}'), write.named('$', f'_{j + 1}'),
                                   limb.rates[0][i] * limb.rates[0][j])
                     for i, j in combinations(range(len(limb.joints)), 2)]
            blocks.append(write.rows([(write.named('L', ''), ' + '.join(pairs) or '0', '')]))
        if order > 2:
            blocks.append(write.rows(_jerk_terms(write, limb)))
        for wrench in limb.wrenches if order else ():
            what = 'constraint' if wrench.constraint else 'actuation'
            blocks += ['', write.comment([f'{limb.name}, {what}: {wrench.meaning}'])]
            rows = []
            if wrench.along is not None:
                rows = [(write.named('d', ''), write.vector(wrench.along), ''),
                        (write.vector(wrench.unit), write.direction, '')]
            rows.append((write.named('W', ''), write.vector(wrench.screw), '[force; moment]'))
            rows += [(*row, '') for row in _equations(write, formulas, wrench, order)]
            blocks.append(write.rows(rows))
    return {write.ending: '\n'.join(blocks) + '\n'}


def _heading(robot: Any, formulas: Any, name: str, order: int) -> list[str]:
    """Return lines that say what the symbols are."""
    angles = [f'theta{k} = {joint}' for k, joint in enumerate(robot.passive_joint_names, 1)]
    rows = [
        f'{name}: motion of {robot.tip_frame} relative to {robot.base_frame}; '
        f'mobility {robot.mobility}',
        f'axes of {robot.base_frame}; p is the origin of {robot.tip_frame}, the reference point',
        'rotation matrix of the platform, by rows: '
        + ', '.join(map(str, formulas.rotation.ravel())),
        'actuated: ' + ', '.join(f'q{k} = {j}' for k, j in enumerate(robot.joint_names, 1)),
        'passive: ' + ', '.join(angles),
        'qd, qdd, thetad: time derivatives; rad, m, s',
        'twist [w; v]: what is not named is always zero']
    if order > 1:
        rows.append('reduced acceleration [alpha; A]: A = a - w x v with the classical a')
        rows.append('L: Lie products of the screws times the rates of their joints, {W; L} is '
                    'the Klein form')
    if order > 2:
        rows.append('reduced jerk [rho; J]: J = j - 2 alpha x v - w x a with the classical j, a')
        rows.append('V1, A1, ...: twist and reduced acceleration of the links of a limb')
    return [printable(row) for row in rows]


def _jerk_terms(write: Text, limb: Any) -> Iterable[tuple[str, str, str]]:
    """Give twists and accelerations of the links, and K, the limb's jerk without q'''."""
    speeds, slopes = limb.rates
    terms = []
    for k, (u, a) in enumerate(zip(speeds, slopes), start=1):
        screw = write.named('$', f'_{k}')
        twist, accel = (write.times(x, screw) for x in (u, a))
        if k > 1:
            V, A = write.named('V', f'_{k - 1}'), write.named('A', f'_{k - 1}')    # noqa: N806
            turned = write.bracket(V, screw)
            terms += [write.bracket(V, screw, 2 * a), write.bracket(A, screw, u),
                      write.bracket(V, turned, u)]
            twist = f'{V} + {twist}'
            accel = f'{A} + {accel} + {write.bracket(V, screw, u)}'
        if k < len(speeds):
            yield write.named('V', f'_{k}'), twist, ''
            yield write.named('A', f'_{k}'), accel, ''
    yield write.named('K', ''), ' + '.join(terms) or '0', ''


def _equations(write: Text, formulas: Any, wrench: Any, order: int) -> Iterable[tuple[str, str]]:
    """Give the equations of a wrench: left and right sides."""
    import sympy
    row = np.roll(wrench.screw, 3)
    for n, fields in enumerate(_FIELDS[:order], start=1):
        names = [sympy.Symbol(f'{part}_{axis}') for part in fields for axis in 'xyz']
        left = write.total([(row[k], names[k]) for k in formulas.moving[n - 1]])
        right = write.total([(x, formulas.q[n][k]) for k, x in wrench.work.items()])
        if n > 1:
            product = write.klein % 'LK'[n - 2]
            right = product if not wrench.work else f'{right} + {product}'
        if (left, right) != ('0', '0'):
            yield left, right
