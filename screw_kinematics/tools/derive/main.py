# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Derive the kinematics of a robot: formulas to read, or programs to run.

Text and LaTeX give the closed form, or with --form straight named intermediate terms, each
computed once. Python and C give a function, straight-line by default; both forms take and
return the same. Of parallel robots: screws of the limbs, wrenches, and the equations of
velocity, acceleration and jerk they make, as text and LaTeX.
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
import sys

from .parallel import parallel_files
from .request import function_name, Request
from .serial import serial_files
from .. import console, robot_options
from ...errors import ParameterError
from ...parallel import ParallelManipulator
from ...programs.quantities import find_quantity, NAMES
from ...screws.reference import FRAMES

EXAMPLES = """\
  derive config/robots/rpr.yaml --quantity acceleration
  derive config/robots/rpr.yaml --quantity screws,jacobian,coriolis_lie --format latex
  derive config/robots/puma560.yaml --quantity twist,accel --format python
  derive config/robots/panda.yaml --quantity pose,twist,accel --format c --output panda.c
  derive config/robots/panda.yaml --quantity accel --format latex --form straight
  derive config/robots/stewart_6ups.yaml --quantity velocity
"""
FORMATS = ('text', 'latex', 'python', 'c')
# Joints up to which formulas of an order are simplified in seconds: pose, twist, acceleration;
# of higher orders, and of longer arms, in minutes, to formulas that are still too long to read.
_SIMPLIFIED = (7, 7, 6, 4, 4)
_LONG = 100_000     # characters of formulas that nobody reads


def main(argv: Sequence[str] | None = None) -> int:
    """Run the tool; see ``derive --help``."""
    options = console.parser('derive', __doc__ or '', EXAMPLES)
    robot_options.add_options(options)
    options.add_argument('--quantity', default='accel', metavar='A,B',
                         help=f'any of {", ".join(NAMES)}; or velocity, acceleration, jounce '
                              '(default: accel, the classical acceleration)')
    options.add_argument('--format', choices=FORMATS, default='text', help='default: text')
    options.add_argument('--form', choices=('closed', 'straight'),
                         help='closed form, or named terms that are computed once (default: '
                              'closed for text and LaTeX, straight for Python and C)')
    options.add_argument('--axes', choices=FRAMES, default='base',
                         help='axes of the vectors (default: base)')
    options.add_argument('--pole', choices=FRAMES, default='tip',
                         help='reference point: origin of the tip frame (default), or the '
                              'point of the tip body now at the origin of the base frame')
    options.add_argument('--simplify', action=argparse.BooleanOptionalAction,
                         help='simplify the closed form (default: where it takes seconds: twists '
                              'of up to 7 joints, accelerations of up to 6, all up to 4)')
    options.add_argument('--exact', action='store_true',
                         help='keep numbers as they are; by default closed forms take angles '
                              'within 1e-9 rad of a multiple of pi/12 for it, and coefficients '
                              'as close to a simple number for that number')
    options.add_argument('--name', help='name of the function in code, or of the robot in '
                                        "headings (default: the robot's)")
    options.add_argument('--output', type=Path, metavar='FILE',
                         help='file to write; for C also the header beside it')
    options.add_argument('--force', action='store_true', help='overwrite existing files')
    return console.run(_derive, options, argv)


def _derive(arguments: argparse.Namespace) -> int:
    code = arguments.format in ('python', 'c')
    form = arguments.form or ('straight' if code else 'closed')
    _check_output(arguments)
    robot = robot_options.load(arguments, symbolic=not code and form == 'closed')
    quantities = tuple(find_quantity(name.strip()) for name in arguments.quantity.split(','))
    order = max(quantity.order for quantity in quantities)
    request = Request(
        quantities, arguments.format, form, arguments.name or robot.name or 'robot',
        function_name(robot.name, arguments.name if code or form == 'straight' else None),
        arguments.axes, arguments.pole,
        simplified=robot.dof <= _SIMPLIFIED[order] if arguments.simplify is None
        else arguments.simplify, tolerance=0.0 if arguments.exact else 1e-9)
    if isinstance(robot, ParallelManipulator) and not code and form == 'closed':
        files = parallel_files(robot, request)
    else:
        if form == 'closed' and not request.simplified:
            _say(f'closed form of {robot.dof} joints, not simplified: it will be long; '
                 '--form straight gives named terms instead')
        files = serial_files(robot, request)
    if code and request.function != robot.name:
        _say(f'the function is called {request.function}')
    size = len(next(iter(files.values())))
    if not code and size > _LONG:
        _say(f'{size / 1000:.0f} kB; --form straight gives named terms instead')
    _write(files, request.function, arguments.output)
    return console.OK


def _check_output(arguments: argparse.Namespace) -> None:
    output: Path | None = arguments.output
    if output is None:
        return
    if arguments.format == 'c' and output.suffix == '.h':
        raise ParameterError('output', str(output), 'the source, as FILE.c; the header is put '
                             'beside it')
    files = [output, output.with_suffix('.h')] if arguments.format == 'c' else [output]
    # A device is no file that could be lost.
    console.keep_existing(filter(Path.is_file, files), arguments.force)


def _say(text: str) -> None:
    print(f'derive: {text}', file=sys.stderr)


def _write(files: dict[str, str], name: str, output: Path | None) -> None:
    """Write texts, by the ending of their files, or print them; C includes its header."""
    if output is None:
        for k, (ending, text) in enumerate(files.items()):
            mark = f'/* {name}{ending} */\n' if len(files) > 1 else ''
            sys.stdout.write(('\n' if k else '') + mark + text)
        return
    main_file, *others = files.items()
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text(main_file[1].replace(f'#include "{name}.h"',
                                           f'#include "{output.with_suffix(".h").name}"', 1))
    for ending, text in others:
        output.with_suffix(ending).write_text(text)
