# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Ways to run a straight-line program."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from .numpy_blocks import NumpyBlocks
from .plain import Evaluate, python_function
from ..errors import UnknownNameError
from ..se3 import Array
from ..trace import StraightLine

BACKENDS = ('auto', 'python', 'numba')


class Backend(Protocol):
    """What runs a program: one sample, and many."""

    name: str
    evaluate: Evaluate

    def batch(self, inputs: Sequence[Array]) -> Array:
        """Return the outputs, shape (N, n_outputs), of inputs of shape (N, ...)."""

    def warm_up(self) -> None:
        """Do now what would otherwise be done on the first call."""


class PythonBackend:
    """One sample in plain Python, many in blocks of NumPy."""

    name = 'python'

    def __init__(self, line: StraightLine, input_names: Sequence[str]) -> None:
        self._line = line
        self._blocks: NumpyBlocks | None = None
        self.evaluate = python_function(line, input_names)

    def batch(self, inputs: Sequence[Array]) -> Array:
        """Return the outputs, shape (N, n_outputs), of inputs of shape (N, ...)."""
        if self._blocks is None:
            self._blocks = NumpyBlocks(self._line)
        return self._blocks(inputs)

    def warm_up(self) -> None:
        """Do nothing: there is nothing to compile."""


def make_backend(name: str, line: StraightLine, input_names: Sequence[str]) -> Backend:
    """
    Return a program's backend.

    Raises
    ------
    UnknownNameError
        There is no backend of that name.
    MissingExtraError
        It needs a package that is not installed.

    """
    if name not in BACKENDS:
        raise UnknownNameError('backend', name, BACKENDS)
    return PythonBackend(line, input_names)
