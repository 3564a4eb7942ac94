# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joint samples out of tables, CSV or Parquet: one row per instant."""
from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
import math
from pathlib import Path
import re
from typing import Any

import numpy as np

from .recording import Sample
from .table_columns import (by_name, by_number, echoed, is_stamp, named_unit, stamp_columns,
                            VELOCITY)
from ..errors import optional_module, ParameterError, ToolError
from ..messages.joint_state import JointSample
from ..screws.se3 import Array

ENDINGS = ('.csv', '.csv.gz', '.txt', '.parquet')
TIME_UNITS = {'s': 10**9, 'ms': 10**6, 'us': 10**3, 'ns': 1}
UNITS = {'rad': 1.0, 'deg': math.pi / 180}
LENGTHS = {'m': 1.0, 'mm': 1e-3}
_RATES = (10.0, 5000.0)      # of joint states [Hz]: tells the unit of stamps without an epoch
_EPOCH = 10**17              # stamps beyond [ns], some three years, count from 1970
_LATEST = 4 * 10**18         # and these are of the next century
_TURNS = 4 * math.pi         # a limited joint turns no further to either side
_REACH = 20.0                # nor is a slide longer [m]
_SHOWN = 20                  # names in a message
_DISORDER = 0.1              # share of the rows that are out of order: nobody sorted them


@dataclass(frozen=True)
class TableFormat:
    """
    What is stated about tables; the rest is recognised.

    Columns are by a joint's name, a joint's name with '.velocity' behind it, or 'stamp'.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    angle: str = ''     # of positions: rad or deg; empty: as the columns' names say, else rad
    length: str = ''    # m or mm; likewise
    time: str = ''      # unit of the stamps: s, ms, us or ns; empty: recognised
    epoch: int = 0      # what is added to the stamps [ns]


@dataclass(frozen=True)
class _Columns:
    """The columns of the stamps, of the joints' positions and, unless empty, velocities."""

    stamp: tuple[str, ...]
    position: tuple[str, ...]
    velocity: tuple[str, ...]


class JointTable:
    """A table of joint samples, in a file ending in .csv, .csv.gz, .txt or .parquet."""

    def __init__(self, path: Path, stated: TableFormat | None = None) -> None:
        self.path = path
        self.stated = stated or TableFormat()
        self.damage: list[str] = []

    def columns(self) -> list[str]:
        """Return the names of the columns."""
        return [str(name) for name in next(self._batches()).schema.names]

    def samples(self, joints: Mapping[str, str]) -> Iterator[Sample]:
        """
        Yield the samples in the order of the rows, of joints whose kinds are given by name.

        Raises
        ------
        ToolError
            Not a table, or columns are missing or ambiguous; units are not what they are
            taken for. The message says what was seen.

        """
        columns: _Columns | None = None
        names = tuple(joints)
        scale, faster, unit, row, back = np.zeros(0), np.zeros(0), 0, 0, 0
        for batch in self._batches():
            if columns is None:
                columns = self._match(batch, names)
                scale = self._scale(columns.position, joints)
                faster = self._scale(columns.velocity, joints, scale)
            if not batch.num_rows:
                continue
            stamps, dates = self._stamps(batch, columns.stamp)
            if not unit:
                unit = 1 if dates else self._time_unit(columns.stamp, stamps)
            times = [int((stamp * unit).to_integral_value()) + self.stated.epoch
                     for stamp in stamps]
            if max(map(abs, times)) >= 2**63:
                raise ToolError(f'{self.path}: stamps begin with {stamps[0]}, which is no time in '
                                f'the unit that is stated or named; state it by --time-unit '
                                f'{", ".join(TIME_UNITS)}')
            position = self._numbers(batch, columns.position) * scale
            self._check_units(names, list(joints.values()), position, row)
            velocity = (self._numbers(batch, columns.velocity) * faster).tolist() if (
                columns.velocity) else [()] * len(times)
            for stamp, q, qd in zip(times, position.tolist(), velocity):
                yield '', stamp, JointSample(stamp, names, tuple(q), tuple(qd))
            row += len(times)
            back += sum(after < before for before, after in zip(times, times[1:]))
        if columns is None:
            raise ToolError(f'{self.path}: no rows')
        if back > _DISORDER * row:
            self.damage.append(f'{self.path}: stamps go back in {back} of {row} rows: sort them '
                               f'by {columns.stamp[0]!r}')

    def _batches(self) -> Iterator[Any]:
        """Yield Arrow tables of some thousand rows."""
        pyarrow = optional_module('pyarrow', 'bag', 'reading tables')
        lengths: dict[str, int] = {}
        try:
            for batch in self._read():
                batch.schema.names      # decodes them
                yield self._without_lists(batch, lengths)
        except UnicodeDecodeError:
            raise ToolError(f'{self.path}: the names of its columns are not in UTF-8') from None
        except (pyarrow.ArrowException, OSError) as error:
            raise ToolError(f'{self.path}: {str(error).splitlines()[0]}') from None

    def _without_lists(self, batch: Any, lengths: dict[str, int]) -> Any:
        """Return a batch in which each place of lists, such as of a message, is a column."""
        from pyarrow import compute, RecordBatch, types
        columns: list[tuple[str, Any]] = []
        for name, column in zip(batch.schema.names, batch.columns):
            if not (types.is_list(column.type) or types.is_large_list(column.type)
                    or types.is_fixed_size_list(column.type)):
                columns.append((name, column))
                continue
            found = compute.unique(compute.list_value_length(column)).to_pylist()
            length = lengths.setdefault(name, found[0] if found else 0)
            if found not in ([], [length]) or length is None:
                raise ToolError(f'{self.path}: column {name!r} has lists of different lengths '
                                f'({", ".join(map(str, found))}); allowed: of one')
            columns += [(f'{name}[{i}]', compute.list_element(column, i)) for i in range(length)]
        return RecordBatch.from_arrays([column for _, column in columns],
                                       [name for name, _ in columns])

    def _read(self) -> Iterator[Any]:
        """Yield what Arrow reads; stamps in text keep all their digits."""
        import pyarrow
        from pyarrow import csv, parquet
        if self.path.suffix.lower() == '.parquet':
            yield from parquet.ParquetFile(self.path).iter_batches(16_384)
            return
        packed = 'gzip' if self.path.suffix.lower() == '.gz' else None
        with pyarrow.input_stream(str(self.path), compression=packed) as stream:
            lines = stream.read(1 << 16).splitlines()
        # A character may be cut where the line did not end.
        head = lines[0].decode('utf-8-sig', 'strict' if lines[1:] else 'ignore') if lines else ''
        # Names have blanks too.
        separator = max(',;\t' if {*head} & {*',;\t'} else ' ', key=head.count)
        names = [name.strip('"') for name in head.split(separator)]
        options: dict[str, Any] = {'block_size': 1 << 22, 'use_threads': False}
        if head.startswith('#'):        # as numpy.savetxt writes it
            names = [name.strip() for name in head[1:].strip().split(separator)]
            options.update(skip_rows=1, column_names=names)
        types = {name: pyarrow.string() for name in names
                 if is_stamp(name) or name == self.stated.columns.get('stamp')}
        uneven: list[int] = []

        def skip(row: Any) -> str:
            uneven.append(row.number or 0)
            return 'skip'

        def table(types: Mapping[str, Any]) -> Any:
            uneven.clear()
            return csv.open_csv(
                stack.enter_context(pyarrow.input_stream(str(self.path), compression=packed)),
                csv.ReadOptions(**options),
                csv.ParseOptions(delimiter=separator, invalid_row_handler=skip),
                csv.ConvertOptions(column_types=types))

        with ExitStack() as stack:
            # What begins with whole numbers, or with none, may go on with others.
            yield from table({**types, **{
                column.name: pyarrow.float64() for column in table(types).schema
                if pyarrow.types.is_integer(column.type) or pyarrow.types.is_null(column.type)}})
        if uneven:
            self.damage = [f'{self.path}: rows with more or fewer cells than names: '
                           f'{len(uneven)}, the first is row {uneven[0] - 1}']

    def _match(self, batch: Any, joints: Sequence[str]) -> _Columns:
        """Return which columns are which."""
        there = list(batch.schema.names)
        stated = self.stated.columns
        for what, column in stated.items():
            if column not in there:
                raise ParameterError(f'columns {what}', column, f'of {self.path}: '
                                     f'{_listed(there)}')
        if 'stamp' in stated:
            stamp: tuple[str, ...] | None = (stated['stamp'],)
        else:
            stamp = stamp_columns(there)
        if stamp is None:
            raise ToolError(f'{self.path}: no column of stamps; seen: {_listed(there)}; name it '
                            'by --columns stamp=COLUMN')
        try:
            named = by_name(there, joints)
        except ToolError as error:
            raise ToolError(f'{self.path}: {error}') from None
        found = {**by_number(there, joints), **named, **echoed(batch), **stated}
        missing = [name for name in joints if name not in found]
        if missing:
            raise ToolError(
                f'{self.path}: no column for the position of {_listed(missing)}; seen: '
                f'{_listed(there)}; name them by --columns {missing[0]}=COLUMN')
        velocity = [found.get(name + VELOCITY) for name in joints]
        columns = _Columns(stamp, tuple(found[name] for name in joints),
                           tuple(str(name) for name in velocity) if all(velocity) else ())
        for name in (*columns.stamp, *columns.position, *columns.velocity):
            if there.count(name) > 1:
                raise ToolError(f'{self.path}: column {name!r} is there {there.count(name)} '
                                'times; rename all but one')
        return columns

    def _scale(self, columns: Sequence[str], joints: Mapping[str, str],
               of_position: Array | None = None) -> Array:
        """
        Return the factors to rad and m: as a column's name says, as stated, or as they are.

        Velocities, whose units are stated by their names alone, are else in those of the position.
        """
        factors = np.ones(len(joints)) if of_position is None else of_position.copy()
        for i, (column, (joint, kind)) in enumerate(zip(columns, joints.items())):
            stated, units = (self.stated.length, LENGTHS) if kind == 'prismatic' else (
                self.stated.angle, UNITS)
            named = named_unit(column, joint, units)
            if of_position is None:
                if stated and named and stated != named:
                    raise ParameterError('units', stated, f'{named}, as column {column!r} of '
                                         f'{self.path} says; or rename it')
                named = stated or named
            if named:
                factors[i] = units[named]
        return factors

    def _stamps(self, batch: Any, columns: Sequence[str]) -> tuple[list[Decimal], bool]:
        """Return the stamps as they are written, and whether they are dates: in ns since 1970."""
        import pyarrow
        first, *rest = parts = [batch.column(name) for name in columns]
        if any(part.null_count for part in parts):
            raise ToolError(f'{self.path}: a stamp in column {columns[0]!r} is missing')
        dates = pyarrow.types.is_temporal(first.type)
        try:
            stamps = [] if dates else [Decimal(value) for value in first.to_pylist()]
            if rest:
                stamps = [s * 10**9 + Decimal(ns) for s, ns in zip(stamps, rest[0].to_pylist())]
        except (InvalidOperation, TypeError, ValueError):
            dates = True
        if dates:
            stamps = [Decimal(ns) for ns in self._since_1970(columns[0], first)]
        if not all(stamp.is_finite() for stamp in stamps):
            raise ToolError(f'{self.path}: a stamp in column {columns[0]!r} is not finite')
        return stamps, dates

    def _since_1970(self, name: str, column: Any) -> list[int]:
        """Return dates in ns since 1970, and durations in ns; Arrow keeps all their digits."""
        from pyarrow import ArrowException, compute, duration, int64, timestamp, types
        if types.is_string(column.type):
            column = compute.replace_substring(column, ',', '.')
        kinds = [duration('ns')] if types.is_duration(column.type) else [
            timestamp('ns'), timestamp('ns', 'UTC')]

        def told(part: Any) -> list[int] | None:
            for kind in kinds:
                try:
                    return list(map(int, part.cast(kind).cast(int64()).to_pylist()))
                except (ArrowException, TypeError):
                    pass
            return None

        stamps = told(column)
        if stamps is None:      # with time zones here and there
            single = [told(column.slice(i, 1)) for i in range(len(column))]
            if None in single:
                raise ToolError(f'{self.path}: a stamp in column {name!r} is '
                                f'{str(column[single.index(None)])!r}; allowed: a number or an '
                                'ISO date')
            stamps = [stamp for one in single if one for stamp in one]
        return stamps

    def _time_unit(self, columns: Sequence[str], stamps: Sequence[Decimal]) -> int:
        """Return how many ns a stamp's unit has."""
        if self.stated.time:
            return TIME_UNITS[self.stated.time]
        if len(columns) == 2 or columns[0] in ('%time', 'field.header.stamp'):
            return 1
        named = re.search(r'(?:^|[\W_])(ns|us|ms|s|sec|secs|seconds)\W*$', columns[0].lower())
        if named:
            return TIME_UNITS[named[1] if named[1] in TIME_UNITS else 's']
        first = abs(stamps[0])
        for unit in TIME_UNITS.values():
            if _EPOCH * 10 < first * unit < _LATEST:     # from 2001 on
                return unit
        steps = [float(b - a) for a, b in zip(stamps, stamps[1:]) if b > a]
        step = float(np.median(steps)) if steps else 0.0
        for unit in TIME_UNITS.values():
            if step and _RATES[0] <= 1e9 / (step * unit) <= _RATES[1]:
                return unit
        raise ToolError(
            f'{self.path}: stamps begin with {stamps[0]} and advance by {step:g} a row, which is '
            f'{_RATES[0]:g} to {_RATES[1]:g} rows a second in no unit; state it by --time-unit '
            f'{", ".join(TIME_UNITS)}')

    def _numbers(self, batch: Any, columns: Sequence[str]) -> Array:
        """Return columns of numbers, shape (rows, columns); NaN where a cell is empty."""
        import pyarrow
        out = np.empty((batch.num_rows, len(columns)))
        for i, name in enumerate(columns):
            try:
                out[:, i] = batch.column(name).cast(pyarrow.float64()).to_numpy(
                    zero_copy_only=False)
            except pyarrow.ArrowException:
                raise ToolError(f'{self.path}: column {name!r} holds '
                                f'{batch.column(name).type} values; allowed: numbers') from None
        return out

    def _check_units(self, names: Sequence[str], kinds: Sequence[str], position: Array,
                     row: int) -> None:
        """Raise ToolError if positions cannot be in the units they are taken for."""
        if self.stated.angle or self.stated.length:
            return
        for i, (name, kind) in enumerate(zip(names, kinds)):
            limit, other = (_REACH, 'm or mm') if kind == 'prismatic' else (_TURNS, 'rad or deg')
            size = np.abs(position[:, i])
            far = np.isfinite(size) & (size > limit)
            if kind != 'continuous' and far.any():
                at = int(np.argmax(far))
                raise ToolError(
                    f'{self.path}: joint {name} ({kind}) is at {position[at, i]:g} in row '
                    f'{row + at + 1}; what unit is that? state it by --units {other}')


def _listed(names: Sequence[str]) -> str:
    more = len(names) - _SHOWN
    return ', '.join(names[:_SHOWN]) + (f' and {more} more' if more > 0 else '')
