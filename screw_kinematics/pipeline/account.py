# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Where every received message went: received = used + refused."""
from __future__ import annotations

from collections import Counter


class Account:
    """
    What became of the messages for one robot.

    Attributes
    ----------
    received : int
    outputs : int
        Messages that led to outputs at once.
    waiting : Counter
        Messages that were used otherwise, by what for: merged with later ones, ...
    refused : Counter
        Messages that were not used, by reason.

    Examples
    --------
    >>> account = Account()
    >>> account.received += 1
    >>> account.refused['position_not_finite'] += 1
    >>> account.received == account.used + account.refused.total()
    True

    """

    def __init__(self) -> None:
        self.received = 0
        self.outputs = 0
        self.waiting: Counter[str] = Counter()
        self.refused: Counter[str] = Counter()

    @property
    def used(self) -> int:
        """How many messages led to outputs, or contribute to later ones."""
        return self.outputs + self.waiting.total()
