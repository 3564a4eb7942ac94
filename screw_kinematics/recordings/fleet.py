# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Many recordings on a dask cluster: whole ones by its workers, long ones block by block.

A worker that dies costs what it was at: dask gives its blocks and recordings to others.
"""
from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from itertools import chain, islice
import logging
import os
from pathlib import Path
from queue import SimpleQueue
from threading import Thread
from typing import Any

from .blocks import Block
from .processing import Outcome, process, Task
from .smoothing import MotionBlock
from .sources import without_password
from .states import Run
from ..errors import optional_module, ToolError

_LOCAL = {
    # Nobody looks at profiles, which cost some percent of each core.
    'distributed.worker.profile.enabled': False,
    'distributed.admin.system-monitor.gil.enabled': False,
    # The event loops look after themselves some hundred times a second, each time taking the
    # interpreter from the work: a tenth of a core beside two that work.
    'distributed.admin.system-monitor.interval': '10s',
    'distributed.admin.tick.interval': '1s',
    'distributed.worker.memory.monitor-interval': '1s',
    # Ctrl-C reaches every process of a terminal, but the tool ends its workers.
    'distributed.worker.preload': ['import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)'],
    # A core each. Not what dask sets beside these: by it arrays are mapped and unmapped always.
    'distributed.nanny.pre-spawn-environ': {
        'OMP_NUM_THREADS': 1, 'MKL_NUM_THREADS': 1, 'OPENBLAS_NUM_THREADS': 1},
}
"""Settings of the cluster here."""

Progress = Callable[[Task, int, int], None]
"""Gets a recording, the joint samples read of it so far, and how many are expected or 0."""


def in_order(executor: Executor, ahead: int) -> Run:
    """
    Return what smooths blocks by an executor and gives the results in order, as ``map`` does.

    So many blocks are under way at a time as may be ahead, which bounds the memory.
    """
    def run(function: Callable[[Block], MotionBlock], blocks: Iterable[Block],
            ) -> Iterator[MotionBlock]:
        rest = iter(blocks)
        first = list(islice(rest, 2))
        if len(first) < 2:      # not worth another process
            yield from map(function, first)
            return
        waiting: deque[Future[MotionBlock]] = deque()
        for block in chain(first, rest):
            waiting.append(executor.submit(function, block))
            if len(waiting) > ahead:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    return run


@contextmanager
def cluster(scheduler: str | None, processes: int) -> Iterator[Any]:
    """Yield a client of a dask cluster: the scheduler's, or else one of its own, then ended."""
    distributed = optional_module(
        'distributed', 'fleet', 'processing many recordings at once (or one after another, with '
        '--processes 1)')
    if scheduler is not None:
        try:
            client = distributed.Client(scheduler, timeout=10)
        except (OSError, ValueError, TimeoutError) as error:
            raise ToolError(f'{scheduler}: no dask scheduler answers: {error}') from None
        with client:
            yield client
        return
    from dask import config
    # What goes wrong is told by the outcomes; logs tell of results that an end left unfetched.
    with config.set(_LOCAL), distributed.LocalCluster(
            n_workers=processes, threads_per_worker=1, dashboard_address='127.0.0.1:0',
            silence_logs=logging.CRITICAL) as local, distributed.Client(local) as client:
        yield client


def process_all(tasks: Sequence[Task], client: Any, progress: Progress) -> Iterator[Outcome]:
    """Process recordings, which the cluster must reach; yield their outcomes as they come."""
    cores = max(sum(client.ncores().values()), 1)
    # The longest first, so that the last ones to end are short.
    tasks = sorted(map(_absolute, tasks), key=lambda task: -task.source.size)
    bound = sum(task.source.size for task in tasks) / (2 * cores)
    outcomes: SimpleQueue[Outcome] = SimpleQueue()
    futures = []
    for task in tasks:
        if task.source.size < bound:
            # Behind the blocks of long recordings, in whose results somebody waits here.
            future = client.submit(process, task, pure=False, priority=-1)
            future.add_done_callback(partial(_hand_over, outcomes, task))
            futures.append(future)
    executor = client.get_executor(pure=False)
    in_blocks = [task for task in tasks if task.source.size >= bound]

    def process_in_blocks() -> None:
        for task in in_blocks:
            try:
                outcomes.put(process(task, in_order(executor, 2 * cores),
                                     partial(progress, task)))
            except Exception as error:      # of the cluster: it must not end the others
                outcomes.put(_failed(task, error))

    Thread(target=process_in_blocks, daemon=True).start()
    for _ in tasks:
        yield outcomes.get()


def _hand_over(outcomes: SimpleQueue[Outcome], task: Task, future: Any) -> None:
    try:
        outcome = future.result()
    except BaseException as error:      # of the cluster, which may end just now
        outcome = _failed(task, error)
    outcomes.put(outcome)


def _failed(task: Task, error: BaseException) -> Outcome:
    place = without_password(task.source.place)
    return Outcome(task.name, place, task.source.size,
                   error=f'{place}: {type(error).__name__}: {error}')


def _absolute(task: Task) -> Task:
    """Return a task whose paths mean the same in other processes."""
    place = task.source.place
    return replace(
        task, folder=Path(os.path.abspath(task.folder)),
        source=task.source._replace(place=place if '://' in place else os.path.abspath(place)))
