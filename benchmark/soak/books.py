# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What the node itself says about its messages, from /diagnostics."""
from collections import Counter
from dataclasses import dataclass, field

from diagnostic_msgs.msg import DiagnosticArray

from .robots import ROBOTS


@dataclass
class Account:
    """Counts of a robot that has a topic of its own, since the node began."""

    on_topic: int = 0
    received: int = 0
    used: int = 0
    outputs: int = 0
    refused_total: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    of_topic: Counter[str] = field(default_factory=Counter)
    waiting: Counter[str] = field(default_factory=Counter)
    incomplete: int = 0

    def contradictions(self) -> list[str]:
        """Return where these counts contradict each other."""
        found = []
        if self.on_topic != self.received + self.of_topic.total():
            found.append(f'topic: {self.on_topic} received, but {self.received} taken by the '
                         f'robot and {self.of_topic.total()} refused')
        if self.received != self.used + self.refused_total:
            found.append(f'{self.received} received, but {self.used} used and '
                         f'{self.refused_total} refused')
        if self.refused_total != self.refused.total():
            found.append(f'{self.refused_total} refused, but {self.refused.total()} by reason')
        return found


def read(array: DiagnosticArray) -> tuple[list[Account], dict[str, dict[str, str]]]:
    """Return the account of each robot, and all values of each part of the node."""
    parts = parts_of(array)
    return [account_of(robot.name, f'/{robot.name}/joint_states', parts)
            for robot in ROBOTS], parts


def parts_of(array: DiagnosticArray) -> dict[str, dict[str, str]]:
    """Return all values of each part of the node."""
    return {status.name.rpartition(': ')[2]: {v.key: v.value for v in status.values}
            for status in array.status}


def account_of(robot: str, topic: str, parts: dict[str, dict[str, str]]) -> Account:
    """Return the account of a robot that has a topic of its own."""
    own, topics = parts.get(robot, {}), parts.get('node', {})
    topic = f'{topic} '

    def counts(values: dict[str, str], prefix: str) -> Counter[str]:
        return Counter({key.removeprefix(prefix): int(value) for key, value in values.items()
                        if key.startswith(prefix)})

    waiting = counts(own, 'used ')
    used = int(own.get('used', 0))
    return Account(
        on_topic=int(topics.get(f'{topic}received', 0)),
        received=int(own.get('received', 0)), used=used, outputs=used - waiting.total(),
        refused_total=int(own.get('refused', 0)), refused=counts(own, 'refused '),
        of_topic=counts(topics, f'{topic}refused '), waiting=waiting,
        incomplete=int(own.get('outputs without derivatives not known yet', 0)))
