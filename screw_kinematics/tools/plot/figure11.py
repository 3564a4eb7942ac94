# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The paper's Figure 11: velocity and acceleration states of the PUMA robot."""
from __future__ import annotations

from typing import Any

import numpy as np

from .histories import COLOURS, motion_history, one_legend, pyplot
from ..robot_options import motion, PUMA
from ... import models

_UNITS = ('rad/s', 'mm/s', 'rad/s²', 'mm/s²')
_TITLES = ('angular velocity $\\omega$', 'linear velocity $v$',
           'angular acceleration $\\dot\\omega$',
           'acceleration $a$ (solid), reduced $a - \\omega \\times v$ (dashed)')


def draw_figure11() -> Any:
    """Draw the states of the PUMA robot for 0 <= t <= 2 pi, q_i = 10 deg + A_i sin t."""
    plt = pyplot()
    puma = models.load(PUMA)
    time = np.linspace(0.0, 2.0 * np.pi, 201)
    history = motion_history(puma, motion(puma, 'paper'), time,
                             ('twist', 'accel', 'reduced_accel'))
    twist, accel = history.values['twist'], history.values['accel']
    reduced = history.values['reduced_accel']
    panels = (twist[:, :3], 1e3 * twist[:, 3:], accel[:, :3], 1e3 * accel[:, 3:])
    figure, axes = plt.subplots(2, 2, sharex=True, figsize=(9.0, 5.6), layout='constrained')
    for axis, title, unit, values in zip(axes.flat, _TITLES, _UNITS, panels):
        for component, colour, line in zip('xyz', COLOURS, values.T):
            axis.plot(time, line, color=colour, label=component, linewidth=1.4)
        axis.set_title(title, fontsize=9)
        axis.set_ylabel(f'[{unit}]')
        axis.margins(x=0)
    one_legend(figure, axes[0, 0])
    for colour, line in zip(COLOURS, 1e3 * reduced[:, 3:].T):
        axes[1, 1].plot(time, line, '--', color=colour, linewidth=1.0)
    quarters = np.pi / 2 * np.arange(5)
    for axis in axes[1]:
        axis.set_xlabel('time $t$ [s]')
        axis.set_xticks(quarters, ['0', 'π/2', 'π', '3π/2', '2π'])
    figure.suptitle(
        f'PUMA robot, $q_i = 10° + A_i \\sin t$: motion of {history.tip_frame} relative to '
        f'{history.base_frame}\naxes of {history.base_frame}, reference point: origin of '
        f'{history.tip_frame}', fontsize=10)
    return figure
