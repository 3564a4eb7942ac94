# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Sine and cosine, and the transposition of blocks, in forms that LLVM vectorises.

Imported where Numba is installed. The compiler cannot vectorise calls of the C library's
sine; the formulas below are branch-free, so that one instruction works on as many samples
as the processor's registers hold.

References
----------
The polynomials and the split of pi/2 are those of FreeBSD's ``k_sin.c``, ``k_cos.c`` and
``e_rem_pio2.c`` (Copyright 1993 Sun Microsystems, Inc., freely redistributable).

"""
from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

LARGEST_ANGLE = 1e5
"""Beyond it the reduction by multiples of pi/2 loses accuracy [rad]."""

TILE = 4
"""Rows and columns that are transposed at once."""

# Adding and subtracting 1.5 * 2^52 rounds to the nearest integer.
_ROUND = 6755399441055744.0


@njit(inline='always')
def sincos(x: float) -> tuple[float, float]:
    """
    Return sine and cosine of an angle of at most ``LARGEST_ANGLE``.

    The error is below one unit in the last place of 1.

    Parameters
    ----------
    x : float
        Angle [rad].

    """
    quarters = (x * 0.6366197723675814 + _ROUND) - _ROUND
    # pi/2 in three parts of 33 bits: the first two products are exact.
    r = ((x - quarters * 1.57079632673412561417e+00)
         - quarters * 6.07710050630396597660e-11) - quarters * 2.02226624879595063154e-21
    z = r * r
    s = r + r * z * (-1.66666666666666324348e-01 + z * (
        8.33333333332248946124e-03 + z * (-1.98412698298579493134e-04 + z * (
            2.75573137070700676789e-06 + z * (
                -2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))))
    most = 1.0 - 0.5 * z
    c = most + (((1.0 - most) - 0.5 * z) + z * z * (4.16666666666666019037e-02 + z * (
        -1.38888888888741095749e-03 + z * (2.48015872894767294178e-05 + z * (
            -2.75573143513906633035e-07 + z * (
                2.08757232129817482790e-09 - z * 1.13596475577881948265e-11))))))
    quadrant = quarters - 4.0 * ((((quarters - 1.5) * 0.25) + _ROUND) - _ROUND)
    odd = quadrant == 1.0 or quadrant == 3.0
    sine, cosine = (c, s) if odd else (s, c)
    if quadrant >= 2.0:
        sine = -sine
    if quadrant == 1.0 or quadrant == 2.0:
        cosine = -cosine
    return sine, cosine


def _tile(past_the_cache: bool) -> Any:
    """
    Return a function that transposes four by four numbers.

    Halves of rows are joined while they are loaded, which leaves only four shuffles; in a
    plain loop LLVM would move the numbers one by one.
    """
    half, whole = (ir.VectorType(ir.DoubleType(), n) for n in (2, 4))
    pair, four = (ir.VectorType(ir.IntType(32), n) for n in (2, 4))

    @intrinsic
    def tile(typing_context: Any, target: Any, target_start: Any, target_step: Any,
             source: Any, source_start: Any, source_step: Any) -> Any:
        signature = types.void(target, types.intp, types.intp, source, types.intp, types.intp)

        def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
            def pointer(array: int, row: int, column: int, kind: Any) -> Any:
                data = context.make_array(sig.args[array])(
                    context, builder, arguments[array]).data
                start, step = arguments[array + 1], arguments[array + 2]
                offset = builder.add(start, builder.mul(step, step.type(row)))
                offset = builder.add(offset, step.type(column))
                return builder.bitcast(builder.gep(data, [offset]), kind.as_pointer())

            def load(row: int, column: int) -> Any:
                return builder.load(pointer(3, row, column, half), align=8)

            def store(row: int, vector: Any) -> None:
                if not past_the_cache:
                    builder.store(vector, pointer(0, row, 0, whole), align=8)
                    return
                for k in (0, 2):
                    part = builder.shuffle_vector(vector, vector, pair([k, k + 1]))
                    written = builder.store(part, pointer(0, row, k, half), align=16)
                    written.set_metadata('nontemporal', builder.module.add_metadata(
                        [ir.IntType(32)(1)]))

            for column in (0, 2):
                upper, lower = (builder.shuffle_vector(
                    load(row, column), load(row + 2, column), four([0, 1, 2, 3]))
                    for row in (0, 1))
                for k in (0, 1):
                    store(column + k, builder.shuffle_vector(
                        upper, lower, four([k, 4 + k, 2 + k, 6 + k])))
            return context.get_dummy_value()

        return signature, generate

    return tile


_transpose_tile, _transpose_tile_past_the_cache = _tile(False), _tile(True)


@njit
def transpose(target: Any, target_start: int, target_step: int, source: Any,
              source_start: int, source_step: int, rows: int, columns: int,
              past_the_cache: bool) -> None:
    """
    Write the transposed of a matrix within one flat array into another flat array.

    Entry (r, c) of the source is at ``source_start + r * source_step + c``, and goes to
    ``target_start + c * target_step + r``.

    Writing past the cache spares reading what is overwritten. It is for results larger
    than the cache, in memory that starts at a multiple of 16 bytes, with all starts,
    steps and sizes on the target's side even.
    """
    if rows < TILE or columns < TILE:
        for r in range(rows):
            for c in range(columns):
                target[target_start + c * target_step + r] = \
                    source[source_start + r * source_step + c]
        return
    long, short = max(rows, columns), min(rows, columns)
    # Samples are in the outer loop, so that whole cache lines are read or written in turn.
    for i in range(0, long, TILE):
        # The last tiles overlap those before them when the size is no multiple.
        i = min(i, long - TILE)
        for j in range(0, short, TILE):
            j = min(j, short - TILE)
            r, c = (i, j) if rows > columns else (j, i)
            to, at = target_start + c * target_step + r, source_start + r * source_step + c
            if past_the_cache:
                _transpose_tile_past_the_cache(target, to, target_step, source, at, source_step)
            else:
                _transpose_tile(target, to, target_step, source, at, source_step)
