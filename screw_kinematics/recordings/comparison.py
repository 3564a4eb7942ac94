# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How far the node's recorded output is from the states made of the same recording."""
from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice

import numpy as np

from .interpolation import interpolate, NODES
from .storage import Message
from ..messages.state_messages import read_states
from ..pipeline.outputs import KINDS, RECORDED
from ..screws.rotations import rotation_from_quaternion, rotation_vector
from ..screws.se3 import Array

_AT_A_TIME = 1000


class Difference:
    """
    Differences of one output, summed up block by block.

    The messages that the node published are read as far as there are states to compare with.
    """

    def __init__(self, topic: str, output: str, messages: Iterator[Message]) -> None:
        self.topic = topic
        self.output = output
        self.received = 0
        self.compared = 0
        self._squares = np.zeros(2)
        self._signal = np.zeros(2)
        self._messages = messages
        self._stamps = np.zeros(0, dtype=np.int64)
        self._values = np.zeros((0, RECORDED[output]))

    def add_states(self, stamps: Array, values: Array) -> None:
        """Take the states of a block, as :func:`read_states` gives them, in order of stamps."""
        while len(self._stamps) == 0 or self._stamps[-1] <= stamps[-1]:
            if not self._read():
                break
        if len(stamps) < NODES:
            return
        inside = (self._stamps >= stamps[0]) & (self._stamps <= stamps[-1])
        if inside.any():
            expected = interpolate(stamps, values, self._stamps[inside])
            self._sum_up(self._values[inside], expected)
        later = self._stamps > stamps[-1]
        self._stamps, self._values = self._stamps[later], self._values[later]

    def finish(self) -> None:
        """Count the messages that are left."""
        self.received += sum(1 for _ in self._messages)

    def _read(self) -> bool:
        """Read some more messages; return whether there were any."""
        some = [message.data for message in islice(self._messages, _AT_A_TIME)]
        self.received += len(some)
        if some:
            stamps, values = read_states(KINDS[self.output].type_name, RECORDED[self.output], some)
            self._stamps = np.concatenate([self._stamps, stamps])
            self._values = np.concatenate([self._values, values])
        return bool(some)

    def _sum_up(self, given: Array, expected: Array) -> None:
        self._squares += [d @ d for d in _distances(self.output, given, expected)]
        if self.output != 'pose':
            self._signal += [(expected[:, :3]**2).sum(), (expected[:, 3:]**2).sum()]
        self.compared += len(given)

    @property
    def rms(self) -> Array:
        """Return the RMS of the angular and of the linear difference."""
        return np.sqrt(self._squares / max(self.compared, 1))

    @property
    def relative(self) -> Array:
        """Return the RMS differences as fractions of the RMS of the states themselves."""
        with np.errstate(invalid='ignore', divide='ignore'):
            return np.sqrt(self._squares / self._signal)


def _distances(output: str, given: Array, expected: Array) -> tuple[Array, Array]:
    """Return angular and linear distances, shape (N,) each."""
    if output != 'pose':
        difference = given - expected
        return (np.linalg.norm(difference[:, :3], axis=1),
                np.linalg.norm(difference[:, 3:], axis=1))
    turn = np.swapaxes(rotation_from_quaternion(given[:, 3:]), 1, 2) @ (
        rotation_from_quaternion(expected[:, 3:]))
    return (np.linalg.norm(rotation_vector(turn), axis=1),
            np.linalg.norm(given[:, :3] - expected[:, :3], axis=1))


def table(differences: Iterable[Difference]) -> str:
    """Return the differences as text: one line for each topic."""
    rows = [f'{"topic":<24}{"messages":>10}{"compared":>10}'
            f'{"rms angular":>14}{"rms linear":>14}{"of the signal":>20}']
    for d in differences:
        share = '' if d.output == 'pose' or not d.compared else (
            f'{100 * d.relative[0]:.3g} %, {100 * d.relative[1]:.3g} %')
        rows.append(f'{d.topic:<24}{d.received:>10}{d.compared:>10}'
                    f'{d.rms[0]:>14.3g}{d.rms[1]:>14.3g}{share:>20}')
    return '\n'.join(rows)
