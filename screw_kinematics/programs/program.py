# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A compiled chain: one call from joint motion to the motion of the tip."""
from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from keyword import iskeyword
from typing import Any

import numpy as np

from .c_text import c_header, c_source
from .machine import machine
from .python_text import named_source
from .quantities import find_quantity
from .straight_line_program import StraightLineProgram
from ..errors import InvalidValueError, ShapeError, UnknownNameError
from ..screws.se3 import Array
from ..screws.vectors import checked_array

DERIVATIVES = ('q', 'qd', 'qdd', 'qddd', 'qdddd')

MEANINGS = {
    'q': 'positions [rad, m]',
    'qd': 'velocities [rad/s, m/s]',
    **{key: f'{what} [rad/s^{n}, m/s^{n}]' for n, (key, what) in enumerate(
        zip(DERIVATIVES[2:], ('accelerations', 'jerks', 'snaps')), start=2)}}
"""What the arrays of joints are, for comments in source text."""


class Program:
    """
    The straight-line program of a chain, and the machine that runs it.

    Made by ``chain.compile(...)``. Six-vectors are angular first, SI units.

    Parameters
    ----------
    line : StraightLineProgram
        What it runs.
    sizes : mapping from str to int
        Names of the outputs, in order, and how many numbers each has.
    joint_names : sequence of str
        Measured joints: the order of the entries of q.
    order : int
        Highest derivative of q among the inputs.
    axes, pole : {'base', 'tip'}
        Whose axes the six-vectors are in, and which point they refer to.
    base_frame, tip_frame : str
        Names for headings.

    Attributes
    ----------
    inputs : int
        Numbers that ``evaluate`` takes: q, then qd, ... up to ``order``.
    slices : dict from str to slice
        Where each output is in the result of ``evaluate``.
    evaluate : callable
        From a sequence of ``inputs`` floats to a tuple of floats, all outputs one after
        the other; the shortest way for one sample. NaN goes through; infinite angles and
        divisions by zero give NaN and infinity. Symbols raise ValueError: see ``source``.

    """

    def __init__(self, line: StraightLineProgram, sizes: Mapping[str, int],
                 joint_names: Sequence[str], order: int, axes: str = 'base',
                 pole: str = 'tip', base_frame: str = 'base', tip_frame: str = 'tool') -> None:
        self.line = line
        self.outputs = tuple(sizes)
        self.joint_names = tuple(joint_names)
        self.dof = len(self.joint_names)
        self.order = order
        self.inputs = (order + 1) * self.dof
        self.axes, self.pole = axes, pole
        self.base_frame, self.tip_frame = base_frame, tip_frame
        ends = np.cumsum([0, *sizes.values()]).tolist()
        self.slices = {name: slice(a, b) for name, a, b in zip(sizes, ends, ends[1:])}
        self._machine = machine(line, self.dof, self.slices)
        self._sample = self._machine.sample
        self.evaluate: Callable[[Sequence[float]], Sequence[float]] = self._machine.evaluate

    def __repr__(self) -> str:
        return (f'Program({", ".join(self.outputs)}; {self.dof} joints, axes of the '
                f'{self.axes}, pole at the {self.pole})')

    def __call__(self, *motion: Any) -> dict[str, Array]:
        """
        Return the outputs for one sample.

        Parameters
        ----------
        *motion : array, shape (dof,)
            q and its derivatives up to at least ``order``.

        Returns
        -------
        dict from str to array, shape (size of the output,)

        """
        try:
            results = self._sample(motion)
        except (TypeError, ValueError):     # no contiguous arrays
            results = None
        if results is None:
            results = self._sample(tuple(self._checked(motion, 1)))
            assert results is not None
        return results

    def batch(self, *motion: Any, out: Array | None = None,
              threads: int = 2) -> dict[str, Array]:
        """
        Return the outputs for many samples.

        Parameters
        ----------
        *motion : array, shape (N, dof)
            q and its derivatives up to at least ``order``.
        out : array, shape (N, size of all outputs), optional
            Where the results go; contiguous, float. New memory costs about as much time
            as the computation.
        threads : int
            Most threads that long batches are shared by, this one included. Where the core is
            not compiled there is one.

        Returns
        -------
        dict from str to array, shape (N, size of the output)
            The pose is a row of twelve numbers: position, then rotation by rows, which
            :func:`~screw_kinematics.screws.rigid.pose_from_row` makes a (4, 4) matrix.
            Views of ``out``.

        """
        parts = self._checked(motion, 2)
        results = self._results(len(parts[0]), out)
        self._machine.batch(parts, results, threads)
        return {name: results[:, part] for name, part in self.slices.items()}

    @property
    def operations(self) -> int:
        """Return how many operations a sample takes, sines and cosines included."""
        return len(self.line.operations)

    def source(self, language: str, name: str = 'tip_motion') -> str:
        """
        Return the program as source text.

        Parameters
        ----------
        language : {'python', 'c', 'c_header'}
            Python needs only ``math``: a function of q, qd, ... that returns a dictionary. C is
            C99 and needs only ``math.h`` and the header, which belongs into the file
            ``<name>.h``.
        name : str
            Name of the function.

        Returns
        -------
        str
            The text of a file.

        Raises
        ------
        UnknownNameError, InvalidValueError
            The language is unknown, or the name is no identifier.

        """
        inputs = {key: self.dof for key in DERIVATIVES[:self.order + 1]}
        sizes = {key: part.stop - part.start for key, part in self.slices.items()}
        if language == 'c':
            return c_source(self.line, name, inputs, sizes)
        if language == 'c_header':
            return c_header(name, inputs, sizes, self._comment(name))
        if language != 'python':
            raise UnknownNameError('language', language, ('python', 'c', 'c_header'))
        if not name.isidentifier() or iskeyword(name):
            raise InvalidValueError(f'{name!r} is no name of a Python function')
        text = named_source(self.line, name, inputs, sizes, self._comment(name))
        return f'from math import cos, sin, sqrt\n\n\n{text}'

    def _comment(self, name: str) -> str:
        """Return what the program computes, in words."""
        rows = [f'{name}: motion of {self.tip_frame} relative to {self.base_frame}. '
                'SI units.', '', f'Joints: {", ".join(self.joint_names) or "none"}.']
        rows += [f'{key}: joint {MEANINGS[key]}' for key in DERIVATIVES[:self.order + 1]]
        rows += [f'{key}: {find_quantity(key, self.outputs).described()}' for key in self.outputs]
        if set(self.outputs) != {'pose'}:
            rows += ['', f'Six-vectors: angular first, axes of {self._frame(self.axes)}, '
                     f'reference point at the origin of {self._frame(self.pole)}.']
        return '\n'.join(rows)

    def _frame(self, which: str) -> str:
        return self.base_frame if which == 'base' else self.tip_frame

    def continue_from(self, before: Program) -> None:
        """
        Do nothing: samples of an open chain are independent; see ParallelProgram.

        Parameters
        ----------
        before : Program
            The one that evaluated the samples so far.

        """

    def _results(self, n_samples: int, out: Array | None) -> Array:
        """Return the array that the results of a batch go to."""
        shape = (n_samples, len(self.line.outputs))
        if out is None:
            return np.empty(shape)
        if out.shape != shape:
            raise ShapeError('out', f'{shape}', out.shape)
        if out.dtype != float or not out.flags.c_contiguous:
            raise InvalidValueError('out must be a contiguous array of float64, got '
                                    f'{out.dtype}, strides {out.strides}')
        return out

    def _checked(self, motion: Sequence[Any], ndim: int) -> list[Array]:
        needed = DERIVATIVES[:self.order + 1]
        if len(motion) < len(needed):
            raise InvalidValueError(
                f'{self!r} needs {", ".join(needed)}; got {len(motion)} of them')
        parts = []
        for name, part in zip(needed, motion):
            array = checked_array(name, part, (...,))
            if array.dtype == object:
                raise InvalidValueError(f'{name} must be numbers, got {array.tolist()!r}')
            parts.append(np.ascontiguousarray(array, dtype=float))
        expected = ((len(parts[0]),) if ndim == 2 and parts[0].ndim else ()) + (self.dof,)
        for name, part in zip(needed, parts):
            if part.ndim != ndim or part.shape != expected:
                shape = f'({"N, " if ndim == 2 else ""}{self.dof}{"," if ndim == 1 else ""})'
                raise ShapeError(name, shape + ', all alike', part.shape)
        return parts
