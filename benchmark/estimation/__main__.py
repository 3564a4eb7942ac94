# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Compare estimators of joint acceleration, on simulated arms and on recordings.

Without options: made-up motions, measured in many ways, against their exact truth. --stamping and
--measuring take drivers and joints that go wrong in place of those, --peers takes the estimators
of other packages and papers in, --recording your own arm.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
import json
from pathlib import Path
import sys

from benchmark.estimation.candidates import (
    BEST_CUTOFF, CANDIDATES, OURS, PEERS, present, SIMPLE, USUAL)
from benchmark.estimation.conditions import ALL, CONDITIONS, MEASURING, STAMPING
from benchmark.estimation.cost import table as cost_table, yardstick
from benchmark.estimation.motions import KINDS, MOVING
from benchmark.estimation.recorded import add_options, compare, prepare, read
from benchmark.estimation.score import evaluate, summary
from benchmark.estimation.tables import by_condition, overview
import numpy as np
from rich.console import Console
from rich.progress import track

from screw_kinematics.errors import ScrewKinematicsError
from screw_kinematics.tools import table_options

EXAMPLES = """examples:
  python -m benchmark.estimation                                     fifteen ways of measuring
  python -m benchmark.estimation --stamping --peers                  ways of stamping, everybody
  python -m benchmark.estimation --conditions '500 Hz, coarse' --motions puma --pictures .
  python -m benchmark.estimation --recording arm.csv --plot arm.png  your own arm
  python -m benchmark.estimation --coverage --stamping               are its intervals honest?
  python -m benchmark.estimation --recording bag/ --topic /arm/joint_states
"""


def options() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(
        prog='python -m benchmark.estimation', description=__doc__, epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    names = [USUAL, *CANDIDATES]
    parser.add_argument('--estimators', nargs='+', choices=names, metavar='NAME',
                        default=[USUAL, BEST_CUTOFF, *SIMPLE, *OURS],
                        help=f'of: {", ".join(names)}')
    parser.add_argument('--peers', action='store_true',
                        help='also those of other packages and papers; some are slow')
    parser.add_argument('--json', type=Path, metavar='FILE', help='file for all scores')
    parser.add_argument('--cost', action='store_true',
                        help='only measure what one update costs, beside numpy.add')
    made = parser.add_argument_group('simulated arms')
    made.add_argument('--seeds', type=int, nargs='+', default=[1])
    made.add_argument('--conditions', nargs='+', choices=list(ALL), metavar='NAME',
                      default=list(CONDITIONS), help=f'of: {", ".join(ALL)}'.replace('%', '%%'))
    for option, conditions in (('stamping', STAMPING), ('measuring', MEASURING)):
        made.add_argument(f'--{option}', action='store_const', dest='conditions',
                          const=list(conditions), help=f'--conditions, all ways of {option}')
    made.add_argument('--motions', nargs='+', choices=KINDS, metavar='NAME',
                      help=f'of: {", ".join(KINDS)}; '
                      'by default all, for --coverage those that move on')
    made.add_argument('--pictures', type=Path, metavar='DIR', help='where to draw pictures')
    made.add_argument('--coverage', action='store_true', help='only show how often the truth lies '
                      'within the intervals that are claimed; with --recording on simulated '
                      'twins of that')
    recorded = parser.add_argument_group(
        'recordings', 'scored against a smooth motion that knows past and future; how far that '
        'can be trusted is found by simulation, and told')
    add_options(recorded)
    recorded.add_argument('--plot', type=Path, metavar='FILE', help='draw what was estimated')
    table_options.add_options(parser)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the comparison; return the exit code."""
    parser = options()
    chosen = parser.parse_args(argv)
    console = Console()
    if not console.is_terminal:
        console = Console(width=160)
    if chosen.plot and not chosen.recording:
        parser.error('--plot draws a --recording; for simulated arms see --pictures')
    if chosen.cost:
        console.print(cost_table())
        return 0
    names, lines = present(dict.fromkeys(
        [*chosen.estimators, *(PEERS if chosen.peers else ())]))
    for line in lines:
        console.print(line)
    try:
        if chosen.coverage:
            _coverage(chosen, console)
        elif chosen.recording:
            compare(chosen, names, console)
        else:
            _simulated(chosen, names, console)
    except (ScrewKinematicsError, OSError) as error:
        print(f'{parser.prog}: {error}', file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    return 0


def _coverage(chosen: argparse.Namespace, console: Console) -> None:
    """Show how often the truth lies within the intervals that are claimed."""
    from benchmark.estimation import coverage
    deviations: Callable[[str, float], coverage.Deviations]
    if chosen.recording:
        with console.status('reference'):
            arm = prepare(*read(chosen), chosen.cutoff)
        names = [f'twin {seed} of {Path(chosen.recording).name}' for seed in chosen.seeds]

        def deviations(name: str, delay: float) -> coverage.Deviations:
            seed = chosen.seeds[names.index(name)]
            return coverage.of_twin(arm.ordered, arm.reference, seed, delay)
    else:
        names = chosen.conditions

        def deviations(name: str, delay: float) -> coverage.Deviations:
            return coverage.simulated(name, chosen.seeds, delay, chosen.motions or MOVING)
    console.print(coverage.table([
        (name, [deviations(name, delay) for delay in coverage.DELAYS])
        for name in track(names, 'conditions', console=console)]))


def _simulated(chosen: argparse.Namespace, names: Sequence[str], console: Console) -> None:
    """Compare on simulated arms."""
    tasks = [(seed, name, kind) for seed in chosen.seeds
             for name in chosen.conditions for kind in chosen.motions or KINDS]
    cells = [{'seed': seed, 'condition': name, 'motion': kind,
              'scores': evaluate(kind, name, seed, names)}
             for seed, name, kind in track(tasks, 'recordings', console=console)]
    summaries = {name: summary(cells, name) for name in dict.fromkeys([USUAL, *names])}
    add = float(np.median([yardstick(2000) for _ in range(7)]))
    console.print(overview(summaries, add))
    console.print(f'{len(cells)} recordings of 7 joints, seeds {chosen.seeds}; '
                  f'np.add of two 7-vectors: {add:.2f} us')
    for table in by_condition(summaries, chosen.conditions):
        console.print(table)
    if chosen.json:
        chosen.json.write_text(json.dumps(
            {'seeds': chosen.seeds, 'np_add_us': add, 'summary': summaries, 'cells': cells},
            indent=1))
    if chosen.pictures:
        from benchmark.estimation.pictures import draw_pareto, draw_traces
        chosen.pictures.mkdir(parents=True, exist_ok=True)
        draw_pareto(summaries, chosen.pictures / 'error_against_delay.png')
        draw_traces(chosen.pictures / 'traces.png', chosen.seeds[0])


if __name__ == '__main__':
    sys.exit(main())
