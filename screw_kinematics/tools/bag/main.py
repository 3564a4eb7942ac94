# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Compute states from recordings, smoothed without the lag a live node has.

Reads joint states out of bags of ROS 2 (mcap, sqlite3) and ROS 1 and out of tables (CSV,
Parquet) without a ROS installation, and writes bags with the topics of the node, tables, or a
data set. Of many recordings only those that are new or have changed are processed.
"""
from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
import multiprocessing
import os
from pathlib import Path
import signal

from .account import Bar, print_single, summary_table
from .report import write_report
from .. import console, settings_options, table_options
from ..processes import end_with_parent
from ...errors import ParameterError, ToolError
from ...pipeline.outputs import OUTPUTS
from ...recordings import records
from ...recordings.fleet import cluster, in_order, process_all
from ...recordings.processing import FORMS, Outcome, process, Task
from ...recordings.sources import find_sources, without_password
from ...recordings.states import LEFT_OUT, Run
from ...recordings.tables import ENDINGS

EXAMPLES = """\
  bag recording --robot config/robots/panda.yaml --output states
  bag recording --params-file kinematic_states.yaml --output states.parquet
  bag run.mcap --robot panda.urdf --tip panda_hand_tcp --outputs pose,twist,accel,jerk \\
      --output states.csv
  bag log.csv --robot arm.urdf --columns stamp=t,elbow=q2 --units deg --output states.csv
  bag recording --params-file kinematic_states.yaml --compare
  bag recordings/ 'more/*.bag' --params-file kinematic_states.yaml --output states \\
      --report report.html                       a Parquet data set of all that is there
  bag s3://lab/2026 --params-file fleet.yaml --output states --scheduler tcp://head:8786
"""

NOT_WRITTEN = ('.bag', '.gz', '.json', '.txt', '.xlsx')
"""Endings of recordings that are only read, and of tables elsewhere: no folder is meant."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the tool; see ``bag --help``."""
    options = console.parser('bag', __doc__ or '', EXAMPLES)
    options.add_argument('paths', nargs='+', metavar='PATH',
                         help='bags (a folder, or a .mcap, .db3 or .bag file), tables (.csv, '
                              '.parquet), folders and patterns of them, URLs of them')
    settings_options.add_options(options, required=True)
    options.add_argument('--name', default='robot', help='name of that robot, with which its '
                                                         'topics begin (default: robot)')
    options.add_argument('--outputs', metavar='A,B', help='what to compute: '
                         f'{", ".join(o for o in OUTPUTS if o not in LEFT_OUT)}; tables hold '
                         'six-vectors and poses (default: as in FILE, or twist,accel)')
    options.add_argument('--output', type=Path, metavar='PATH',
                         help='of one recording: a .csv or .parquet table for each robot, or else '
                              'a bag; of several: a folder for all outputs')
    options.add_argument('--format', '--storage', choices=FORMS, default='',
                         help='format of the output (default: mcap; dataset for several '
                              'recordings)')
    options.add_argument('--force', action='store_true',
                         help='process finished recordings again, overwrite existing files')
    options.add_argument('--processes', type=int, default=os.cpu_count() or 1, metavar='N',
                         help='number of parallel processes (default: one for each core)')
    options.add_argument('--scheduler', metavar='ADDRESS',
                         help='address of a dask scheduler, whose workers do the processing')
    options.add_argument('--compare', action='store_true',
                         help='compare the recorded outputs of the node with these states')
    options.add_argument('--report', type=Path, metavar='FILE',
                         help='write a page about the motion: speeds, workspace, stops')
    options.add_argument('--stop-limit', type=float, default=5.0, metavar='A',
                         help='deceleration from which a stop is a hard one in the report [m/s2] '
                              '(default: 5)')
    table_options.add_options(options)
    return console.run(_bag, options, argv)


def _bag(arguments: argparse.Namespace) -> int:
    if arguments.output is None and not (arguments.compare or arguments.report):
        raise ParameterError('output', None, 'a path, or --compare, or --report')
    if arguments.processes < 1:
        raise ParameterError('processes', arguments.processes, '1 or more')
    tasks = _tasks(arguments)
    if len(tasks) > 1 or arguments.format == 'dataset':
        outcomes = _many(arguments, tasks)
        print(summary_table(outcomes))
    else:
        console.keep_existing(tasks[0].places(), arguments.force)
        with Bar(tasks) as bar, _runner(arguments) as run:
            outcomes = [process(tasks[0], run, partial(bar.advance, tasks[0]))]
        if outcomes[0].error:
            raise ToolError(outcomes[0].error)
        print_single(outcomes[0], tasks[0])
    if arguments.report:
        write_report(arguments.report, outcomes, arguments.stop_limit)
        print(f'report: {arguments.report}')
    return console.OK if all(outcome.sound for outcome in outcomes) else console.FOUND_PROBLEMS


def _tasks(arguments: argparse.Namespace) -> list[Task]:
    """Return what is to be done of each recording."""
    sources = find_sources(arguments.paths)
    output: Path | None = arguments.output
    form, folder, name = arguments.format, Path(), ''
    if output is None:
        form = ''
    elif len(sources) > 1 or form == 'dataset':
        if output.suffix.lower() in (*ENDINGS, *NOT_WRITTEN):
            raise ParameterError('output', str(output), 'a folder, as many files go there; '
                                 '--format csv or parquet makes them tables')
        form, folder = form or 'dataset', output
    else:
        ending = output.suffix.lower()
        if not form and ending in NOT_WRITTEN:
            raise ParameterError('output', str(output), 'a file ending in .csv or .parquet, or '
                                 'the folder of a bag')
        form = form or (ending[1:] if ending in ENDINGS else
                        'sqlite3' if ending == '.db3' else 'mcap')
        folder, name = output.parent, output.stem if ending in ENDINGS else output.name
    chosen = {} if arguments.outputs is None else {
        'outputs': [word for word in arguments.outputs.split(',') if word]}
    robots = tuple(settings_options.settings_of(arguments, chosen))
    common = Task(
        sources[0], robots, arguments.namespace, form, folder,
        table=table_options.table_format(arguments), compare=arguments.compare,
        stop_limit=arguments.stop_limit if arguments.report else None)
    return [replace(common, source=source, name=name or source.name) for source in sources]


def _many(arguments: argparse.Namespace, tasks: Sequence[Task]) -> list[Outcome]:
    """Process what is not done; return all outcomes in the order of the recordings."""
    recorded = bool(tasks[0].form)
    before = {task.name: None if arguments.force or not recorded else records.done_before(task)
              for task in tasks}
    for task in tasks:
        try:        # what no earlier run has written is somebody's
            console.keep_existing(task.places(), arguments.force or records.known(task))
        except ToolError as error:
            before[task.name] = Outcome(task.name, without_password(task.source.place), 0,
                                        error=str(error))
    left = [task for task in tasks if before[task.name] is None]
    done = {name: outcome for name, outcome in before.items() if outcome is not None}
    unchanged = sum(outcome.before for outcome in done.values())
    if unchanged:
        print(f'{unchanged} of {len(tasks)} recordings are done and unchanged')
    by_name = {task.name: task for task in tasks}
    with Bar(left) as bar:
        for outcome in _process(arguments, left, bar):
            task = by_name[outcome.name]
            if recorded:
                records.keep(task, outcome)
            done[outcome.name] = outcome
            bar.finish(task, outcome)
    return [done[task.name] for task in tasks]


def _process(arguments: argparse.Namespace, tasks: Sequence[Task], bar: Bar,
             ) -> Iterator[Outcome]:
    if not tasks:
        return
    if arguments.processes == 1 and arguments.scheduler is None:
        for task in tasks:
            yield process(task, progress=partial(bar.advance, task))
        return
    with cluster(arguments.scheduler, arguments.processes) as client:
        yield from process_all(tasks, client, bar.advance)


@contextmanager
def _runner(arguments: argparse.Namespace) -> Iterator[Run]:
    """Yield what smooths blocks, in several processes as soon as there are several blocks."""
    processes = arguments.processes
    if arguments.scheduler is not None:
        with cluster(arguments.scheduler, processes) as client:
            yield in_order(client.get_executor(pure=False), 2 * sum(client.ncores().values()))
        return
    if processes == 1:
        yield map
        return
    pool = ProcessPoolExecutor(processes, multiprocessing.get_context('spawn'),
                               _begin_worker, (os.getpid(),))
    try:
        yield in_order(pool, 2 * processes)
    except BaseException:
        # Nobody waits for what they are at, nor for the rest of a result that one of them sends.
        for worker in multiprocessing.active_children():
            worker.terminate()
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()


def _begin_worker(parent: int) -> None:
    """Leave Ctrl-C, which reaches every process of a terminal, to the tool."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent(parent)
