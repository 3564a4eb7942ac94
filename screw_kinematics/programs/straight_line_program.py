# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Programs without branches: what tracing yields and the backends write out."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Union


class Operation(NamedTuple):
    """
    One operation; an int operand is a value's index, a float a constant.

    ``kind`` is one of 'add', 'sub', 'mul', 'div', 'neg', 'sin', 'cos', 'sqrt'; the last
    four have no right operand.
    """

    kind: str
    left: Union[int, float]
    right: Union[int, float, None] = None

    @property
    def operands(self) -> tuple[int, ...]:
        """Return the indices of the values this operation reads."""
        _, left, right = self
        if isinstance(left, int):
            return (left, right) if isinstance(right, int) else (left,)
        return (right,) if isinstance(right, int) else ()


@dataclass(frozen=True)
class StraightLineProgram:
    """
    A program without branches.

    Values are numbered: first the inputs, then the result of each operation in order.

    Parameters
    ----------
    n_inputs : int
        How many numbers it reads.
    operations : tuple of Operation
        Every operation reads inputs and results of earlier operations only.
    outputs : tuple of int or float
        Index of the value, or a constant.

    """

    n_inputs: int
    operations: tuple[Operation, ...]
    outputs: tuple[Union[int, float], ...]

    def count(self) -> dict[str, int]:
        """
        Return how many operations there are of each kind.

        Returns
        -------
        dict of str to int
            From the kind to the number.

        """
        kinds = [operation.kind for operation in self.operations]
        return {kind: kinds.count(kind) for kind in sorted(set(kinds))}

    def uses(self) -> list[int]:
        """
        Return how often each value is read, outputs included.

        Returns
        -------
        list of int
            One number for each value, inputs first.

        """
        uses = [0] * (self.n_inputs + len(self.operations))
        for operation in self.operations:
            for index in operation.operands:
                uses[index] += 1
        for output in self.outputs:
            if isinstance(output, int):
                uses[output] += 1
        return uses

    def part(self, inputs: Sequence[int], outputs: Sequence[Union[int, float]],
             ) -> StraightLineProgram:
        """
        Return the part of the program that leads from some of its values to others.

        Parameters
        ----------
        inputs : sequence of int
            Values taken as given: the inputs of the part. Negative ones are placeholders,
            inputs that nothing reads.
        outputs : sequence of int or float
            Values the part shall compute from them, or constants.

        Returns
        -------
        StraightLineProgram
            A program of its own.

        """
        new_index = {value: k for k, value in enumerate(inputs) if value >= 0}
        needed = set()
        pending = [value for value in outputs if isinstance(value, int)]
        while pending:
            value = pending.pop()
            if value not in new_index and value not in needed:
                needed.add(value)
                pending.extend(self.operations[value - self.n_inputs].operands)

        def renumbered(x: Union[int, float]) -> Union[int, float]:
            return new_index[x] if isinstance(x, int) else x

        operations = []
        for value in sorted(needed):
            kind, left, right = self.operations[value - self.n_inputs]
            operations.append(Operation(
                kind, renumbered(left), None if right is None else renumbered(right)))
            new_index[value] = len(inputs) + len(operations) - 1
        return StraightLineProgram(len(inputs), tuple(operations),
                                   tuple(renumbered(value) for value in outputs))
