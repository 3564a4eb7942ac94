# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The course of a field soak: what happens to the robots, one thing after another."""
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random
import signal
import time

import numpy as np

from .checks import Tally
from .recovery import Recovery, recovery
from .rig import Rig
from .robots import DESCRIPTIONS, OFFSET, ROBOTS
from ..books import Account
from ..listening import Broken, PATIENCE
from ..robots import BROKEN_DESCRIPTIONS
from ..tally import Latencies

STOP = 5.0
"""Length of a stop of the node [s]."""

MAX_GROWTH = 2048.0
"""Of the node's memory after the first minute [KiB]."""

MAX_DEARER = 1.3
"""How much more CPU time a message may take in the last quarter than in the second."""

Event = Callable[[Rig, Random], None]


def mishaps(**shares: float) -> Event:
    """Return the event that these shares of the messages meet with a mishap."""
    def some(rig: Rig, random: Random) -> None:
        rig.command('mishaps', shares)
        rig.spin(random.uniform(2.0, 4.0))
        rig.command('mishaps', dict.fromkeys(shares, 0.0))
    return some


def restart(rig: Rig, random: Random) -> None:
    """Take a publisher away, for less or more than the longest gap."""
    rig.command('restart', random.randrange(len(ROBOTS)), random.choice([0.1, 0.5, 2.0]))
    rig.spin(3.0)


def tool(rig: Rig, random: Random) -> None:
    """Set the tool of a robot whose description is a file, and its delay and rates anew."""
    number = random.choice([k for k, robot in enumerate(ROBOTS) if robot.description])
    robot, at = ROBOTS[number], max(rig.models[number])
    wanted = 1 - at
    checks = [check for (k, _), check in rig.checks.items() if k == number]
    rig.models[number] = {0, 1}
    rig.set_parameters({f'{robot.name}.tool_offset': list(OFFSET) if wanted else [0.0] * 6,
                        'diagnostics_rate': random.choice([4.0, 5.0])})
    rig.wait(lambda: any(check.last_model == wanted for check in checks),
             'outputs by the new tool')
    rig.spin(0.5)       # the other output's may be on their way
    rig.models[number] = {wanted}
    rig.spin(1.0)


def description(rig: Rig, random: Random) -> None:
    """Replace the description, with a broken one before and behind."""
    number = next(k for k, robot in enumerate(ROBOTS) if not robot.description)
    checks = [check for (k, _), check in rig.checks.items() if k == number]
    wanted = 1 - checks[0].last_base
    rig.describe(random.choice(BROKEN_DESCRIPTIONS))
    rig.spin(0.3)
    rig.describe(DESCRIPTIONS[wanted])
    rig.wait(lambda: all(check.last_base == wanted for check in checks),
             'outputs by the new description')
    rig.describe(random.choice(BROKEN_DESCRIPTIONS))
    rig.spin(1.0)


def listeners(rig: Rig, random: Random) -> None:
    """Listen to more, and no more."""
    listening = [rig.listen(random.randrange(len(ROBOTS))) for _ in range(3)]
    rig.spin(random.uniform(0.5, 2.0))
    for subscriptions in listening:
        rig.stop_listening(subscriptions)
    rig.spin(0.5)


EVENTS: dict[str, Event] = {
    'description replaced': description,
    'tool and rate changed': tool,
    'listeners come and go': listeners,
    'a publisher restarted': restart,
    'calm': lambda rig, random: rig.spin(3.0),
    '2 % dropped': mishaps(dropped=0.02),
    '2 % doubled': mishaps(doubled=0.02),
    '2 % swapped': mishaps(swapped=0.02),
    '1 % malformed or partial': mishaps(malformed=0.01),
    'all of these': mishaps(dropped=0.02, doubled=0.02, swapped=0.02, malformed=0.01)}
"""In the order in which each happens first: what needs memory of its own is first, so that it has
been there in the first minute."""


@dataclass
class Result:
    """All that a field soak found."""

    minutes: float = 0.0
    events: Counter[str] = field(default_factory=Counter)
    published: list[int] = field(default_factory=list)
    accounts: list[Account] = field(default_factory=list)
    tallies: dict[str, Tally] = field(default_factory=dict)
    stops: list[Recovery] = field(default_factory=list)
    latency: dict[str, float] = field(default_factory=dict)
    memory: list[float] = field(default_factory=list)
    growth: float = float('nan')
    cpu: list[float] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Return whether nothing went wrong."""
        return not self.failures


class Course:
    """A run; of `EVENTS` only some may happen beside the stops. ``tell`` is told what goes on."""

    def __init__(self, rig: Rig, seed: int, tell: Callable[[str], None],
                 events: list[str]) -> None:
        self._rig, self._random, self._tell, self._events = rig, Random(seed), tell, events
        self.result = Result()

    def run(self, seconds: float) -> Result:
        """Have everything happen for some time, each kind at least once; return what was found."""
        rig, result = self._rig, self.result
        begin = time.monotonic()
        try:
            # Once soon: queues are then as long as they will ever be.
            self._stop_listener()
            self._stop_node()
            pending = list(self._events)
            while pending or time.monotonic() - begin < seconds:
                if len(result.stops) == 1 and time.monotonic() - begin > seconds / 2:
                    self._stop_node()
                name = pending.pop(0) if pending else self._random.choice(self._events)
                self._happen(name, EVENTS[name])
            if len(result.stops) == 1:
                self._stop_node()
            rig.during = 'the end'
            rig.spin(2.0)
            self._count()
        except (Broken, RuntimeError) as error:
            result.failures.append(f'{rig.during}: {error}')
        finally:
            code = rig.close()
        if code != 0:
            result.failures.append(f'the node ended with code {code}')
        result.minutes = (time.monotonic() - begin) / 60
        self._conclude()
        return result

    def _happen(self, name: str, event: Event) -> None:
        self._tell(f'{name}; the node has {self._rig.usage[-1][1] / 1024:.1f} MiB')
        self._rig.during = name
        self.result.events[name] += 1
        event(self._rig, self._random)
        self._rig.during = f'the calm after: {name}'
        self._rig.spin(1.0)

    def _stop_listener(self) -> None:
        """Let a listener stand still for a while, and end it."""
        self._tell('a listener stopped')
        self._rig.during = 'a stop of a listener'
        with self._rig.another_listener() as listener:
            listener.send_signal(signal.SIGSTOP)
            self._rig.spin(STOP)

    def _stop_node(self) -> None:
        """Let the node stand still for a while; see how it catches up."""
        rig = self._rig
        self._tell('node stopped')
        rig.during = 'a stop of the node'

        def standstill() -> None:
            rig.node.send_signal(signal.SIGSTOP)
            rig.spin(STOP)
            rig.node.send_signal(signal.SIGCONT)

        found = recovery(rig, standstill, PATIENCE)
        if found.on_time_after > PATIENCE:
            self.result.failures.append(f'{PATIENCE:g} s after a stop outputs are not on time')
        self.result.stops.append(found)
        self._tell(str(found))

    def _count(self) -> None:
        """Compare the node's own counts."""
        rig, result = self._rig, self.result
        result.accounts, result.published = rig.accounts(), rig.published()
        for robot, account in zip(ROBOTS, result.accounts):
            result.failures += [f'{robot.name}: {c}' for c in account.contradictions()]

    def _conclude(self) -> None:
        rig, result = self._rig, self.result
        for (k, output), check in rig.checks.items():
            tally = result.tallies[f'{ROBOTS[k].name}/{output}'] = check.tally
            result.failures += tally.examples
            if not tally.judged:
                result.failures.append(f'{ROBOTS[k].name}/{output}: no output was judged')
        latencies = Latencies.of(check.latencies for check in rig.checks.values())
        result.latency = {str(share): latencies.quantile(share) for share in (0.5, 0.99, 0.999)}
        result.latency['worst'] = latencies.worst
        self._conclude_usage()

    def _conclude_usage(self) -> None:
        """See whether memory and CPU time stayed what they were."""
        result = self.result
        t, kib, cpu = np.array(self._rig.usage).T
        t = t - t[0]
        quarter = max(len(t) // 4, 1)
        result.memory = [float(np.median(kib[at:at + quarter]))
                         for at in range(0, len(t) - quarter + 1, quarter)]
        result.cpu = [float((cpu[min(at + quarter, len(t) - 1)] - cpu[at])
                            / (t[min(at + quarter, len(t) - 1)] - t[at]))
                      for at in range(0, len(t) - quarter, quarter)]
        after = t > 60.0
        if t[-1] < 150.0:
            return      # too short to tell
        result.growth = float(np.median(kib[-10:]) - np.median(kib[after][:10]))
        if result.growth > MAX_GROWTH:
            result.failures.append(f'memory grew by {result.growth:.0f} KiB after a minute')
        if result.cpu[-1] > MAX_DEARER * result.cpu[1]:
            result.failures.append(f'CPU time rose from {result.cpu[1]:.2f} to '
                                   f'{result.cpu[-1]:.2f} of a core')
