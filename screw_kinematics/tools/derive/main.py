# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Derive the kinematics of a robot: formulas to read, or programs to run.

Text and LaTeX give the closed form; Python and C the straight-line program, in which every
value is computed once, or with --form closed the closed form. Of parallel robots: screws of
the limbs, wrenches, and the equations of velocity and acceleration they make, as text and LaTeX.
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
import re
import sys
from typing import Any

from .closed_form import closed_form, closed_source
from .parallel import parallel_form
from .straight_line import straight_line_files
from .. import console, robot_options
from ...errors import ParameterError
from ...parallel import ParallelManipulator
from ...programs.quantities import find_quantity, NAMES
from ...screws.reference import FRAMES

EXAMPLES = """\
  derive config/robots/rpr.yaml --quantity acceleration
  derive config/robots/rpr.yaml --quantity velocity,acceleration --format latex
  derive config/robots/puma560.yaml --quantity twist,accel --format python
  derive config/robots/panda.yaml --quantity pose,twist,accel --format c --output panda.c
  derive config/robots/panda.yaml --quantity twist --axes tip --form straight
  derive config/robots/stewart_6ups.yaml --quantity velocity
"""
FORMATS = ('text', 'latex', 'python', 'c')
# Longer arms are simplified for minutes, to formulas that are still too long to read.
_SIMPLIFIED_JOINTS = 4


def main(argv: Sequence[str] | None = None) -> int:
    """Run the tool; see ``derive --help``."""
    options = console.parser('derive', __doc__ or '', EXAMPLES)
    robot_options.add_options(options)
    options.add_argument('--quantity', default='accel', metavar='A,B',
                         help=f'of {", ".join(NAMES)}; or velocity, acceleration, jounce '
                              '(default: accel)')
    options.add_argument('--format', choices=FORMATS, default='text', help='default: text')
    options.add_argument('--form', choices=('closed', 'straight'),
                         help='closed form or straight-line program (default: closed for '
                              'text and LaTeX, straight for Python and C)')
    options.add_argument('--axes', choices=FRAMES, default='base',
                         help='axes of the vectors (default: base)')
    options.add_argument('--pole', choices=FRAMES, default='tip',
                         help='reference point: origin of the tip frame (default), or the '
                              'point of the tip body now at the origin of the base frame')
    options.add_argument('--simplify', action=argparse.BooleanOptionalAction,
                         help='simplify the closed form (default: up to '
                              f'{_SIMPLIFIED_JOINTS} joints)')
    options.add_argument('--name', help='of the function (default: that of the robot)')
    options.add_argument('--output', type=Path, metavar='FILE',
                         help='write here; C: also the header beside it')
    return console.run(_derive, options, argv)


def _derive(arguments: argparse.Namespace) -> int:
    robot = robot_options.load(arguments)
    quantities = [find_quantity(name.strip()) for name in arguments.quantity.split(',')]
    name = arguments.name or re.sub(r'\W', '_', robot.name) or 'robot'
    if not name.isidentifier() or not name.isascii():
        raise ParameterError('name', name, 'letters, digits and underscores')
    code = arguments.format in ('python', 'c')
    form = arguments.form or ('straight' if code else 'closed')
    if form == 'straight':
        if arguments.format == 'latex':
            raise ParameterError('form', form, "'closed' for LaTeX")
        files = straight_line_files(robot, quantities, arguments.format, name, arguments.axes,
                                    arguments.pole)
    elif isinstance(robot, ParallelManipulator) and not code:
        for option in ('axes', 'pole'):
            default = {'axes': 'base', 'pole': 'tip'}[option]
            if getattr(arguments, option) != default:
                raise ParameterError(option, getattr(arguments, option),
                                     f'{default!r} for parallel robots')
        files = parallel_form(robot, quantities, arguments.format, name)
    else:
        simplified = robot.dof <= _SIMPLIFIED_JOINTS if arguments.simplify is None \
            else arguments.simplify
        make: Any = closed_source if code else closed_form
        files = make(robot, quantities, arguments.format, name, arguments.axes,
                     arguments.pole, simplified)
    _write(files, arguments.output)
    return console.OK


def _write(files: dict[str, str], output: Path | None) -> None:
    """Write texts, by the ending of their files, or print them."""
    if output is None:
        sys.stdout.write('\n'.join(files.values()))
        return
    main_file, *others = files.items()
    output.write_text(main_file[1])
    for ending, text in others:
        output.with_suffix(ending).write_text(text)


if __name__ == '__main__':
    raise SystemExit(main())
