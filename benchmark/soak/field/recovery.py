# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How the node comes back after something stood still: when it is on time again, what was lost."""
from collections.abc import Callable
from dataclasses import dataclass
import time

from .rig import Rig
from ..listening import Broken

ON_TIME = 0.05
"""Outputs that are no later than this are on time [s]."""

WINDOW = 0.2
"""Over which the rate of outputs is counted [s]."""


@dataclass
class Recovery:
    """What came of a standstill."""

    lost: int = 0           # messages, about: the node tells its count now and then
    worst: float = 0.0      # greatest latency afterwards [s]
    on_time_after: float = float('inf')    # until all outputs were on time again [s]
    rate: float = 0.0       # outputs of all robots in a second while it caught up, at most

    def __str__(self) -> str:
        return (f'on time after {self.on_time_after:.2f} s, {self.lost:,} messages lost, '
                f'latency {self.worst:.2f} s at most, {self.rate:,.0f} outputs a second')


def recovery(rig: Rig, standstill: Callable[[], None], limit: float) -> Recovery:
    """
    Let something stand still, and see how the node comes back.

    Everything is on time before; outputs that are on time again are awaited up to a limit [s].
    """
    found, lost = Recovery(), _lost(rig)
    earlier = [check.latencies.worst for check in rig.checks.values()]
    standstill()
    begin = seen = time.monotonic()
    for check in rig.checks.values():
        check.latencies.worst = 0.0
    outputs = _outputs(rig)
    rig.check()

    def on_time() -> bool:
        nonlocal seen, outputs
        now = time.monotonic()
        if now - seen >= WINDOW:
            count = _outputs(rig)
            found.rate = max(found.rate, (count - outputs) / (now - seen))
            seen, outputs = now, count
        latest = [check.latest for check in rig.checks.values()]
        return all(at > begin and late < ON_TIME for at, late in latest)

    try:
        rig.wait(on_time, 'outputs that are on time', limit)
    except Broken:
        if rig.node.poll() is not None:
            raise
    else:
        found.on_time_after = time.monotonic() - begin
    rig.spin(1.0)
    for check, before in zip(rig.checks.values(), earlier):
        found.worst = max(found.worst, check.latencies.worst)
        check.latencies.worst = max(before, check.latencies.worst)
    found.lost = max(0, _lost(rig) - lost)
    return found


def _outputs(rig: Rig) -> int:
    return sum(check.tally.received for check in rig.checks.values())


def _lost(rig: Rig) -> int:
    return sum(rig.published()) - sum(a.on_topic for a in rig.accounts())
