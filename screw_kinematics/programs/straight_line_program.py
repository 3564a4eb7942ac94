# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Programs without branches: what tracing yields and the backends write out."""
from __future__ import annotations

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
