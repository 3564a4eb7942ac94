# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Ways to run a straight-line program."""
from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from typing import Protocol

import numpy as np

from .c_text import c_header, c_source
from .instructions import StraightLine
from .numpy_blocks import NumpyBlocks
from .python_text import python_function, python_source
from ..errors import MissingExtraError, UnknownNameError
from ..screws.se3 import Array

BACKENDS = ('auto', 'python', 'numba')


__all__ = ['BACKENDS', 'Backend', 'c_header', 'c_source', 'make_backend', 'python_source']


class Backend(Protocol):
    """What runs a program: one sample, and many."""

    name: str
    workspace: Array

    def evaluate(self, values: Sequence[float], /) -> Sequence[float]:
        """Return the outputs of one sample, flat."""

    def run(self) -> None:
        """Compute the outputs in the workspace from the inputs in it."""

    def batch(self, inputs: Sequence[Array], results: Array) -> None:
        """Write the outputs, shape (N, n_outputs), of inputs of shape (N, ...)."""

    def warm_up(self) -> None:
        """Do now what would otherwise be done on the first call."""


class PythonBackend:
    """One sample in plain Python, many in blocks of NumPy."""

    name = 'python'

    def __init__(self, line: StraightLine, input_names: Sequence[str]) -> None:
        self._line = line
        self._blocks: NumpyBlocks | None = None
        self.evaluate = python_function(line, input_names)
        self.workspace = np.zeros(line.n_inputs + len(line.outputs))

    def run(self) -> None:
        """Compute the outputs in the workspace from the inputs in it."""
        n = self._line.n_inputs
        self.workspace[n:] = self.evaluate(self.workspace[:n].tolist())

    def batch(self, inputs: Sequence[Array], results: Array) -> None:
        """Write the outputs, shape (N, n_outputs), of inputs of shape (N, ...)."""
        if self._blocks is None:
            self._blocks = NumpyBlocks(self._line)
        self._blocks(inputs, results)

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
    if name == 'python' or name == 'auto' and find_spec('numba') is None:
        return PythonBackend(line, input_names)
    if find_spec('numba') is None:
        raise MissingExtraError('numba', 'fast', "the backend 'numba'")
    from .numba_jit import NumbaBackend
    return NumbaBackend(line, input_names)
