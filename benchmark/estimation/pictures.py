# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of the comparison."""

from __future__ import annotations

from pathlib import Path

from benchmark.estimation.candidates import run_online, run_usual, SMOOTHER, USUAL
from benchmark.estimation.conditions import CONDITIONS, record
import numpy as np


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
        ours = name.startswith('bank')
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
    t, q = recording.ordered[0], recording.ordered[1]
    raw = np.gradient(np.gradient(q[:, 0], t), t)
    figure, axes = plt.subplots(figsize=(8, 3.4))
    low, high = 1.0, 2.6
    shown = (t > low) & (t < high)
    axes.plot(t[shown], raw[shown], color='0.85', lw=0.6, label='twice differenced')
    for name, result, colour, width in (
            (USUAL, run_usual(recording, condition), 'tab:orange', 1.0),
            ('bank, 0 ms', run_online('bank, 0 ms', recording), 'tab:green', 1.0),
            ('bank, 20 ms', run_online('bank, 20 ms', recording),
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
