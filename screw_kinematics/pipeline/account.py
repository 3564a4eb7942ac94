# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Where every received message went: received = used + refused."""
from __future__ import annotations

from collections import Counter
from typing import TypeVar

from ..errors import Reason

Outcome = TypeVar('Outcome')


class Account:
    """
    What became of the messages for one robot.

    Of the messages that led to outputs at once, the incomplete ones left out outputs of a higher
    derivative than is known yet, and those without base what is relative to the world. Others were
    used later, merged with other joints' for instance, or refused. Details say more than a reason,
    of its latest message.

    Examples
    --------
    >>> account = Account()
    >>> [str(account.close(x)) for x in (Reason.NOT_FINITE, Reason.SETTLING, 'a state')]
    ['position_not_finite', 'estimator_settling', 'a state']
    >>> account.received, account.used, account.refused.total()
    (3, 2, 1)
    >>> _ = account.close(Reason.WRONG_LENGTH, '5 positions for 6 names')
    >>> account.told(Reason.NOT_FINITE), account.latest
    ('position_not_finite', 'position_of_wrong_length (5 positions for 6 names)')

    """

    def __init__(self) -> None:
        self.received = 0
        self.outputs = 0
        self.incomplete = self.without_base = 0
        self.used_later: Counter[Reason] = Counter()
        self.refused: Counter[Reason] = Counter()
        self.details: dict[Reason, str] = {}

    @property
    def used(self) -> int:
        """How many messages led to outputs, or contribute to later ones."""
        return self.outputs + self.used_later.total()

    def close(self, outcome: Outcome, detail: str = '') -> Outcome:
        """Count what a message led to, a reason or a state; return that."""
        self.received += 1
        if not isinstance(outcome, Reason):
            self.outputs += 1
        elif outcome.used:
            self.used_later[outcome] += 1
        else:
            self.refused[outcome] += 1
            self.details.pop(outcome, None)     # so that the latest is the last
            self.details[outcome] = detail
        return outcome

    def told(self, reason: Reason) -> str:
        """Return a reason to refuse, and what is known beyond it of its latest message."""
        detail = self.details.get(reason)
        return f'{reason} ({detail})' if detail else str(reason)

    @property
    def latest(self) -> str:
        """Return why the latest of the refused messages was refused."""
        return self.told(next(reversed(self.details)))
