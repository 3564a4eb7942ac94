# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Compare the node with others, in real processes over real DDS.

All contenders are open at once, and take turns: in each round every one of them is kept busy
for a moment and then gets messages at 1 kHz, so that what else the machine does falls on all of
them alike. Then each contender's nodes for several numbers of robots take turns. Figures are
medians over the rounds, with the quartiles in brackets; ratios are formed within a round.
"""
import argparse
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field
import json
import math
from pathlib import Path
import time

import numpy as np
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from .contenders import (
    Contender, FLOOR, NATIVE, native_nodes, OWN, PINOCCHIO, RELAY, SCRIPTED)
from .trial import Latency, Saturation, Trial


@dataclass
class Figures:
    """What a contender showed with one robot; lists have one entry for each round."""

    start_s: float = 0.0
    idle_percent: float = 0.0
    resident_mib: float = 0.0
    saturated: list[Saturation] = field(default_factory=list)
    at_1khz: list[Latency] = field(default_factory=list)


Growth = dict[int, list[float]]
"""CPU time per message [us] in each round, by number of robots."""


def main() -> None:
    """Run the benchmark from the command line."""
    parser = argparse.ArgumentParser(
        prog='python -m benchmark.node', description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--rounds', type=int, default=15)
    parser.add_argument('--seconds', type=float, default=0.5, help='of each turn')
    parser.add_argument('--robots', type=int, nargs='+', default=[1, 4, 16])
    parser.add_argument('--only', nargs='+', metavar='TEXT', default=[''],
                        help='only contenders whose name contains one of these')
    parser.add_argument('--json', type=Path, help='file for all figures of all rounds')
    options = parser.parse_args()
    chosen = [text.casefold() for text in options.only]
    contenders = [c for c in (*SCRIPTED, *native_nodes())
                  if any(text in c.name.casefold() for text in chosen)]
    counts = sorted(set(options.robots))
    # Drawn between turns only: it must not run beside them.
    with Progress(auto_refresh=False) as progress:
        figures = compare(contenders, options.rounds, options.seconds, progress)
        growth = {} if counts == [1] else {
            contender.name: grow(contender, counts, options.rounds, options.seconds, progress)
            for contender in contenders}
    console = Console()
    if not console.is_terminal:
        console.width = 170
    console.print(comparison_table(figures))
    if growth:
        console.print(growth_table(growth, counts))
    if options.json:
        options.json.write_text(json.dumps(
            {'one robot': {name: asdict(f) for name, f in figures.items()},
             'CPU per message by robots': growth}, indent=1))


def compare(contenders: Iterable[Contender], rounds: int, seconds: float,
            progress: Progress) -> dict[str, Figures]:
    """Return the figures of all contenders with one robot."""
    with ExitStack() as stack:
        trials = open_trials([(contender, 1) for contender in contenders], stack, progress)
        figures = {c.name: Figures(start_s=trial.start_s) for (c, _), trial in trials.items()}
        task = progress.add_task('one robot', total=rounds * len(trials))
        for _ in range(rounds):
            for (contender, _), trial in trials.items():
                figures[contender.name].saturated.append(trial.saturate(seconds))
                figures[contender.name].at_1khz.append(trial.at_1khz(seconds))
                progress.advance(task)
                progress.refresh()
        time.sleep(1.0)
        before, begin = [trial.cpu_s for trial in trials.values()], time.perf_counter()
        time.sleep(max(4.0, 4 * seconds))
        after, span = [trial.cpu_s for trial in trials.values()], time.perf_counter() - begin
        for of, trial, used, now in zip(figures.values(), trials.values(), before, after):
            of.idle_percent = (now - used) / span * 100
            of.resident_mib = trial.resident_mib
    return figures


def grow(contender: Contender, counts: Iterable[int], rounds: int, seconds: float,
         progress: Progress) -> Growth:
    """Return what a message costs a contender with each number of robots."""
    with ExitStack() as stack:
        trials = open_trials([(contender, count) for count in counts], stack, progress)
        growth: Growth = {count: [] for count in counts}
        task = progress.add_task(f'robots: {contender.name}', total=rounds * len(trials))
        for _ in range(rounds):
            for (_, count), trial in trials.items():
                growth[count].append(trial.saturate(seconds).cpu_us)
                progress.advance(task)
                progress.refresh()
    return growth


def open_trials(wanted: Sequence[tuple[Contender, int]], stack: ExitStack, progress: Progress,
                ) -> dict[tuple[Contender, int], Trial]:
    """Start nodes, one after the other."""
    task = progress.add_task('', total=len(wanted))
    trials = {}
    for contender, robots in wanted:
        progress.update(task, description=f'start {contender.name}, robots: {robots}')
        progress.refresh()
        trials[contender, robots] = stack.enter_context(Trial(contender, robots))
        progress.advance(task)
    progress.remove_task(task)
    return trials


def spread(values: Iterable[float], digits: int = 0) -> str:
    """Return median and quartiles as text."""
    low, middle, high = (
        f'{v:,.{digits}f}' for v in np.quantile(list(values), (0.25, 0.5, 0.75)).tolist())
    return f'{middle} ({low}-{high})'


def ratios(of: Iterable[float], to: Iterable[float]) -> str:
    """Return the ratios within the rounds as text, but for rounds in which nothing came."""
    rounds = [a / b for a, b in zip(of, to) if 0.0 < a < math.inf and 0.0 < b < math.inf]
    return spread(rounds, 2) if rounds else 'none'


def comparison_table(figures: dict[str, Figures]) -> Table:
    """Return all figures for one robot."""
    table = Table('', *figures, title='one robot: medians (quartiles)')
    relay, pinocchio = figures.get(RELAY), figures.get(PINOCCHIO)
    native, floor, own = figures.get(NATIVE), figures.get(FLOOR), figures.get(OWN)

    def cpu_us(f: Figures) -> list[float]:
        return [s.cpu_us for s in f.saturated]

    def rate(f: Figures) -> list[float]:
        return [s.rate for s in f.saturated]

    def p50_us(f: Figures) -> list[float]:
        return [s.p50_us for s in f.at_1khz]

    def add(heading: str, text: Callable[[Figures], str]) -> None:
        table.add_row(heading, *map(text, figures.values()))

    add('CPU per message, saturated, µs', lambda f: spread(cpu_us(f), 1))
    if pinocchio:
        add('  times less than Pinocchio', lambda f: ratios(cpu_us(pinocchio), cpu_us(f)))
    if native:
        add('  times the C++ node', lambda f: ratios(cpu_us(f), cpu_us(native)))
    if floor:
        add('  times the floor', lambda f: ratios(cpu_us(f), cpu_us(floor)))
    if own:
        add('  times ours', lambda f: ratios(cpu_us(f), cpu_us(own)))
    add('messages/s', lambda f: spread(rate(f)))
    if relay:
        add('  times the relay', lambda f: ratios(rate(f), rate(relay)))
    add('lost', lambda f: str(sum(s.lost for s in f.saturated)))
    add('CPU per message at 1 kHz, µs', lambda f: spread(s.cpu_us for s in f.at_1khz))
    if native:
        add('  times the C++ node', lambda f: ratios(
            [s.cpu_us for s in f.at_1khz], [s.cpu_us for s in native.at_1khz]))
    if own:
        add('  times ours', lambda f: ratios(
            [s.cpu_us for s in f.at_1khz], [s.cpu_us for s in own.at_1khz]))
    add('p50 latency at 1 kHz, µs', lambda f: spread(p50_us(f)))
    if pinocchio:
        add('  times less than Pinocchio', lambda f: ratios(p50_us(pinocchio), p50_us(f)))
    if floor:
        add('  times the floor', lambda f: ratios(p50_us(f), p50_us(floor)))
    add('p99 latency at 1 kHz, µs', lambda f: spread(s.p99_us for s in f.at_1khz))
    if floor:
        add('  times the floor', lambda f: ratios(
            [s.p99_us for s in f.at_1khz], [s.p99_us for s in floor.at_1khz]))
    add('idle CPU, % of a core', lambda f: f'{f.idle_percent:.2f}')
    add('resident memory, MiB', lambda f: f'{f.resident_mib:.1f}')
    if relay:
        add('  over the relay, MiB', lambda f: f'{f.resident_mib - relay.resident_mib:.1f}')
    add('start to first output, s', lambda f: f'{f.start_s:.2f}')
    return table


def growth_table(growth: dict[str, Growth], counts: list[int]) -> Table:
    """Return how the cost of a message grows with the number of robots."""
    first, *more = counts
    table = Table('', *(f'{count} robots' for count in counts),
                  *(f'{count} / {first}' for count in more),
                  title='CPU per message, saturated, µs; one topic for each robot')
    for name, of in growth.items():
        table.add_row(name, *(spread(of[count], 1) for count in counts),
                      *(ratios(of[count], of[first]) for count in more))
    return table


if __name__ == '__main__':
    main()
