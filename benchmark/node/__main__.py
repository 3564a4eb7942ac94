# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Compare the node with others, in real processes over real DDS.

Each round runs every contender once, with each number of robots in turn, so that what else the
machine does falls on all of them alike; figures are medians over the rounds, with the least and
the greatest in brackets. Ratios are formed within a round.
"""
import argparse
from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import asdict
import json
from pathlib import Path
import statistics

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from .contenders import Contender, CONTENDERS, PINOCCHIO, RELAY
from .trial import Figures, Trial

Results = dict[tuple[str, int], list[Figures]]


def main() -> None:
    """Run the benchmark from the command line."""
    parser = argparse.ArgumentParser(
        prog='python -m benchmark.node', description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--rounds', type=int, default=5)
    parser.add_argument('--seconds', type=float, default=2.0, help='of each measurement')
    parser.add_argument('--robots', type=int, nargs='+', default=[1, 4, 16])
    parser.add_argument('--only', nargs='+', metavar='TEXT', default=[''],
                        help='only contenders whose name contains one of these')
    parser.add_argument('--json', type=Path, help='file for all figures of all rounds')
    options = parser.parse_args()
    contenders = [c for c in CONTENDERS if any(text in c.name for text in options.only)]
    results = run(contenders, options.robots, options.rounds, options.seconds)
    console = Console()
    if not console.is_terminal:
        console.width = 170
    console.print(one_robot_table(results, contenders, options.robots[0]))
    if len(options.robots) > 1:
        console.print(robots_table(results, contenders, options.robots))
    if options.json:
        options.json.write_text(json.dumps(
            [{'name': name, 'robots': robots, 'rounds': [asdict(f) for f in figures]}
             for (name, robots), figures in results.items()], indent=1))


def run(contenders: list[Contender], robots: list[int], rounds: int, seconds: float) -> Results:
    """Return the figures of each contender and number of robots, one for each round."""
    results: Results = defaultdict(list)
    # Drawn between trials only: it must not run beside them.
    with Progress(auto_refresh=False) as progress:
        task = progress.add_task('', total=rounds * len(robots) * len(contenders))
        for number in range(rounds):
            for contender in contenders:
                for count in robots:
                    progress.update(task, description=f'round {number + 1}, {count} robots: '
                                                      f'{contender.name}')
                    progress.refresh()
                    results[contender.name, count].append(
                        Trial(contender, count).run(seconds, full=count == robots[0]))
                    progress.advance(task)
    return results


def spread(values: Iterable[float], digits: int = 0) -> str:
    """Return median, least and greatest as text."""
    values = list(values)
    low, middle, high = (
        f'{v:,.{digits}f}' for v in (min(values), statistics.median(values), max(values)))
    return f'{middle} ({low}-{high})'


def ratios(results: Results, of: tuple[str, int], to: tuple[str, int],
           figure: Callable[[Figures], float], inverse: bool = False) -> str:
    """Return the ratio of a figure to another contender's, or the inverse."""
    if not results.get(to):
        return '-'
    pairs = [(figure(a), figure(b)) for a, b in zip(results[of], results[to])]
    return spread([b / a if inverse else a / b for a, b in pairs], 2)


def one_robot_table(results: Results, contenders: list[Contender], robots: int) -> Table:
    """Return all figures for one number of robots."""
    table = Table('', *(c.name for c in contenders),
                  title=f'{robots} robot(s): medians (least-greatest)')
    keys = [(c.name, robots) for c in contenders]
    relay, pinocchio = (RELAY, robots), (PINOCCHIO, robots)

    def add(heading: str, digits: int, figure: Callable[[Figures], float]) -> None:
        table.add_row(heading, *(spread(map(figure, results[key]), digits) for key in keys))

    def add_ratio(heading: str, to: tuple[str, int], figure: Callable[[Figures], float],
                  inverse: bool = False) -> None:
        table.add_row(heading, *(ratios(results, key, to, figure, inverse) for key in keys))

    add('CPU per message, saturated, µs', 1, lambda f: f.cpu_us)
    add_ratio('  times less than Pinocchio', pinocchio, lambda f: f.cpu_us, inverse=True)
    add('messages/s', 0, lambda f: f.rate)
    add_ratio('  times the relay', relay, lambda f: f.rate)
    table.add_row('lost', *(str(sum(f.lost for f in results[key])) for key in keys))
    add('CPU per message at 1 kHz, µs', 0, lambda f: f.cpu_1khz_us)
    add('p50 latency at 1 kHz, µs', 0, lambda f: f.p50_us)
    add_ratio('  times less than Pinocchio', pinocchio, lambda f: f.p50_us, inverse=True)
    add('p99 latency at 1 kHz, µs', 0, lambda f: f.p99_us)
    add('idle CPU, % of a core', 2, lambda f: f.idle_percent)
    add('resident memory, MiB', 1, lambda f: f.rss_mib)
    table.add_row('  over the relay, MiB', *(
        spread([f.rss_mib - r.rss_mib for f, r in zip(results[key], results[relay])], 1)
        if results.get(relay) else '-' for key in keys))
    add('start to first output, s', 2, lambda f: f.start_s)
    return table


def robots_table(results: Results, contenders: list[Contender], robots: list[int]) -> Table:
    """Return how the cost of a message grows with the number of robots."""
    table = Table('', *(f'{count} robots' for count in robots), f'{robots[-1]} / {robots[0]}',
                  title='CPU per message, saturated, µs; one topic for each robot')
    for contender in contenders:
        table.add_row(
            contender.name,
            *(spread((f.cpu_us for f in results[contender.name, count]), 1) for count in robots),
            ratios(results, (contender.name, robots[-1]), (contender.name, robots[0]),
                   lambda f: f.cpu_us))
    return table


if __name__ == '__main__':
    main()
