# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The panel beside the scene: playing, legend, what to show, time series, doubts."""
from __future__ import annotations

from collections.abc import Sequence
import math
from typing import Any

import numpy as np

from .motion import ShownMotion, Snapshot
from .scene import QUANTITIES, RobotScene, SCREW, TRAIL_COLOUR, TRUTH, vectors
from ...screws.screw import screw_of_twist

SPAN = 8.0
"""Time that the series show [s]."""
SPEEDS = ('1/10', '1/4', '1', '2', '5')
_COMPONENTS = ('#0072B2', '#D55E00', '#009E73')
_POINTS = 240       # of a series


class Panel:
    """The controls of a page, and what is written on it; live states cannot be wound back."""

    def __init__(self, server: Any, motions: Sequence[ShownMotion], live: bool) -> None:
        gui = self._gui = server.gui
        self._live = live
        gui.configure_theme(control_width='medium', show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()
        gui.set_panel_label('screw_kinematics')
        self.robot = gui.add_dropdown('robot', [motion.name for motion in motions],
                                      visible=len(motions) > 1)
        self._about = gui.add_markdown('')
        end = max(max(motion.end for motion in motions), 1e-2)
        step = 10.0 ** math.ceil(math.log10(end / 2000))
        self.play = gui.add_button('pause', visible=not live)
        self.time = gui.add_slider('time [s]', 0.0, math.ceil(end / step) * step, step, 0.0,
                                   visible=not live)
        self.speed = gui.add_dropdown('speed', SPEEDS, initial_value='1', visible=not live)
        self.playing = True
        self.play.on_click(lambda _: self.set_playing(not self.playing))
        self._legend = gui.add_html('')
        self.factor = gui.add_slider('length of arrows', 0.2, 5.0, 0.1, 1.0)
        with gui.add_folder('show', expand_by_default=False):
            self.shown = {name: gui.add_checkbox(quantity.label, True)
                          for name, quantity in QUANTITIES.items()}
            for name, label in (('screw', 'screw axis'), ('trail', "tip's trail"),
                                ('truth', 'truth, where known'), ('frames', 'frames')):
                self.shown[name] = gui.add_checkbox(label, True)
        self._numbers = gui.add_markdown('')
        self._doubts = gui.add_markdown('')
        gui.add_html('<div style="font-size:0.85em">time series: ' + ', '.join(
            f'<b style="color:{colour}">{axis}</b>' for axis, colour in zip('xyz', _COMPONENTS)
        ) + '; truth dashed, where known</div>')
        self._true = any(s.exact is not None for motion in motions for s in motion.snapshots)
        self._series = {name: self._plot(quantity.label, quantity.unit)
                        for name, quantity in QUANTITIES.items() if name != 'alpha'}

    def set_playing(self, playing: bool) -> None:
        """Play on, or pause."""
        self.playing = playing
        self.play.label = 'pause' if playing else 'play'

    @property
    def pace(self) -> float:
        """Return seconds of the recording per second; 0 while it pauses."""
        over, _, under = self.speed.value.partition('/')
        return float(over) / float(under or 1) if self.playing else 0.0

    def describe(self, motion: ShownMotion, scene: RobotScene, remark: str) -> None:
        """Write what is shown of a robot, and how long its arrows are."""
        base, tip = motion.world or motion.robot.base_frame, motion.robot.tip_frame
        self._about.content = (
            f'**{motion.name}**: motion of `{tip}` relative to `{base}`; axes of `{base}`; '
            f'reference point: origin of `{tip}`' + (f'\n\n{remark}' if remark else ''))
        rows = [_swatch(q.colour, f'{q.label}: {100 * scene.factor * scene.scales[name]:.3g} cm '
                                  f'for 1 {q.unit}') for name, q in QUANTITIES.items()]
        rows += [_swatch(SCREW, 'instantaneous screw axis'), _swatch(TRAIL_COLOUR, "tip's trail")]
        if motion.snapshots and motion.snapshots[-1].exact is not None:
            rows.append(_swatch(TRUTH, 'the truth, thin'))
        if motion.snapshots and motion.snapshots[-1].covariance is not None:
            rows.append(_swatch(QUANTITIES['a'].colour, 'ellipsoid: two standard deviations'))
        self._legend.content = f'<div style="font-size:0.85em">{"".join(rows)}</div>'
        self._doubts.content = '\n'.join(
            ['**doubts**', *(f'- {doubt}' for doubt in motion.doubts)]) if motion.doubts else (
                '**doubts**: none')

    def write(self, motion: ShownMotion, snapshot: Snapshot) -> None:
        """Write the numbers of an instant and draw the time before it."""
        self._numbers.content = _numbers(snapshot)
        window = motion.window(snapshot.time, SPAN)
        if len(window) < 2:
            return
        places = np.linspace(0, len(window) - 1, min(len(window), _POINTS)).round().astype(int)
        chosen = [window[i] for i in places]
        time = np.array([s.time for s in chosen])
        for name, plot in self._series.items():
            found = np.array([vectors(s.twist, s.accel)[name] for s in chosen])
            true = [vectors(*s.exact)[name] for s in chosen if s.exact is not None]
            plot.data = (time, *found.T, *(np.array(true).T if self._true else ()))

    def _plot(self, label: str, unit: str) -> Any:
        from viser import uplot
        series = [uplot.Series(label='t')]
        for prefix, width, dash in (('', 1.5, None), ('true ', 1.0, (4.0, 4.0)))[:1 + self._true]:
            series += [uplot.Series(label=prefix + axis, stroke=colour, width=width,
                                    **({} if dash is None else {'dash': dash}))
                       for axis, colour in zip('xyz', _COMPONENTS)]
        return self._gui.add_uplot(
            (np.array([0.0, 1.0]), *[np.zeros(2)] * (len(series) - 1)), tuple(series),
            title=f'{label} [{unit}]',
            scales={'x': uplot.Scale(time=False), 'y': uplot.Scale(auto=True)}, aspect=2.4,
            legend=uplot.Legend(show=False))


def _swatch(colour: Sequence[int], text: str) -> str:
    r, g, b = colour
    return f'<div><span style="color:rgb({r},{g},{b})">&#9632;</span> {text}</div>'


def _numbers(snapshot: Snapshot) -> str:
    """Return the state of an instant as text."""
    rows = [f'**t = {snapshot.time:.2f} s**', '', '| | x | y | z | |', '|---|---|---|---|---|']
    measured = vectors(snapshot.twist, snapshot.accel)
    for name, quantity in QUANTITIES.items():
        x, y, z = measured[name]
        rows.append(f'| {name} | {x:.3f} | {y:.3f} | {z:.3f} | {quantity.unit} |')
    screw = screw_of_twist(snapshot.twist)
    if screw.amplitude > 1e-9 and not np.isinf(screw.pitch):
        rows += ['', f'screw: {screw.amplitude:.3f} rad/s, pitch {1e3 * screw.pitch:.1f} mm/rad']
    if snapshot.exact is not None:
        off = np.linalg.norm(snapshot.accel[3:] - snapshot.exact[1][3:])
        rows += ['', f'error of a: {off:.4f} m/s²']
    return '\n'.join(rows)
