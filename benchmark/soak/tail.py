# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a source that is killed may take with it: the last it published, and nothing else.

A publisher that dies takes along what it has not sent yet. A reliable reader hands messages
over in the order of their numbers, so what is missing are the last ones before the end,
without a gap: every other gap is a loss that nothing excuses.
"""
from collections.abc import Sequence

import numpy as np

Run = tuple[int, int]


class Runs:
    """
    The first and last tick of each unbroken run of samples, so many ticks apart.

    Examples
    --------
    >>> runs = Runs(step=5)
    >>> runs.take([10, 15, 20])
    >>> runs.take([25, 40])
    >>> runs.all
    [(10, 25), (40, 40)]

    """

    def __init__(self, step: int) -> None:
        self._step = step
        self.all: list[Run] = []

    def take(self, ticks: Sequence[int] | np.ndarray) -> None:
        """Take the ticks of further samples, in the order of their arrival."""
        parts = np.split(ticks, np.flatnonzero(np.diff(ticks) != self._step) + 1)
        for part in parts:
            first, last = int(part[0]), int(part[-1])
            if self.all and first == self.all[-1][1] + self._step:
                first = self.all.pop()[0]
            self.all.append((first, last))


def check_tail(runs: list[Run], killed_at: int, step: int, missing: int) -> str:
    """
    Return what is wrong about the messages missing after a source was killed, or nothing.

    Runs are of the samples seen since the source before was started or resumed, until now. All
    must have been seen but the last ones before the next tick of the killed source, as many as
    were published and not received; the one in hand at the end may have been counted or not.

    Examples
    --------
    >>> check_tail([(10, 20), (90, 100)], killed_at=35, step=5, missing=2)
    ''
    >>> check_tail([(10, 20), (90, 100)], killed_at=35, step=5, missing=4)
    '4 messages missing, but 2 before the end of the source'
    >>> check_tail([(10, 15), (25, 30), (90, 100)], killed_at=35, step=5, missing=1)
    'gaps elsewhere than before the end of the source: [(10, 15), (25, 30), (90, 100)]'

    """
    if len(runs) != 2 or not runs[0][1] < killed_at <= runs[1][0]:
        return f'gaps elsewhere than before the end of the source: {runs}'
    tail = (killed_at - runs[0][1]) // step - 1
    if not max(tail - 1, 0) <= missing <= tail:
        return f'{missing} messages missing, but {tail} before the end of the source'
    return ''
