# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""States as tables, CSV or Parquet: one row per instant, columns named as in messages."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .history import History, QUANTITIES
from ..errors import optional_module, ToolError, UnknownNameError
from ..programs.quantities import find_quantity
from ..screws.se3 import Array

ENDINGS = ('.csv', '.parquet')
STAMP = 'stamp_ns'
_XYZ = ('x', 'y', 'z')
_POSE = (*(f'position.{c}' for c in _XYZ), *(f'orientation.{c}' for c in (*_XYZ, 'w')))
_SIX = (*(f'angular.{c}' for c in _XYZ), *(f'linear.{c}' for c in _XYZ))
_ROWS = 100_000      # of a row group


def columns(quantity: str) -> list[str]:
    """
    Return the names of the columns of a quantity.

    Examples
    --------
    >>> columns('twist')[2:4]
    ['twist.angular.z', 'twist.linear.x']

    """
    return [f'{quantity}.{part}' for part in (_POSE if quantity == 'pose' else _SIX)]


def unit(column: str) -> str:
    """
    Return the unit of a column.

    Examples
    --------
    >>> unit('accel.linear.x'), unit('pose.orientation.w'), unit('stamp_ns')
    ('m/s^2', '1', 'ns')

    """
    quantity, _, part = column.partition('.')
    if not part:
        return 'ns'
    first, second = find_quantity(quantity).parts
    return (first if part.startswith(('position', 'angular')) else second).unit


class TableWriter:
    """
    Writes states block by block, into a file ending in .csv or .parquet.

    Columns are in the order of the quantities. Parquet keeps what the states are about (robot,
    base_frame, tip_frame), and the units.
    """

    def __init__(self, path: Path, quantities: Sequence[str], about: Mapping[str, str]) -> None:
        arrow = self._arrow = optional_module('pyarrow', 'bag', 'writing tables')
        names = [name for quantity in quantities for name in columns(quantity)]
        self._schema = arrow.schema([
            arrow.field(name, kind, metadata={'unit': unit(name)}) for name, kind in
            [(STAMP, arrow.int64()), *((name, arrow.float64()) for name in names)]
        ]).with_metadata(dict(about))
        self._parts: list[Any] = []
        if path.suffix == '.csv':
            from pyarrow import csv
            self._writer: Any = csv.CSVWriter(str(path), self._schema)
        else:
            from pyarrow import parquet
            self._writer = parquet.ParquetWriter(str(path), self._schema)

    def write(self, stamps: Array, values: Sequence[Array]) -> None:
        """Append rows: stamps [ns], and for each quantity an array, of poses with quaternions."""
        arrays = [stamps, *(column for block in values for column in block.T)]
        self._parts.append(self._arrow.table(
            [np.ascontiguousarray(array) for array in arrays], schema=self._schema))
        if sum(part.num_rows for part in self._parts) >= _ROWS:
            self._flush()

    def close(self) -> None:
        """Write the rest."""
        self._flush()
        self._writer.close()

    def _flush(self) -> None:
        if self._parts:
            self._writer.write_table(self._arrow.concat_tables(self._parts))
            self._parts.clear()


def read_history(path: Path, quantities: Sequence[str]) -> History:
    """Return states out of a table."""
    arrow = optional_module('pyarrow', 'bag', 'reading tables')
    if path.suffix.lower() not in ENDINGS:
        raise ToolError(f'{path}: allowed: a file ending in {" or ".join(ENDINGS)}')
    try:
        if path.suffix.lower() == '.csv':
            from pyarrow import csv
            table = csv.read_csv(str(path))
        else:
            from pyarrow import parquet
            table = parquet.read_table(str(path))
    except FileNotFoundError:       # Arrow names the path alone
        raise ToolError(f'{path}: no such file') from None
    except arrow.ArrowInvalid as error:
        raise ToolError(f'{path}: {str(error).splitlines()[0]}') from None
    present = set(table.column_names)
    known = [q for q in QUANTITIES if present.issuperset(columns(q))]
    if STAMP not in present or table.num_rows == 0:
        raise ToolError(f'{path}: no column {STAMP!r} with values in it; allowed: a table '
                        'written by the tool bag')
    rows = {}
    for quantity in quantities:
        if quantity not in known:
            raise UnknownNameError(f'quantity in {path}', quantity, known)
        rows[quantity] = np.stack(
            [table.column(name).to_numpy() for name in columns(quantity)], axis=1)
    about = {key.decode(): value.decode()
             for key, value in (table.schema.metadata or {}).items() if b'.' not in key}
    return History.of_rows(
        about.get('robot', path.stem), about.get('base_frame', 'base'),
        about.get('tip_frame', 'tip'), table.column(STAMP).to_numpy(), rows)
