# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures of time histories: what is drawn, in which units, under which title."""
from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..reference_motions import ReferenceMotion
from ...errors import optional_module, ParameterError, UnknownNameError
from ...programs.quantities import find_quantity, order_of
from ...recordings.history import History, QUANTITIES
from ...screws.rotations import roll_pitch_yaw
from ...screws.se3 import Array

# Blue, vermilion and green that stay apart for colour-blind eyes (Okabe and Ito).
COLOURS = ('#0072B2', '#D55E00', '#009E73')

ENDINGS = ('.png', '.svg', '.pdf')


def pyplot() -> Any:
    """Return matplotlib's pyplot."""
    plt = optional_module('matplotlib.pyplot', 'plot', 'drawing')
    # The same picture on every machine.
    plt.rcParams.update({'svg.hashsalt': 'screw_kinematics',
                         'font.size': 9, 'axes.grid': True, 'grid.alpha': 0.3})
    return plt


def check_ending(path: Path, option: str = 'plot') -> None:
    """Raise ParameterError if a picture cannot be written into this file."""
    if path.suffix.lower() not in ENDINGS:
        raise ParameterError(option, str(path), f'a file ending in {", ".join(ENDINGS)}')


def motion_history(robot: Any, motion: ReferenceMotion, time: Array, quantities: Sequence[str],
                   name: str = '') -> History:
    """Return the exact states of a robot in a reference motion, at instants [s]."""
    for quantity in quantities:
        if quantity not in QUANTITIES:
            raise UnknownNameError('quantity', quantity, QUANTITIES)
    state = robot.state(*motion.derivatives(time, order_of(quantities)))
    values = {quantity: find_quantity(quantity).of(state) for quantity in quantities}
    return History(name or robot.name, robot.base_frame, robot.tip_frame,
                   np.asarray(time, dtype=float), values)


def draw_history(histories: Sequence[History], millimetres: bool = False) -> Any:
    """
    Draw angular and linear parts of each quantity of the first history against time.

    Further ones are drawn over it, dashed, for comparison.
    """
    plt = pyplot()
    first = histories[0]
    figure, axes = plt.subplots(len(first.values), 2, sharex=True, squeeze=False,
                                figsize=(9.0, 0.8 + 2.3 * len(first.values)),
                                layout='constrained')
    for row, quantity in zip(axes, first.values):
        titles, units = _labels(quantity, 'mm' if millimetres else 'm')
        for history, style in zip(histories, ('-', '--', ':')):
            if quantity not in history.values:
                continue
            angular, linear = _parts(quantity, history.values[quantity])
            for part, scale, axis in zip((angular, linear), (1.0, 1e3 if millimetres else 1.0),
                                         row):
                for component, colour, values in zip('xyz', COLOURS, part.T):
                    axis.plot(history.time, scale * values, style, color=colour,
                              label=_label(component, history, histories), linewidth=1.3)
        for axis, title, unit in zip(row, titles, units):
            axis.set_title(title, fontsize=9)
            axis.set_ylabel(f'[{unit}]')
            axis.margins(x=0)
    one_legend(figure, axes[0, 0])
    for axis in axes[-1]:
        axis.set_xlabel('time t [s]')
    figure.suptitle(f'{first.name}: motion of {first.tip_frame} relative to '
                    f'{first.base_frame}\naxes of {first.base_frame}, reference point: '
                    f'origin of {first.tip_frame}', fontsize=10)
    return figure


def one_legend(figure: Any, axis: Any) -> None:
    """Put the legend of one panel, the same for all, below the figure."""
    handles, labels = axis.get_legend_handles_labels()
    figure.legend(handles, labels, loc='outside lower center', ncols=len(handles),
                  fontsize=9, frameon=False)


def _label(component: str, history: History, histories: Sequence[History]) -> str:
    return component if len(histories) == 1 else f'{component} ({history.name})'


def _labels(quantity: str, length: str) -> tuple[tuple[str, str], tuple[str, str]]:
    """Return titles and units of the two panels of a quantity."""
    angular, linear = find_quantity(quantity).parts
    if quantity == 'pose':
        return (linear.title, angular.title), ('deg', length)
    return (angular.title, linear.title), (
        _superscript(angular.unit), _superscript(linear.unit.replace('m', length, 1)))


def _superscript(unit: str) -> str:
    """Return a unit with its power of seconds raised."""
    head, caret, power = unit.partition('^')
    return head + ('⁰¹²³⁴'[int(power)] if caret else '')


def _parts(quantity: str, values: Array) -> tuple[Array, Array]:
    """Return the angular and the linear part, (N, 3) each."""
    if quantity != 'pose':
        return values[:, :3], values[:, 3:]
    angles = np.unwrap(roll_pitch_yaw(values[:, :3, :3]), axis=0)
    return np.degrees(angles), values[:, :3, 3]
