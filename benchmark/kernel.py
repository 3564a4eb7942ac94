# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Compare how long pose, twist and acceleration of a Panda's hand take.

First one sample a call, then a recorded motion. In each round every contender runs once,
so that what else the machine does falls on all of them alike; ratios are formed within a
round. Times are processor times where nothing else is said. Figures are medians over the
rounds, with lower and upper quartile in brackets. The results of all contenders are compared
before anything is timed.
"""
import argparse
from collections.abc import Callable
from functools import partial
import importlib.util
import json
from pathlib import Path
import time
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from screw_kinematics import models, SerialChain
from screw_kinematics.programs.machine import TextMachine

from . import kernel_peers as peers
from .node.robot import BASE, URDF

OPTIONAL = {'mujoco': 'MuJoCo', 'pydrake': 'Drake', 'kinpy': 'kinpy (no acceleration)',
            'roboticstoolbox': 'Robotics Toolbox'}
PINOCCHIO = 'Pinocchio'
LIMIT = 'reading and writing alone'
PORTION = 0.01    # s that a contender runs in a round, at least


class Contender(NamedTuple):
    """Something to be timed: a call, how many samples it does, and its results."""

    name: str
    call: Callable[[], Any]
    samples: int = 1
    result: Callable[[], Any] | None = None
    clock: Callable[[], float] = time.process_time


Times = dict[str, list[float]]


def main() -> None:
    """Run the benchmark from the command line."""
    parser = argparse.ArgumentParser(
        prog='python -m benchmark.kernel', description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--rounds', type=int, default=30)
    parser.add_argument('--samples', type=int, default=500_000,
                        help='of the recorded motion; far more than any cache holds')
    parser.add_argument('--json', type=Path, help='file for the times of all rounds, in s')
    options = parser.parse_args()
    urdf = without_meshes(URDF.read_text(encoding='utf-8'))
    chain = models.load_urdf(urdf, BASE, peers.TIP)
    motion = np.random.default_rng(0).normal(size=(3, options.samples, 7))
    console = Console()
    contests = {'one sample a call': single(chain, urdf, motion[:, 0]),
                f'{options.samples} samples': batch(chain, urdf, motion)}
    record = {}
    for title, contenders in contests.items():
        check(contenders)
        times = run(title, contenders, options.rounds)
        console.print(table(title, times))
        record[title] = times
    if options.json:
        options.json.write_text(json.dumps(record, indent=1))


def single(chain: SerialChain, urdf: str, motion: Any) -> list[Contender]:
    """Return the contenders for one sample a call."""
    rows = [row.copy() for row in motion]
    floats = motion.ravel().tolist()

    def library(name: str, sample: peers.Sample) -> Contender:
        return Contender(name, lambda: sample(*rows), result=lambda: sample(*rows))

    program = chain.compile()
    text = TextMachine(program.line, program.dof, program.slices)

    def ours(name: str, call: Callable[[], Any]) -> Contender:
        return Contender(name, call, result=call)

    contenders = [
        library(PINOCCHIO, peers.pinocchio(urdf)),
        Contender('ours, program(q, qd, qdd)', lambda: program(*rows),
                  result=lambda: tuple(program(*rows).values())),
        ours('ours, program.evaluate(floats)', partial(program.evaluate, floats)),
        ours('the same, core interpreted', partial(text.evaluate, floats))]
    contenders.append(library('textbook exponentials, NumPy', peers.textbook(chain)))
    contenders.append(library('ours, not compiled', lambda q, qd, qdd: _of_state(
        chain.state(q, qd, qdd))))
    for module, label in OPTIONAL.items():
        if importlib.util.find_spec(module) is not None:
            contenders.append(library(label, getattr(peers, module.removeprefix('py'))(urdf)))
    return contenders


def batch(chain: SerialChain, urdf: str, motion: Any) -> list[Contender]:
    """Return the contenders for a recorded motion; all write into memory they have."""
    few = motion[:, :len(motion[0]) // 25].copy()
    sample = peers.pinocchio(urdf)
    stored = [np.empty((len(few[0]), *shape)) for shape in ((3,), (3, 3), (6,), (6,))]
    position, rotation, twist, accel = stored

    def loop() -> None:
        for i, (q, qd, qdd) in enumerate(zip(*few)):
            position[i], rotation[i], twist[i], accel[i] = sample(q, qd, qdd)

    def loop_result() -> Any:
        loop()
        return np.hstack([part.reshape(len(part), -1) for part in stored])

    contenders = [Contender(f'{PINOCCHIO}, loop', loop, len(few[0]), loop_result)]
    n = len(motion[0])
    program, out = chain.compile(), np.zeros((n, 24))
    text = TextMachine(program.line, program.dof, program.slices)

    def ours(threads: int) -> Any:
        program.batch(*motion, out=out, threads=threads)
        return out

    def interpreted() -> Any:
        text.batch(motion, out, 1)
        return out

    one, two = partial(ours, 1), partial(ours, 2)
    return contenders + [
        Contender('ours, one thread', one, n, one),
        Contender('ours, two threads, by the clock on the wall', two, n, two, time.perf_counter),
        Contender('ours, core interpreted', interpreted, n, interpreted),
        Contender(LIMIT, partial(read_and_write, motion, np.zeros_like(out)), n)]


def read_and_write(motion: Any, out: Any) -> None:
    """Read all inputs and write all outputs, and do no more."""
    for k in range(0, 21, 7):
        out[:, k:k + 7] = motion[k // 7]
    out[:, 21:] = 0.0


def check(contenders: list[Contender]) -> None:
    """Raise an error unless all contenders get the same results."""
    reference = None
    for contender in contenders:
        if contender.result is None:
            continue
        result = contender.result()
        if isinstance(result, tuple) and not isinstance(result[0], float):
            result = np.concatenate([np.ravel(part) for part in result])
        result = np.atleast_2d(result)
        if contender.name.startswith(peers.LINEAR_FIRST):
            order = [*range(12), 15, 16, 17, 12, 13, 14, 21, 22, 23, 18, 19, 20]
            result = result[:, order[:result.shape[1]]]
        reference = result if reference is None else reference
        rows, columns = map(min, zip(result.shape, reference.shape))
        np.testing.assert_allclose(result[:rows, :columns], reference[:rows, :columns],
                                   atol=1e-9, err_msg=contender.name)


def run(title: str, contenders: list[Contender], rounds: int) -> Times:
    """Return the time per sample [s] of each contender in each round."""
    repeats = {}
    for contender in contenders:
        contender.call()
        start = time.process_time()
        contender.call()
        repeats[contender.name] = 1 + int(PORTION / (time.process_time() - start))
    times: Times = {contender.name: [] for contender in contenders}
    # Drawn between measurements only: it must not run beside them.
    with Progress(auto_refresh=False) as progress:
        task = progress.add_task(title, total=rounds)
        for _ in range(rounds):
            for name, call, samples, _, clock in contenders:
                number = range(repeats[name])
                start = clock()
                for _ in number:
                    call()
                times[name].append((clock() - start) / (len(number) * samples))
            progress.advance(task)
            progress.refresh()
    return times


def table(title: str, times: Times) -> Table:
    """Return the times, and their ratios to the first contender and to the memory limit."""
    first = next(iter(times))
    result = Table('', 'CPU per sample [us]', f'faster than {first}', title=title)
    if LIMIT in times:
        result.add_column(f'time / {LIMIT}')
    for name, values in times.items():
        cells = [name, quartiles(1e6 * np.array(values)),
                 quartiles(np.array(times[first]) / np.array(values))]
        if LIMIT in times:
            cells.append(quartiles(np.array(values) / np.array(times[LIMIT])))
        result.add_row(*cells)
    return result


def quartiles(values: Any) -> str:
    """Return median and quartiles as text."""
    low, middle, high = np.percentile(values, [25, 50, 75])
    return f'{middle:.3g} ({low:.3g}-{high:.3g})'


def without_meshes(urdf: str) -> str:
    """Return a robot description without what some libraries stumble over."""
    root = ElementTree.fromstring(urdf)
    for part in root:
        for child in list(part):
            if child.tag in ('visual', 'collision', 'dynamics', 'safety_controller'):
                part.remove(child)
    return ElementTree.tostring(root, encoding='unicode')


def _of_state(state: Any) -> tuple[Any, ...]:
    return (state.pose[:3, 3], state.pose[:3, :3], state.velocity, state.classical(2))


if __name__ == '__main__':
    main()
