# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The course of a soak: episodes of a fault and a calm time, after each of which books are closed.

When books are closed the source pauses, and all it has published must be accounted for: as
used or refused by the node, and as outputs that have arrived.
"""
from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random
import signal
import time

from screw_kinematics.pipeline.outputs import KINDS

from .books import Account
from .checks import Permitted, Tally
from .faults import BURST, FAULTS
from .listening import Broken
from .memory import MAX_SLOPE, Memory, SLOPE_MINUTES
from .rig import Rig
from .robots import ROBOTS
from .tail import check_tail
from .tally import Latencies

SETTLING_TICKS = 1500
SILENCE = 5.0
"""After so long without anything new, what is missing does not come any more [s]."""

STRETCH = 2 * BURST
"""Messages in the burst for each robot with which a run begins that is long enough for a slope."""


@dataclass
class FaultFigures:
    """What came of a kind of fault."""

    times: int = 0
    published: int = 0
    lost_with_source: int = 0
    outputs: int = 0
    used_otherwise: int = 0
    refused: int = 0
    failures: list[str] = field(default_factory=list)


@dataclass
class Result:
    """All that a soak found."""

    minutes: float = 0.0
    faults: dict[str, FaultFigures] = field(default_factory=dict)
    accounts: list[Account] = field(default_factory=list)
    tallies: dict[str, Tally] = field(default_factory=dict)
    failures: list[str] = field(default_factory=list)
    memory: Memory = field(default_factory=Memory)
    relay_memory: Memory = field(default_factory=Memory)
    latency_p50: float = 0.0
    latency_p99: float = 0.0
    latency_worst: float = 0.0
    latency_worst_in_faults: float = 0.0
    restarts: dict[str, dict[str, int]] = field(default_factory=dict)
    deaf_subscribers: int = 0

    @property
    def passed(self) -> bool:
        """Return whether nothing went wrong."""
        return not self.failures and not any(f.failures for f in self.faults.values())


class Soak:
    """A run, calm [s] after each fault; ``tell`` is told what goes on."""

    def __init__(self, rig: Rig, seed: int, calm: float, tell: Callable[[str], None]) -> None:
        self._rig, self._random, self._calm, self._tell = rig, Random(seed), calm, tell
        self._begin = time.monotonic()
        self._failures: list[str] = []
        self._lost = [0] * len(ROBOTS)
        self._before = [Account() for _ in ROBOTS]
        self._published_before = [0] * len(ROBOTS)
        self.result = Result(faults={name: FaultFigures() for name in FAULTS})

    def run(self, seconds: float, names: list[str] | None = None) -> Result:
        """
        Have faults of some kinds, by default all, for a while; return what was found.

        The first ones are one of each kind in order, whatever time that takes; then they are drawn
        at random.
        """
        rig, result = self._rig, self.result
        kinds = list(FAULTS) if names is None else names
        try:
            self._warm_up()
            if seconds >= 2 * 60 * SLOPE_MINUTES:
                self._stretch()
            self._begin = time.monotonic()
            turn = 0
            while turn < len(kinds) or time.monotonic() - self._begin < seconds:
                self._episode(kinds[turn] if turn < len(kinds) else self._random.choice(kinds))
                turn += 1
                if turn == len(kinds):
                    rig.memory.forget()     # what each kind of fault takes is taken now
                    rig.relay_memory.forget()
                self._conclude()
        except Broken as error:
            self._failures.append(str(error))
        finally:
            code = rig.close()
        if code != 0:
            self._failures.append(f'the node ended with code {code}')
        self._conclude()
        return result

    def _warm_up(self) -> None:
        """Wait until every output has arrived, and close the books for the first time."""
        rig = self._rig
        self._tell('starting')
        rig.wait(lambda: all(
            rig.report()[1].get(r.name, {}).get('outputs listened to') == ', '.join(r.outputs)
            for r in ROBOTS), 'the node to serve all outputs')
        rig.command('resume')
        rig.wait(lambda: all(c.tally.received > 0 for c in rig.checks.values()), 'outputs')
        figures = FaultFigures()
        self._close_books(figures)
        self._failures += figures.failures

    def _stretch(self) -> None:
        """Have all queues longer than any fault will make them."""
        rig = self._rig
        self._tell('filling queues')
        rig.command('resume')
        rig.stalling.send_signal(signal.SIGSTOP)
        for robot in range(len(ROBOTS)):
            rig.command('burst', robot, STRETCH)
        figures = FaultFigures()
        self._close_books(figures)
        self._failures += figures.failures
        rig.command('resume')
        rig.restart_subscriber()

    def _episode(self, name: str) -> None:
        rig, figures = self._rig, self.result.faults[name]
        self._tell(name)
        figures.times += 1
        bad_before, failures_before = self._bad_outputs(), len(figures.failures)
        rig.command('resume')
        rig.spin(0.5)
        try:
            FAULTS[name](rig, self._random)
        except RuntimeError as error:
            figures.failures.append(str(error))
            if isinstance(error, Broken):
                raise
        settled_from = [tick + SETTLING_TICKS for tick in rig.ticks()]
        published = rig.published()
        rig.wait_for_progress(lambda: all(
            account.on_topic >= count - lost for account, count, lost in zip(
                rig.report()[0], published, self._lost)), SILENCE)
        rig.permitted.settled_from = settled_from
        rig.spin(self._calm)
        self._close_books(figures)
        bad = self._bad_outputs() - bad_before
        if bad:
            figures.failures.append(f'{bad} outputs were wrong')
        for failure in figures.failures[failures_before:]:
            self._tell(f'{name}: {failure}')

    def _bad_outputs(self) -> int:
        return sum(check.tally.failures for check in self._rig.checks.values())

    def _close_books(self, figures: FaultFigures) -> None:
        """Pause, wait until nothing is under way, and compare all counts."""
        rig = self._rig
        rig.command('pause')
        published, killed_at = rig.published(), rig.permitted.killed_at

        def missing(accounts: list[Account]) -> list[int]:
            return [p - lost - a.on_topic
                    for p, lost, a in zip(published, self._lost, accounts)]

        def expected(account: Account, output: str) -> int:
            # Of measured motion the twist is known at once, derivatives once they settled.
            return account.outputs - (account.incomplete if KINDS[output].order > 1 else 0)

        def complete() -> bool:
            accounts, _ = rig.report()
            return all(m <= 0 for m in missing(accounts)) and all(
                rig.received(i, output) >= expected(accounts[i], output)
                for i, output in rig.checks)

        # What was lost with the source does not come: silence tells.
        rig.wait_for_progress(complete, 4 * SILENCE if killed_at is None else SILENCE)
        rig.wait_for_report()
        rig.check()
        accounts, _ = rig.report()
        for i, (robot, account, gone) in enumerate(zip(ROBOTS, accounts, missing(accounts))):
            if killed_at is not None:
                figures.lost_with_source += gone
                self._lost[i] += gone
                for output in robot.outputs:
                    check = rig.checks[i, output]
                    wrong = check_tail(check.runs.all, killed_at[i], check.step, gone)
                    if wrong:
                        figures.failures.append(f'{robot.name}/{output}: {wrong}')
            elif gone:
                figures.failures.append(
                    f'{robot.name}: {published[i]} messages published, {account.on_topic} '
                    f'received, {self._lost[i]} lost with their source')
                self._lost[i] += gone
            figures.failures += [f'{robot.name}: {c}' for c in account.contradictions()]
            for output in robot.outputs:
                if rig.received(i, output) != expected(account, output):
                    figures.failures.append(
                        f'{robot.name}/{output}: {account.outputs} outputs counted, '
                        f'{account.outputs - expected(account, output)} of them left out, '
                        f'{rig.received(i, output)} received')
            before = self._before[i]
            figures.published += published[i] - self._published_before[i]
            figures.outputs += account.outputs - before.outputs
            figures.used_otherwise += (account.waiting - before.waiting).total()
            figures.refused += (account.refused + account.of_topic).total() - (
                before.refused + before.of_topic).total()
        self._before, self._published_before = accounts, published
        for check in rig.checks.values():
            check.runs.all.clear()
        rig.permitted = Permitted()

    def _conclude(self) -> None:
        """Bring the result up to date."""
        rig, result = self._rig, self.result
        result.minutes = (time.monotonic() - self._begin) / 60
        result.failures = [*self._failures]
        result.accounts, parts = rig.report()
        result.restarts = {
            robot.name: {key.removeprefix('restarts '): int(value)
                         for key, value in parts.get(robot.name, {}).items()
                         if key.startswith('restarts ')} for robot in ROBOTS}
        for (i, output), check in rig.checks.items():
            tally = result.tallies[f'{ROBOTS[i].name}/{output}'] = check.tally
            result.failures += tally.examples
            if tally.failures and not tally.examples:
                result.failures.append(f'{ROBOTS[i].name}/{output}: {tally.failures} wrong')
            if not tally.exact + tally.estimated:
                result.failures.append(f'{ROBOTS[i].name}/{output}: no output was compared')
        latencies = Latencies.of(check.latencies for check in rig.checks.values())
        result.latency_p50, result.latency_p99 = map(latencies.quantile, (0.5, 0.99))
        result.latency_worst = latencies.worst
        result.latency_worst_in_faults = max(
            check.worst_in_faults for check in rig.checks.values())
        result.memory, result.relay_memory = rig.memory, rig.relay_memory
        result.deaf_subscribers = rig.deaf_subscribers
        slope = rig.memory.slope
        if slope is not None and slope > MAX_SLOPE:
            result.failures.append(f'memory grows by {slope:.1f} KiB/min')
