# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Several straight-line programs as one, in which what they have in common is computed once."""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Union

from .straight_line_program import Operation, StraightLineProgram


def joined(parts: Iterable[tuple[StraightLineProgram, Sequence[int]]], n_inputs: int,
           ) -> StraightLineProgram:
    """
    Return the program whose outputs are those of all parts, one after the other.

    Each part comes with the inputs of the whole that are its own. Operations that are equal are in
    it once; results are the same to the last bit.

    Examples
    --------
    >>> turn = StraightLineProgram(1, (Operation('sin', 0), Operation('cos', 0)), (1, 2))
    >>> joined([(turn, [0]), (turn, [1]), (turn, [0])], 2).count()
    {'cos': 2, 'sin': 2}

    """
    operations: list[Operation] = []
    known: dict[object, int] = {}
    outputs: list[Union[int, float]] = []
    for line, inputs in parts:
        places = list(inputs)       # of the part's values among those of the whole
        for kind, left, right in line.operations:
            operation = Operation(kind, places[left] if isinstance(left, int) else left,
                                  places[right] if isinstance(right, int) else right)
            # The value of index 2 and the constant 2.0 are equal and hash alike.
            key = operation, type(left), type(right)
            if key not in known:
                known[key] = n_inputs + len(operations)
                operations.append(operation)
            places.append(known[key])
        outputs += [places[x] if isinstance(x, int) else x for x in line.outputs]
    return StraightLineProgram(n_inputs, tuple(operations), tuple(outputs))
