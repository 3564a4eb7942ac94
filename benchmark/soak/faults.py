# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The faults of a soak.

Each does its harm while the source publishes, and returns when it has ended; the details
are random.
"""
from collections.abc import Callable
from random import Random
import signal

from .rig import Rig
from .robots import BROKEN_DESCRIPTIONS, DESCRIPTIONS, ROBOTS
from .source import MALFORMED

Fault = Callable[[Rig, Random], None]
BURST = 10_000


def source_killed(rig: Rig, random: Random) -> None:
    """Kill the source and start another one after a while."""
    rig.wait(lambda: all(check.runs.all for check in rig.checks.values()), 'outputs')
    rig.source.kill()
    rig.source.wait()
    rig.permitted.killed_at = rig.ticks()
    rig.spin(random.uniform(0.0, 2.0))
    rig.start_source()
    rig.command('resume')


def fight(kind: str) -> Fault:
    """Return the fault of a second publisher of 'all' joints, or of 'one'."""
    def two_publishers(rig: Rig, random: Random) -> None:
        rig.permitted.rival = kind == 'all'
        rig.command('rival', kind)
        rig.spin(random.uniform(1.0, 3.0))
        rig.command('rival', '')
    return two_publishers


def clock(direction: int) -> Fault:
    """Return the fault of a clock that jumps by hours."""
    def jump(rig: Rig, random: Random) -> None:
        rig.command('jump', direction * random.randint(1, 12))
        rig.spin(1.0)
    return jump


def burst(rig: Rig, random: Random) -> None:
    """Send many messages at once for one robot."""
    rig.command('burst', random.randrange(len(ROBOTS)), BURST)


def lossy(rig: Rig, random: Random) -> None:
    """Lose, repeat and swap messages."""
    rig.command('lossy', True)
    rig.spin(random.uniform(2.0, 4.0))
    rig.command('lossy', False)


def malformed(rig: Rig, random: Random) -> None:
    """Send messages of every wrong kind."""
    rig.permitted.unstamped = True
    for kind in random.sample(MALFORMED, len(MALFORMED)):
        rig.command('malformed', random.randrange(len(ROBOTS)), kind, random.randint(1, 100))
        rig.spin(random.uniform(0.0, 0.2))


def subscriber_killed(rig: Rig, random: Random) -> None:
    """Stop a reliable subscriber for a while, and kill it."""
    rig.stalling.send_signal(signal.SIGSTOP)
    rig.spin(random.uniform(2.0, 4.0))
    rig.restart_subscriber()


def subscriber_stopped(rig: Rig, random: Random) -> None:
    """
    Stop a subscriber for a while; it goes on after that.

    A best-effort one: what a reliable one missed of such deep queues Fast DDS 2.14 repeats
    more slowly than new messages come.
    """
    rig.restart_subscriber('best_effort')
    rig.stalling.send_signal(signal.SIGSTOP)
    rig.spin(random.uniform(2.0, 4.0))
    rig.stalling.send_signal(signal.SIGCONT)
    rig.spin(1.0)
    rig.count_deaf_subscriber()
    rig.restart_subscriber()


def descriptions(rig: Rig, random: Random) -> None:
    """Change the description, with broken ones between; the last good one must be in use."""
    for _ in range(4):
        rig.describe(random.choice(BROKEN_DESCRIPTIONS))
        rig.spin(random.uniform(0.0, 0.5))
        wanted = 1 - rig.base_in_use()
        rig.describe(DESCRIPTIONS[wanted])
        rig.wait(lambda: rig.base_in_use() == wanted, 'outputs by the new description')
        rig.describe(random.choice(BROKEN_DESCRIPTIONS))
        rig.spin(random.uniform(0.0, 0.5))
        if rig.base_in_use() != wanted:
            raise RuntimeError('a broken description has changed the outputs')


FAULTS: dict[str, Fault] = {
    'none': lambda rig, random: None,
    'source killed (-9), restarted': source_killed,
    'two publishers of all joints': fight('all'),
    'second publisher of one joint': fight('one'),
    'clock forward by hours': clock(1),
    'clock back by hours': clock(-1),
    f'burst of {BURST:,} messages': burst,
    '1 % lost, repeated, reordered': lossy,
    'malformed messages': malformed,
    'subscriber stopped, then killed': subscriber_killed,
    'subscriber stopped, goes on': subscriber_stopped,
    'descriptions changing, broken ones': descriptions,
}
