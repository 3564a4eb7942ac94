# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A picture of a payload: the wrench as measured, without its weight, and without its inertia."""
from __future__ import annotations

from pathlib import Path

import numpy as np

from .payload import Identified
from ..plot.histories import pyplot

_SHOWN = 4.0    # [s]


def draw_payload(path: Path, found: Identified) -> None:
    """Draw the force and the torque that the weight alone explains least."""
    fit = found.fit
    time = (fit.stamps - fit.stamps[0]) * 1e-9
    begin = max(float(time[-1]) - _SHOWN, 0.0) / 2
    part = (time >= begin) & (time <= begin + _SHOWN)
    plt = pyplot()
    plt.switch_backend('agg')       # into a file, wherever this runs
    figure, both = plt.subplots(2, 1, figsize=(8, 5.5), sharex=True, layout='constrained')
    for axes, first, name in zip(both, (0, 3), ('force, {} [N]', 'torque, {} [N m]')):
        channel = first + int(np.argmax((fit.unloaded[:, first:first + 3]**2).mean(axis=0)))
        for values, label in ((fit.measured, 'measured, less bias'),
                              (fit.unloaded, 'less weight'),
                              (fit.left, 'less weight and inertia')):
            axes.plot(time[part], values[part, channel], label=label, linewidth=0.9)
        axes.set(ylabel=name.format('xyz'[channel - first]))
    both[0].set(title=f'{found.topic}: {fit.payload.mass:.3g} kg at {found.link}')
    both[0].legend(loc='upper right')
    both[1].set(xlabel='time [s]')
    figure.savefig(path, dpi=110)
    plt.close(figure)
