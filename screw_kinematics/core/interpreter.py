# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: initializedcheck=False
"""
An interpreter of straight-line programs: no program is ever turned into machine code.

A program works on rows: inputs first, then constants, then what is being computed. For one sample
a row is a number; for a batch it is ``BLOCK`` numbers of as many samples, and every operation a
loop over these, of which the C compiler makes vector instructions. Both do the same operations in
the same order, so the results are the same to the last bit.

The code is runs of operations of one kind, so that what to do is decided once for each run. Each
run begins with a word of kind and number of operations, ``kind | number << 16``; then comes a word
for each operation, up to four rows of 16 bits, the target in the lowest. No operation writes a row
that it reads, an input or a constant. :mod:`screw_kinematics.programs.layout` writes such code.
"""
from __future__ import annotations

from array import array
from numbers import Real

try:
    import cython
except ImportError:
    from . import uncompiled as cython
if cython.compiled:
    from cython.cimports.cpython.buffer import (PyBUF_C_CONTIGUOUS, PyBUF_FORMAT, PyBuffer_Release,
                                                PyObject_GetBuffer)
    from cython.cimports.cpython.float import PyFloat_FromDouble
    from cython.cimports.cpython.ref import Py_INCREF
    from cython.cimports.cpython.tuple import PyTuple_New, PyTuple_SET_ITEM
    from cython.cimports.libc.math import cos, fabs, sin, sqrt
    from cython.cimports.libc.string import memcpy
else:
    from math import copysign, cos, fabs, sin, sqrt

COMPILED = cython.compiled
KINDS = 'muladd', 'mulsub', 'submul', 'div', 'sqrt', 'sincos'
"""What kinds 0 to 5 write: a b + c, a b - c, c - a b, a / b, root of a, and sine and cosine (a
second target) of an angle. Sums are products by one, products sums with -0, to the bit."""
MAX_ROWS = 1 << 16
MAX_PARTS = 5
"""Arrays that the inputs of a batch come in: q and four derivatives."""

LARGEST_ANGLE = cython.declare(cython.double, 1e5)
"""Beyond it sines and cosines are left to the C library [rad]."""

_BLOCK = cython.declare(cython.int, 64)
_MULADD = cython.declare(cython.ulonglong, 0)
_MULSUB = cython.declare(cython.ulonglong, 1)
_SUBMUL = cython.declare(cython.ulonglong, 2)
_DIV = cython.declare(cython.ulonglong, 3)
_SQRT = cython.declare(cython.ulonglong, 4)
_SINCOS = cython.declare(cython.ulonglong, 5)

# Adding and subtracting 1.5 * 2^52 rounds to the nearest integer.
_ROUND = cython.declare(cython.double, 6755399441055744.0)


def check_number(value) -> None:
    """Raise ValueError for a symbol, as of CasADi, which says of itself that it is NaN."""
    if not isinstance(value, Real):
        raise ValueError(f'{value!r} is no number; what runs on symbols is the text of '
                         "Program.source('python')")


def turned(x: cython.double) -> tuple[cython.double, cython.double]:
    """
    Return sine and cosine of an angle of at most ``LARGEST_ANGLE``.

    Nothing but sums and products, so that it becomes vector instructions, and serves arrays where
    it is interpreted. The error is below one unit in the last place of 1. Polynomials and the
    split of pi/2 are those of FreeBSD's ``k_sin.c``, ``k_cos.c`` and ``e_rem_pio2.c`` (Copyright
    1993 Sun Microsystems, Inc., freely redistributable).
    """
    n = (x * 0.6366197723675814 + _ROUND) - _ROUND
    # pi/2 in three parts of 33 bits: the first two products are exact.
    r = ((x - n * 1.57079632673412561417e+00) - n * 6.07710050630396597660e-11) \
        - n * 2.02226624879595063154e-21
    z = r * r
    s = r + r * z * (-1.66666666666666324348e-01 + z * (
        8.33333333332248946124e-03 + z * (-1.98412698298579493134e-04 + z * (
            2.75573137070700676789e-06 + z * (
                -2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))))
    h = 1.0 - 0.5 * z
    c = h + (((1.0 - h) - 0.5 * z) + z * z * (4.16666666666666019037e-02 + z * (
        -1.38888888888741095749e-03 + z * (2.48015872894767294178e-05 + z * (
            -2.75573143513906633035e-07 + z * (
                2.08757232129817482790e-09 - z * 1.13596475577881948265e-11))))))
    odd = n - 2.0 * (((n - 0.5) * 0.5 + _ROUND) - _ROUND)             # 0 or 1
    quadrant = n - 4.0 * (((n - 1.5) * 0.25 + _ROUND) - _ROUND)       # 0, 1, 2 or 3
    sign = 1.0 - (quadrant - odd)
    even = 1.0 - odd
    return sign * (odd * c + even * s), sign * (even - odd) * (odd * s + even * c)


def _far(x: cython.double) -> tuple[cython.double, cython.double]:
    """Return sine and cosine of a large angle; NaN of one that is not finite."""
    if fabs(x) < 1e300:
        return sin(x), cos(x)
    return x - x, x - x


def sine(x: cython.double) -> float:
    """Return the sine of any angle, as programs have it."""
    return (turned(x) if fabs(x) <= LARGEST_ANGLE else _far(x))[0]


def cosine(x: cython.double) -> float:
    """Return the cosine of any angle, as programs have it."""
    return (turned(x) if fabs(x) <= LARGEST_ANGLE else _far(x))[1]


def _root(x: cython.double) -> cython.double:
    """Return the square root, NaN of a negative number."""
    return sqrt(x) if cython.compiled or x >= 0.0 else float('nan')


def _quotient(x: cython.double, y: cython.double) -> cython.double:
    """Return x / y, infinite or NaN where y is 0."""
    if cython.compiled:
        return x / y
    else:
        return x / y if y else copysign(float('inf'), x) * copysign(
            1.0, y) if x < 0.0 or x > 0.0 else float('nan')


def _run(code: cython.ulonglong[::1], size: cython.Py_ssize_t, v: cython.double[::1],
         width: cython.Py_ssize_t) -> None:
    """Run a program on rows of `width` samples: a constant for the compiler, where inlined."""
    at: cython.Py_ssize_t = 0
    end: cython.Py_ssize_t
    kind: cython.ulonglong
    w: cython.ulonglong
    k: cython.Py_ssize_t
    o: cython.Py_ssize_t
    a: cython.Py_ssize_t
    b: cython.Py_ssize_t
    c: cython.Py_ssize_t
    far: cython.double
    while at < size:
        kind = code[at] & 0xffff
        end = at + 1 + (code[at] >> 16)
        at += 1
        if kind == _MULADD:
            while at < end:
                w = code[at]
                o, a = width * (w & 0xffff), width * (w >> 16 & 0xffff)
                b, c = width * (w >> 32 & 0xffff), width * (w >> 48)
                at += 1
                for k in range(width):
                    v[o + k] = v[a + k] * v[b + k] + v[c + k]
        elif kind == _MULSUB:
            while at < end:
                w = code[at]
                o, a = width * (w & 0xffff), width * (w >> 16 & 0xffff)
                b, c = width * (w >> 32 & 0xffff), width * (w >> 48)
                at += 1
                for k in range(width):
                    v[o + k] = v[a + k] * v[b + k] - v[c + k]
        elif kind == _SUBMUL:
            while at < end:
                w = code[at]
                o, a = width * (w & 0xffff), width * (w >> 16 & 0xffff)
                b, c = width * (w >> 32 & 0xffff), width * (w >> 48)
                at += 1
                for k in range(width):
                    v[o + k] = v[c + k] - v[a + k] * v[b + k]
        else:
            while at < end:
                w = code[at]
                o, a = width * (w & 0xffff), width * (w >> 16 & 0xffff)
                b = width * (w >> 32 & 0xffff)
                at += 1
                if kind == _DIV:
                    for k in range(width):
                        v[o + k] = _quotient(v[a + k], v[b + k])
                elif kind == _SQRT:
                    for k in range(width):
                        v[o + k] = _root(v[a + k])
                else:
                    far = 0.0
                    for k in range(width):
                        far = far if fabs(v[a + k]) <= LARGEST_ANGLE else 1.0
                        v[o + k], v[b + k] = turned(v[a + k])
                    if far > 0.0:
                        for k in range(width):
                            # Each by itself: a sample does not depend on its neighbours.
                            if not fabs(v[a + k]) <= LARGEST_ANGLE:
                                v[o + k], v[b + k] = _far(v[a + k])


def _run_one(code: cython.ulonglong[::1], size: cython.Py_ssize_t,
             v: cython.double[::1]) -> None:
    """Run a program on one sample."""
    _run(code, size, v, 1)


def _run_block(code: cython.ulonglong[::1], size: cython.Py_ssize_t,
               v: cython.double[::1]) -> int:
    """Run a program on a block of samples."""
    _run(code, size, v, _BLOCK)
    return 0


def _columns(part: cython.double[:, :], rows: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """Return how many columns a part has; far below 0 if it has not so many rows."""
    return part.shape[1] if part.shape[0] == rows else -(1 << 32)


def _gather(v: cython.double[::1], row: cython.Py_ssize_t, part: cython.double[:, :],
            start: cython.Py_ssize_t, count: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """Write a part of the samples into the rows from one on; return the row after the last."""
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    for k in range(count):
        for i in range(part.shape[1]):
            v[(row + i) * _BLOCK + k] = part[start + k, i]
    return row + part.shape[1]


class Interpreter:
    """
    One program and its memory.

    ``code``, of 'Q', has runs of operations; see the module. ``constants``, of 'd', are those of
    the rows after the inputs; ``outputs``, of 'Q', the row of each. ``width`` is how many numbers
    each part of the inputs has; see :meth:`sample`. ``slices`` have names of parts of the outputs;
    ``new_array`` returns a contiguous array of so many floats.

    Raises
    ------
    ValueError
        The code reads a row that is not there, or writes one that it must not.

    """

    def __init__(self, code: array, n_rows: int, n_inputs: int, constants: array,
                 outputs: array, width: int, slices: list, new_array) -> None:
        self.width, self.slices, self.new_array = width, slices, new_array
        self.n_inputs, self.n_constants, self.n_rows = n_inputs, len(constants), n_rows
        self.n_outputs, self.size = len(outputs), len(code)
        if not 0 <= n_inputs <= n_rows - len(constants) <= MAX_ROWS:
            raise ValueError(f'{n_rows} rows; allowed: as many as there are inputs and constants, '
                             f'and no more than {MAX_ROWS}')
        # One number more than needed, since a memoryview cannot be empty.
        self.code = memoryview(code + array('Q', [0]))
        self.outputs = memoryview(outputs + array('Q', [0]))
        self.v = memoryview(array('d', [0.0] * n_inputs) + constants
                            + array('d', [0.0] * (1 + n_rows - n_inputs - len(constants))))
        if not self.is_sound():
            raise ValueError('the code reads or writes outside of its rows')

    def is_sound(self) -> bool:
        """Return whether runs end with the code, and all rows may be used as they are."""
        i: cython.Py_ssize_t
        at: cython.Py_ssize_t = 0
        end: cython.Py_ssize_t
        kind: cython.ulonglong
        w: cython.ulonglong
        rows: cython.ulonglong = self.n_rows
        first: cython.ulonglong = self.n_inputs + self.n_constants
        size: cython.ulonglong = self.size
        for i in range(self.n_outputs):
            if self.outputs[i] >= rows:
                return False
        while at < self.size:
            kind = self.code[at] & 0xffff
            if kind > _SINCOS or self.code[at] >> 16 > size - at - 1:
                return False
            end = at + 1 + (self.code[at] >> 16)
            at += 1
            while at < end:
                w = self.code[at]
                at += 1
                if not (first <= w & 0xffff < rows and w >> 16 & 0xffff < rows
                        and w >> 32 & 0xffff < rows and w >> 48 < rows):
                    return False
                if kind == _SINCOS and w >> 32 & 0xffff < first:
                    return False
        return True

    @cython.boundscheck(True)
    def evaluate(self, values) -> tuple:
        """Return the outputs of a sample, as floats, from a sequence of floats."""
        i: cython.Py_ssize_t
        if len(values) != self.n_inputs:
            raise ValueError(f'{self.n_inputs} numbers are needed, not {len(values)}')
        for i in range(self.n_inputs):
            self.v[i] = values[i]
            if self.v[i] != self.v[i]:
                check_number(values[i])
        _run_one(self.code, self.size, self.v)
        if cython.compiled:
            results: tuple = PyTuple_New(self.n_outputs)
            for i in range(self.n_outputs):
                x: object = PyFloat_FromDouble(self.v[self.outputs[i]])
                Py_INCREF(x)        # the tuple takes a reference
                PyTuple_SET_ITEM(results, i, x)
            return results
        else:
            return tuple([self.v[row] for row in self.outputs[:self.n_outputs]])

    def sample(self, parts: tuple) -> dict | None:
        """
        Return the outputs of a sample by names; None if something does not fit.

        The inputs come in parts, contiguous arrays of float, shape (width,); more than there are
        inputs are passed over.
        """
        i: cython.Py_ssize_t
        width: cython.Py_ssize_t = self.width
        count: cython.Py_ssize_t = self.n_inputs // width if width > 0 else 0
        if count * width != self.n_inputs or len(parts) < count:
            return None
        for i in range(count):
            if not self.copy(parts[i], i * width, width, True):
                return None
        _run_one(self.code, self.size, self.v)
        out = self.new_array(self.n_outputs)
        if not self.copy(out, 0, self.n_outputs, False):
            return None
        results: dict = {}
        for name, part in self.slices:
            results[name] = out[part]
        return results

    def copy(self, numbers, row: cython.Py_ssize_t, count: cython.Py_ssize_t,
             inwards: cython.bint) -> cython.bint:
        """Read rows from an array, or write the outputs into one; return whether it fits."""
        i: cython.Py_ssize_t
        fits: cython.bint
        if cython.compiled:
            # A third of what a typed memoryview costs.
            view = cython.declare(Py_buffer)    # noqa: F821
            PyObject_GetBuffer(numbers, cython.address(view), PyBUF_C_CONTIGUOUS | PyBUF_FORMAT)
            fits = (view.ndim == 1 and view.shape[0] == count and view.itemsize == 8
                    and view.format[0] == b'd' and view.format[1] == 0)
            if fits:
                data: cython.p_double = cython.cast(cython.p_double, view.buf)
                if inwards:
                    memcpy(cython.address(self.v[row]), data, 8 * count)
                else:
                    for i in range(count):
                        data[i] = self.v[self.outputs[i]]
            PyBuffer_Release(cython.address(view))
        else:
            given = memoryview(numbers)
            fits = given.format == 'd' and given.shape == (count,) and given.contiguous
            if fits and inwards:
                self.v[row:row + count] = given
            elif fits:
                for i in range(count):
                    given[i] = self.v[self.outputs[i]]
        return fits

    def batch(self, start: cython.Py_ssize_t, stop: cython.Py_ssize_t,
              out: cython.double[:, ::1], q: cython.double[:, :],
              qd: cython.double[:, :], qdd: cython.double[:, :], qddd: cython.double[:, :],
              qdddd: cython.double[:, :]) -> bool:
        """
        Write the outputs of samples from `start` to `stop`; return False if sizes do not fit.

        The arrays have a row for each sample; `out` is contiguous, inputs need not be, and may
        have no columns. Other threads may run meanwhile, also in this function.
        """
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        count: cython.Py_ssize_t = out.shape[0]
        if (_columns(q, count) + _columns(qd, count) + _columns(qdd, count)
                + _columns(qddd, count) + _columns(qdddd, count) != self.n_inputs
                or out.shape[1] != self.n_outputs
                or not 0 <= start <= stop <= count):
            return False
        v: cython.double[::1] = memoryview(array('d', bytes(8 * (self.n_rows + 1) * _BLOCK)))
        for i in range(self.n_inputs, self.n_inputs + self.n_constants):
            for k in range(_BLOCK):
                v[i * _BLOCK + k] = self.v[i]
        with cython.nogil:
            while start < stop:
                count = stop - start
                count = _BLOCK if count > _BLOCK else count
                i = _gather(v, 0, q, start, count)
                i = _gather(v, i, qd, start, count)
                i = _gather(v, i, qdd, start, count)
                i = _gather(v, i, qddd, start, count)
                i = _gather(v, i, qdddd, start, count)
                _run_block(self.code, self.size, v)
                for k in range(count):
                    for i in range(self.n_outputs):
                        out[start + k, i] = v[self.outputs[i] * _BLOCK + k]
                start += count
        return True
