# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Print the formulas of a robot's tip motion: as text, LaTeX, Python or C.

Coordinates are q1, q2, ... in the order of the measured joints; qd1, qdd1, ... are their
derivatives. Lengths are in m.
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from . import console, robots
from ..chain import SerialChain
from ..compile import ORDERS
from ..errors import InvalidValueError, ParameterError, UnknownNameError
from ..poles import FRAMES

EXAMPLES = """\
  derive config/robots/rpr.yaml
  derive config/robots/rpr.yaml --outputs reduced_accel,reduced_jerk --format latex
  derive config/robots/puma560.yaml --outputs pose,twist --format c > puma.h
  derive panda.urdf --tip panda_hand_tcp --outputs accel --format python --unsimplified
"""
_FORMATS = ('text', 'latex', 'python', 'c')
_KNOWN = tuple(name for name in ORDERS if name != 'jacobian')


def main(argv: Sequence[str] | None = None) -> int:
    """Run the tool; see ``derive --help``."""
    options = console.parser('derive', __doc__ or '', EXAMPLES)
    robots.add_options(options)
    options.add_argument('--outputs', default='pose,twist,accel', metavar='A,B',
                         help=f'of {", ".join(_KNOWN)} (default: pose,twist,accel)')
    options.add_argument('--format', choices=_FORMATS, default='text',
                         help='default: text')
    options.add_argument('--axes', choices=FRAMES, default='base',
                         help='whose axes six-vectors are in (default: base)')
    options.add_argument('--pole', choices=FRAMES, default='tip',
                         help='which point they refer to (default: tip)')
    options.add_argument('--unsimplified', action='store_true',
                         help='at once; accelerations of six joints take a minute to simplify')
    return console.run(derive, options, argv)


def derive(arguments: argparse.Namespace) -> int:
    """
    Print the formulas.

    Raises
    ------
    InvalidValueError
        The robot is no open chain.
    ParameterError, UnknownNameError
        An output is unknown, or none is asked for.

    """
    from .. import formulas, symbolic
    names = [name.strip() for name in arguments.outputs.split(',') if name.strip()]
    if not names:
        raise ParameterError('outputs', arguments.outputs, f'some of {", ".join(_KNOWN)}')
    for name in names:
        if name not in _KNOWN:
            raise UnknownNameError('output', name, _KNOWN)
    chain = robots.load(arguments)
    if not isinstance(chain, SerialChain):
        raise InvalidValueError(f'{arguments.robot}: closed loops have no formulas here; '
                                'give an open chain')
    order = max(ORDERS[name] for name in names)
    coordinates = symbolic.coordinates(chain.dof, order)
    state = symbolic.state(chain, order, simplified=False)
    state = state.about(arguments.pole).expressed_in(arguments.axes)
    found = {name: _output(state, name) for name in names}
    if not arguments.unsimplified:
        found = {name: symbolic.simplify(x, coordinates[1:]) for name, x in found.items()}
    if arguments.format == 'text':
        print('\n'.join(_text(found)))
    elif arguments.format == 'latex':
        for name, value in found.items():
            print(f'% {name}\n{formulas.latex(value)}')
    else:
        printer = formulas.c_source if arguments.format == 'c' else formulas.python_source
        print(printer('tip_motion', found, coordinates), end='')
    return console.OK


def _output(state: Any, name: str) -> Any:
    if name == 'pose':
        return state.pose[:3]
    if name.startswith('reduced_'):
        return state.reduced[ORDERS[name] - 1]
    return state.classical(ORDERS[name])


def _text(found: dict[str, Any]) -> list[str]:
    parts = {'pose': [f'{row}{column}' for row in ('x', 'y', 'z') for column in
                      (' of x axis', ' of y axis', ' of z axis', ' of origin')]}
    angular_and_linear = [f'{kind} {axis}' for kind in ('angular', 'linear') for axis in 'xyz']
    return [f'{name}, {part}: {value}' for name, array in found.items()
            for part, value in zip(parts.get(name, angular_and_linear), array.ravel())]
