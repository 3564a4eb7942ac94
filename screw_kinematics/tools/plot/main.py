# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Draw states over time, the paper's Figure 11, joint screws in space, and axodes."""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .axodes import draw_axodes
from .figure11 import draw_figure11
from .histories import check_ending, draw_history, ENDINGS, motion_history, pyplot
from .space import draw_space
from .. import console, robot_options
from ..reference_motions import MOTIONS
from ...errors import ParameterError, ShapeError
from ...recordings.history import History, QUANTITIES
from ...recordings.recorded_states import read_bag_histories
from ...recordings.tables import ENDINGS as TABLES, read_history
from ...screws.se3 import Array

EXAMPLES = """\
  plot figure11 --output figure11.svg
  plot motion config/robots/puma560.yaml --quantities twist,accel,jerk
  plot motion panda.urdf --tip panda_hand_tcp --motion minjerk --output panda.png
  plot recorded states.parquet --quantities accel --from 2 --to 4
  plot recorded states --quantities twist       the bag that the tool bag writes
  plot recorded causal.csv smoothed.csv --quantities accel --output compared.pdf
  plot screws config/robots/puma560.yaml --output screws.png
  plot screws config/robots/rpr.yaml --q 0.5,0.3,-0.2 --qd 1,0.1,0.5
  plot axodes config/robots/puma560.yaml --output axodes.png
"""

LONGEST = 86_400.0
"""Motion that is drawn [s]."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the tool; see ``plot --help``."""
    options = console.parser('plot', __doc__ or '', EXAMPLES)
    kinds = options.add_subparsers(dest='kind', required=True, metavar='KIND')
    figure11 = kinds.add_parser('figure11', help="the paper's Figure 11, PUMA robot")
    figure11.set_defaults(draw=lambda arguments: draw_figure11())

    motion = kinds.add_parser('motion', help='exact states in a reference motion')
    robot_options.add_options(motion)
    motion.set_defaults(draw=_draw_motion)

    recorded = kinds.add_parser('recorded', help='states out of a bag or a table')
    recorded.add_argument('files', nargs='+', type=Path, metavar='FILE',
                          help='a bag, .csv or .parquet; further ones are drawn over the '
                               'first')
    recorded.add_argument('--from', dest='begin', type=float, metavar='SECONDS', default=0.0,
                          help='begin here (default: 0)')
    recorded.add_argument('--to', dest='end', type=float, metavar='SECONDS',
                          default=float('inf'), help='end here')
    recorded.set_defaults(draw=_draw_recorded)
    for history in (motion, recorded):
        history.add_argument('--quantities', type=_words, default=['twist', 'accel'],
                             metavar='A,B', help=f'any of {", ".join(QUANTITIES)} '
                                                 '(default: twist,accel)')
        history.add_argument('--mm', action='store_true', help='show lengths in mm')

    screws = kinds.add_parser('screws', help='joint screws and instantaneous screw axis')
    robot_options.add_options(screws)
    screws.add_argument('--q', type=_numbers, metavar='A,B',
                        help="posture [rad, m] (default: the paper's motion at t = 1 s)")
    screws.add_argument('--qd', type=_numbers, metavar='A,B',
                        help="joint rates [rad/s, m/s] (default: the paper's motion)")
    screws.set_defaults(draw=_draw_screws)

    surfaces = kinds.add_parser('axodes', help='surfaces that the screw axis of a motion sweeps')
    robot_options.add_options(surfaces)
    surfaces.set_defaults(draw=_draw_axodes)
    for moving in (motion, surfaces):
        moving.add_argument('--motion', choices=MOTIONS, default='paper')
        moving.add_argument('--duration', type=float, default=2 * np.pi, metavar='SECONDS',
                            help='default: 2 pi')
    for kind in (figure11, motion, recorded, screws, surfaces):
        kind.add_argument('--output', type=Path, metavar='FILE',
                          help=f'{", ".join(ENDINGS)} (default: open a window)')
        kind.add_argument('--force', action='store_true', help='overwrite an existing file')
    return console.run(_plot, options, argv)


def _plot(arguments: argparse.Namespace) -> int:
    plt = pyplot()
    output = arguments.output
    if output is not None:
        check_ending(output, 'output')
        console.keep_existing([output], arguments.force)
        plt.switch_backend('agg')
    figure = arguments.draw(arguments)
    if output is not None:
        # Without a date, so that the same states give the same file.
        metadata = {'.svg': {'Date': None}, '.pdf': {'CreationDate': None}}
        output.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(output, dpi=110, metadata=metadata.get(output.suffix.lower()))
    elif plt.get_backend() == 'agg':
        raise ParameterError('output', None, 'a file, as no window can be opened here')
    else:
        plt.show()
    return console.OK


def _draw_motion(arguments: argparse.Namespace) -> Any:
    robot = robot_options.load(arguments)
    time = _time(arguments, 1001)
    history = motion_history(robot, robot_options.motion(robot, arguments.motion), time,
                             arguments.quantities, f'{robot.name}, motion {arguments.motion}')
    return draw_history([history], arguments.mm)


def _draw_recorded(arguments: argparse.Namespace) -> Any:
    histories = [history for file in arguments.files
                 for history in _histories(file, arguments.quantities)]
    start = histories[0].start
    cut = []
    for history in histories:
        # All on the clock of the first.
        time = history.time + (history.start - start) * 1e-9
        kept = (time >= arguments.begin) & (time <= arguments.end)
        if not kept.any():
            raise ParameterError('from, to', (arguments.begin, arguments.end), (
                f'some of the {time[0]:.3f} to {time[-1]:.3f} s of {history.name}'))
        cut.append(History(history.name, history.base_frame, history.tip_frame, time[kept],
                           {key: x[kept] for key, x in history.values.items()}))
    return draw_history(cut, arguments.mm)


def _histories(file: Path, quantities: Sequence[str]) -> list[History]:
    if file.suffix.lower() in TABLES:
        return [read_history(file, quantities)]
    return read_bag_histories(file, quantities)


def _draw_screws(arguments: argparse.Namespace) -> Any:
    robot = robot_options.load(arguments)
    q, qd = robot_options.motion(robot, 'paper').derivatives(1.0, 1)
    given = []
    for name, value, default in (('q', arguments.q, q), ('qd', arguments.qd, qd)):
        value = default if value is None else np.array(value)
        if value.shape != (robot.dof,):
            raise ShapeError(name, f'({robot.dof},), for {", ".join(robot.joint_names)}',
                             value.shape)
        given.append(value)
    return draw_space(robot, *given)


def _draw_axodes(arguments: argparse.Namespace) -> Any:
    robot = robot_options.load(arguments)
    time = _time(arguments, 201)
    return draw_axodes(robot, robot_options.motion(robot, arguments.motion), time)


def _time(arguments: argparse.Namespace, count: int) -> Array:
    """Return instants of a motion [s]."""
    if not 0 < arguments.duration <= LONGEST:
        raise ParameterError('duration', arguments.duration,
                             f'more than 0, at most {LONGEST:g} s')
    return np.linspace(0.0, arguments.duration, count)


def _words(text: str) -> list[str]:
    words = [word for word in text.split(',') if word]
    if not words:
        raise argparse.ArgumentTypeError(f'got {text!r}; allowed: names with commas between')
    return words


def _numbers(text: str) -> list[float]:
    try:
        found = [float(word) for word in text.split(',')]
    except ValueError:
        found = [np.nan]
    if not np.isfinite(found).all():
        raise argparse.ArgumentTypeError(
            f'got {text!r}; allowed: finite numbers with commas between')
    return found
