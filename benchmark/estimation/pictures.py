# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of the comparison."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from benchmark.estimation.candidates import OURS, run_usual, SMOOTHER, USUAL
from benchmark.estimation.conditions import CONDITIONS
from benchmark.estimation.samples import Result
from benchmark.estimation.simulated import record
import numpy as np

if TYPE_CHECKING:
    from benchmark.estimation.recorded import Recorded

SHOWN = 2.0
"""Seconds of a recording that are drawn: those of the most vigorous motion."""


def draw_pareto(summaries: dict, path: Path) -> None:
    """Draw error against delay."""
    import matplotlib
    matplotlib.use('Agg')
    from matplotlib import pyplot as plt
    figure, axes = plt.subplots(figsize=(6.4, 4))
    lowest: dict[float, float] = {}
    for name, s in sorted(summaries.items(), key=lambda item: item[1]['relative']):
        if name == SMOOTHER:
            axes.axhline(s['relative'], ls='--', lw=1, color='tab:green')
            axes.text(0.5, s['relative'] * 1.05, name, color='tab:green', fontsize=8)
            continue
        if not np.isfinite(s['delay']):
            continue
        ours = name in OURS
        delay = round(1e3 * s['delay'])
        axes.plot(delay, s['relative'], 'o', color='tab:blue' if ours else 'tab:gray')
        # Labels of points close together are pushed apart.
        height = max(s['relative'], lowest.get(delay, 0.0))
        lowest[delay] = height * 1.13
        axes.annotate(name, (delay, height), fontsize=8, xytext=(7, -3),
                      textcoords='offset points')
    axes.set(yscale='log', xlim=(-2, 72), xlabel='delay (ms), stamped honestly',
             ylabel='acceleration error / usual practice')
    axes.grid(alpha=0.3, which='both')
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw_traces(path: Path, seed: int) -> None:
    """Draw measured, estimated and true acceleration of one joint."""
    import matplotlib
    matplotlib.use('Agg')
    from matplotlib import pyplot as plt
    condition = CONDITIONS['500 Hz, coarse']
    recording = record('trapezoidal acceleration', condition, seed)
    t, q = recording.ordered.stamps, recording.ordered.positions
    speed = np.gradient(q[:, 0], t)
    raw = np.gradient(speed, t)
    figure, axes = plt.subplots(figsize=(8, 3.4))
    low, high = 1.0, 2.6
    shown = (t > low) & (t < high)
    axes.plot(t[shown], raw[shown], color='0.85', lw=0.6, label='twice differenced')
    for name, result, colour, width in (
            (USUAL, run_usual(recording.ordered), 'tab:orange', 1.0),
            ('bank, 0 ms', OURS['bank, 0 ms'].run(recording.arrived, None), 'tab:green', 1.0),
            ('bank, 20 ms', OURS['bank, 20 ms'].run(recording.arrived, None),
             'tab:blue', 1.4)):
        part = (result.t > low) & (result.t < high)
        axes.plot(result.t[part], result.acceleration[part, 0], label=name,
                  color=colour, lw=width)
    truth = recording.truth(t[shown])[2][:, 0]
    axes.plot(t[shown], truth, 'k--', lw=1, label='truth')
    span = np.abs(truth).max()
    axes.set(ylim=(-1.8 * span, 1.8 * span), xlabel='stamp of the estimate (s)',
             ylabel='acceleration (rad/s$^2$)', xlim=(low, high))
    axes.legend(fontsize=8, ncol=3, loc='lower left')
    figure.tight_layout()
    figure.savefig(path, dpi=100)
    plt.close(figure)


def draw_recording(arm: Recorded, results: dict[str, Result], rows: dict[str, dict],
                   path: Path) -> None:
    """Draw the joint that accelerates most, as estimated and as it was, and all scores."""
    import matplotlib
    matplotlib.use('Agg')
    from matplotlib import pyplot as plt
    joint = int(arm.joints[np.argmax(arm.signal[arm.joints])])
    t = arm.samples.stamps[arm.samples.increasing()]
    true = arm.reference.at(t, 2)[:, joint]
    vigour = np.cumsum(np.nan_to_num(true)**2)
    end = np.minimum(np.searchsorted(t, t + SHOWN), len(t) - 1)
    low = float(t[np.argmax(vigour[end] - vigour)])
    figure, (axes, bars) = plt.subplots(2, 1, figsize=(9, 4 + 0.3 * len(rows)), height_ratios=(
        3.2, 0.8 + 0.3 * len(rows)))
    for name, style in ((USUAL, {'color': 'tab:orange', 'lw': 0.8}),
                        ('bank, 0 ms', {'color': 'tab:green', 'lw': 1.0}),
                        ('bank, 20 ms', {'color': 'tab:blue', 'lw': 1.4})):
        if name in results:
            part = (results[name].t > low) & (results[name].t < low + SHOWN)
            axes.plot(results[name].t[part], results[name].acceleration[part, joint],
                      label=name, **style)
    part = (t > low) & (t < low + SHOWN)
    axes.plot(t[part], true[part], 'k--', lw=1, label='reference')
    span = np.nanmax(np.abs(true[part]))
    axes.set(xlim=(low, low + SHOWN), ylim=(-2.0 * span, 2.0 * span),
             xlabel='stamp of the estimate (s)', ylabel=f'{arm.names[joint]} (rad/s$^2$)')
    axes.legend(fontsize=8, ncol=4, loc='lower left')
    names = sorted(rows, key=lambda name: -rows[name]['score'])
    bars.barh(names, [rows[name]['score'] for name in names],
              color=['tab:blue' if name in OURS else 'tab:gray' for name in names])
    bars.set(xscale='log', xlabel='RMS error of the accelerations over that of usual practice')
    bars.tick_params(axis='y', labelsize=8)
    bars.grid(alpha=0.3, axis='x', which='both')
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)
