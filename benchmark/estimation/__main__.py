# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Compare estimators of joint acceleration: python -m benchmark.estimation --help."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from benchmark.estimation.candidates import (
    BEST_CUTOFF, CUTOFFS, ONLINE, run_online, run_smoother, run_usual, SMOOTHER, USUAL)
from benchmark.estimation.conditions import CONDITIONS, record, STAMPING
from benchmark.estimation.cost import table as cost_table, yardstick
from benchmark.estimation.motions import KINDS
from benchmark.estimation.score import score, summary
import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table


def evaluate(kind: str, name: str, seed: int, candidates: list[str]) -> dict[str, dict]:
    """Return the scores of the candidates on one recording."""
    condition = (CONDITIONS | STAMPING)[name]
    recording = record(kind, condition, seed)
    scores = {USUAL: score(recording, run_usual(recording, condition))}
    for candidate in candidates:
        if candidate == BEST_CUTOFF:
            tried = [score(recording, run_usual(recording, condition, c)) for c in CUTOFFS]
            scores[candidate] = min(tried, key=lambda s: s['acceleration'])
        elif candidate == SMOOTHER:
            scores[candidate] = score(recording, run_smoother(recording))
        elif candidate != USUAL:
            scores[candidate] = score(recording, run_online(candidate, recording))
    return scores


def table(summaries: dict[str, dict], add: float) -> Table:
    """Return the summary as a table."""
    shown = Table(title='RMS error at the claimed stamp, relative to usual practice '
                        '(geometric mean over moving cells)')
    for heading in ('estimator', 'acceleration', 'worst cell', 'velocity', 'standstill rad/s²',
                    'overshoot', 'settling ms', 'delay ms', 'cost us', 'cost / np.add'):
        shown.add_column(heading, justify='left' if heading == 'estimator' else 'right')
    for name, s in summaries.items():
        shown.add_row(
            name, f"{s['relative']:.3f}", f"{s['worst']:.2f}", f"{s['velocity']:.3f}",
            f"{s['standstill']:.4f}", f"{s['overshoot']:.2f}", f"{1e3 * s['settling']:.0f}",
            f"{1e3 * s['delay']:.0f}", f"{s['cost']:.0f}", f"{s['cost'] / add:.0f}")
    return shown


def main() -> None:
    """Run the comparison."""
    parser = argparse.ArgumentParser(description=__doc__)
    names = [USUAL, BEST_CUTOFF, *ONLINE, SMOOTHER]
    parser.add_argument('--seeds', type=int, nargs='+', default=[1])
    known = CONDITIONS | STAMPING
    parser.add_argument('--conditions', nargs='+', choices=list(known), metavar='NAME',
                        default=list(CONDITIONS), help=f'of: {", ".join(known)}')
    parser.add_argument('--stamping', action='store_const', dest='conditions',
                        const=list(STAMPING), help='ways of stamping that tell little of when '
                        'a joint was read, in place of the usual conditions')
    parser.add_argument('--motions', nargs='+', choices=KINDS, metavar='NAME',
                        default=list(KINDS), help=f'of: {", ".join(KINDS)}')
    parser.add_argument('--estimators', nargs='+', choices=names, metavar='NAME',
                        default=names, help=f'of: {", ".join(names)}')
    parser.add_argument('--json', type=Path, help='file for all scores')
    parser.add_argument('--pictures', type=Path, metavar='DIR', help='where to draw pictures')
    parser.add_argument('--cost', action='store_true',
                        help='only measure what one update costs, beside numpy.add')
    options = parser.parse_args()
    if options.cost:
        Console(width=100).print(cost_table())
        return
    tasks = [(seed, name, kind) for seed in options.seeds
             for name in options.conditions for kind in options.motions]
    cells = []
    for seed, name, kind in track(tasks, 'recordings'):
        cells.append({'seed': seed, 'condition': name, 'motion': kind,
                      'scores': evaluate(kind, name, seed, options.estimators)})
    chosen = dict.fromkeys([USUAL, *options.estimators])
    summaries = {name: summary(cells, name) for name in chosen}
    add = float(np.median([yardstick(2000) for _ in range(7)]))
    console = Console()
    if not console.is_terminal:
        console = Console(width=150)
    console.print(table(summaries, add))
    console.print(f'{len(cells)} recordings of 7 joints, seeds {options.seeds}; '
                  f'np.add of two 7-vectors: {add:.2f} us')
    by_condition = Table(title='acceleration error relative to usual practice, by condition')
    for heading in ('estimator', *options.conditions):
        by_condition.add_column(heading, justify='left' if heading == 'estimator' else 'right')
    for name, s in summaries.items():
        by_condition.add_row(name, *(
            f"{s['conditions'].get(c, np.nan):.3g}" for c in options.conditions))
    console.print(by_condition)
    if options.json:
        options.json.write_text(json.dumps(
            {'seeds': options.seeds, 'np_add_us': add, 'summary': summaries, 'cells': cells},
            indent=1))
    if options.pictures:
        from benchmark.estimation.pictures import draw_pareto, draw_traces
        options.pictures.mkdir(parents=True, exist_ok=True)
        draw_pareto(summaries, options.pictures / 'error_against_delay.png')
        draw_traces(options.pictures / 'traces.png', options.seeds[0])


if __name__ == '__main__':
    main()
