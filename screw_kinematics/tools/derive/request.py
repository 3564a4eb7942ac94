# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What is asked of ``derive``, and the lines that head its answers."""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
import keyword
import re
from typing import Any
import unicodedata

import numpy as np

from ...chains.serial_chain import SerialChain
from ...errors import ParameterError
from ...programs.c_text import KEYWORDS
from ...programs.quantities import Quantity

NEAR_NOTE = ('angles within 1e-9 rad of a multiple of pi/12, and coefficients and lengths as '
             'near to simple ones, are taken as these (--exact: as they are)')
FALLBACK = 'tip_motion'
"""Name of the function where the robot's is no name in code."""


@dataclass(frozen=True)
class Request:
    """What to derive, in the order of the answer, and how to write it."""

    quantities: tuple[Quantity, ...]
    language: str       # text, latex, python or c
    form: str           # closed: one formula a component; straight: named intermediate terms
    title: str          # name of the robot in headings
    function: str       # name of the function in code
    axes: str           # of the vectors: base or tip
    pole: str           # reference point of the linear parts: base or tip
    simplified: bool
    tolerance: float    # as of symbolic.exact_chain

    @property
    def is_code(self) -> bool:
        """Whether it is to be run."""
        return self.language in ('python', 'c')

    @property
    def order(self) -> int:
        """Return the highest derivative of the joint positions."""
        return max(quantity.order for quantity in self.quantities)


def function_name(robot: str, given: str | None) -> str:
    """
    Return the name of the function in code: what was given, or one made of the robot's.

    Examples
    --------
    >>> function_name('panda', None), function_name('Löffel 3', None), function_name('2fg7', None)
    ('panda', 'Loffel_3', 'tip_motion')

    """
    if given is not None:
        if not _is_name(given):
            raise ParameterError(
                'name', given, 'letters, digits and underscores, a letter first, and no word '
                'of Python or C')
        return given
    plain = unicodedata.normalize('NFKD', robot).encode('ascii', 'ignore').decode()
    made = re.sub(r'\W+', '_', plain).strip('_')
    return made if _is_name(made) else FALLBACK


def _is_name(text: str) -> bool:
    return bool(re.fullmatch('[A-Za-z][A-Za-z0-9_]*', text)) and text not in KEYWORDS \
        and not keyword.iskeyword(text)


def heading(robot: Any, request: Request, notes: Sequence[str] = ()) -> list[str]:
    """Return lines that say what is derived: robot, frames, joints, and more where needed."""
    frame = {'base': robot.base_frame, 'tip': robot.tip_frame}
    where = f'origin of {robot.tip_frame}' if request.pole == 'tip' else (
        f'the point of {robot.tip_frame} now at the origin of {robot.base_frame}')
    joints = ', '.join(f'q{i} = {joint}' for i, joint in enumerate(robot.joint_names, 1))
    rows = [f'{request.title}: motion of {robot.tip_frame} relative to {robot.base_frame}',
            f'axes of {frame[request.axes]}; reference point: {where}',
            f'{joints}; qd, qdd, ... their time derivatives; rad, m, s', *notes]
    return [printable(row) for row in rows]


def printable(row: str) -> str:
    """Return a row that may be a comment in source text: names of a file may hold anything."""
    return ''.join(c if c.isprintable() and c not in '"\\*' else '?' for c in row)


def near_notes(chains: Iterable[SerialChain], tolerance: float) -> list[str]:
    """Return what to say if the geometry was changed by more than rounding to make it simple."""
    from ...symbolic.exact import exact_chain
    for chain in chains if tolerance else ():
        taken, exact = exact_chain(chain, tolerance), exact_chain(chain, 0.0)
        pairs = [(taken.T_base_tool, exact.T_base_tool)]
        for a, b in zip(taken.joints, exact.joints):
            pairs += [(a.axis, b.axis), (a.point, b.point)]
        if any(x != y for a, b in pairs for x, y in zip(np.ravel(a), np.ravel(b))):
            return [NEAR_NOTE]
    return []
