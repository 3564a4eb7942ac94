# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Joint samples out of tables, CSV or Parquet: one row per instant.

Joints are found by the names of the columns: by the joint's own name, by a number (``q1`` to
``qn``, ``position[0]`` ...), as ``rostopic echo -p`` and PlotJuggler write them, or as stated.
"""
from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timezone
from decimal import Decimal, InvalidOperation
import math
from pathlib import Path
import re
from typing import Any

import numpy as np

from .recording import Sample
from ..errors import MissingExtraError, ParameterError, ToolError
from ..messages.joint_state import JointSample
from ..screws.se3 import Array

ENDINGS = ('.csv', '.csv.gz', '.txt', '.parquet')
TIME_UNITS = {'s': 10**9, 'ms': 10**6, 'us': 10**3, 'ns': 1}
UNITS = {'rad': 1.0, 'deg': math.pi / 180}
LENGTHS = {'m': 1.0, 'mm': 1e-3}

VELOCITY = '.velocity'
"""Ending of a joint's name in ``TableFormat.columns`` that means its velocity."""

_STAMPS = ('stamp_ns', 'stamp', 'header.stamp', 'field.header.stamp', 'timestamp', '__time',
           'time', '%time', 't', 'time_s', 'time_ns', 'timestamp_ns')
_SECONDS = (('header.stamp.sec', 'header.stamp.nanosec'), ('sec', 'nanosec'), ('secs', 'nsecs'))
_VELOCITY = {'velocity', 'velocities', 'vel', 'qd', 'dq', 'qdot', 'speed', 'v', 'omega'}
_POSITION = {'position', 'positions', 'pos', 'q', 'angle', 'angles', 'joint', 'j', 'theta'}
_OTHER = {'effort', 'torque', 'tau', 'current', 'acc', 'acceleration', 'accelerations', 'qdd',
          'ddq', 'desired', 'target', 'command', 'cmd', 'setpoint', 'temperature', 'name'}
_RATES = (10.0, 5000.0)      # of joint states [Hz]: tells the unit of stamps without an epoch
_EPOCH = 10**17              # stamps beyond [ns], some three years, count from 1970
_LATEST = 4 * 10**18         # and these are of the next century
_TURNS = 4 * math.pi         # a limited joint turns no further to either side
_REACH = 20.0                # nor is a slide longer [m]
_SHOWN = 20                  # names in a message


@dataclass(frozen=True)
class TableFormat:
    """
    What is stated about tables; the rest is recognised.

    Columns are by a joint's name, a joint's name with '.velocity' behind it, or 'stamp'.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    angle: str = ''     # rad or deg; empty: as the columns' names say, else rad
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
        scale, unit, row = np.zeros(0), 0, 0
        for batch in self._batches():
            if columns is None:
                columns = self._match(batch, names)
                scale = self._scale(columns, joints)
            stamps = self._stamps(batch, columns.stamp)
            if not unit:
                unit = self._time_unit(columns.stamp, stamps)
            times = [int((stamp * unit).to_integral_value()) + self.stated.epoch
                     for stamp in stamps]
            position = self._numbers(batch, columns.position) * scale
            self._check_units(names, list(joints.values()), position, row)
            velocity = (self._numbers(batch, columns.velocity) * scale).tolist() if (
                columns.velocity) else [()] * len(times)
            for stamp, q, qd in zip(times, position.tolist(), velocity):
                yield '', stamp, JointSample(stamp, names, tuple(q), tuple(qd))
            row += len(times)
        if columns is None:
            raise ToolError(f'{self.path}: no rows')

    def _batches(self) -> Iterator[Any]:
        """Yield Arrow tables of some thousand rows."""
        try:
            import pyarrow
        except ImportError:
            raise MissingExtraError('pyarrow', 'bag', 'reading tables') from None
        try:
            for batch in self._read():
                batch.schema.names      # decodes them
                yield batch
        except UnicodeDecodeError:
            raise ToolError(f'{self.path}: the names of its columns are not in UTF-8') from None
        except (pyarrow.ArrowException, OSError) as error:
            raise ToolError(f'{self.path}: {str(error).splitlines()[0]}') from None

    def _read(self) -> Iterator[Any]:
        """Yield what Arrow reads; stamps in text keep all their digits."""
        import pyarrow
        from pyarrow import csv, parquet
        if self.path.suffix == '.parquet':
            yield from parquet.ParquetFile(self.path).iter_batches(16_384)
            return
        with pyarrow.input_stream(str(self.path), compression='detect') as stream:
            lines = stream.read(1 << 16).splitlines()
        # A character may be cut where the line did not end.
        head = lines[0].decode('utf-8-sig', 'strict' if lines[1:] else 'ignore') if lines else ''
        # Names have blanks too.
        separator = max(',;\t' if {*head} & {*',;\t'} else ' ', key=head.count)
        stamps = {name.strip(' "'): pyarrow.string() for name in head.split(separator)
                  if name.strip(' "').lower() in _STAMPS
                  or name.strip(' "') == self.stated.columns.get('stamp')}
        with pyarrow.input_stream(str(self.path), compression='detect') as stream:
            yield from csv.open_csv(
                stream, csv.ReadOptions(block_size=1 << 22),
                csv.ParseOptions(delimiter=separator),
                csv.ConvertOptions(column_types=stamps))

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
        found = {**by_number(there, joints), **self._by_name(there, joints), **_echoed(batch),
                 **stated}
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

    def _by_name(self, there: Sequence[str], joints: Sequence[str]) -> dict[str, str]:
        """Return columns that hold a joint's name, by joint."""
        found: dict[str, str] = {}
        for column in dict.fromkeys(there):
            named = [name for name in joints if re.search(
                f'(?<![A-Za-z0-9]){re.escape(name)}(?![A-Za-z0-9])', column)]
            if not named:
                continue
            joint = max(named, key=len)
            words = set(re.findall('[a-z]+', column.replace(joint, ' ').lower()))
            if words & _OTHER:
                continue
            key = joint + (VELOCITY if words & _VELOCITY else '')
            if key in found and column != joint:
                if found[key] == joint:
                    continue
                raise ToolError(f'{self.path}: both {found[key]!r} and {column!r} may be {key}; '
                                f'choose by --columns {key}=COLUMN')
            found[key] = column
        return found

    def _scale(self, columns: _Columns, joints: Mapping[str, str]) -> Array:
        """Return the factors to rad and m."""
        angle = self.stated.angle or (
            'deg' if all(re.search('deg', name.lower()) for name in columns.position) else 'rad')
        length = self.stated.length or 'm'
        return np.array([LENGTHS[length] if kind == 'prismatic' else UNITS[angle]
                         for kind in joints.values()])

    def _stamps(self, batch: Any, columns: Sequence[str]) -> list[Decimal]:
        """Return the stamps as they are written; texts of dates in ns since 1970."""
        parts = [batch.column(name).to_pylist() for name in columns]
        if len(parts) == 2:
            return [Decimal(s) * 10**9 + Decimal(ns) for s, ns in zip(*parts)]
        stamps = []
        for value in parts[0]:
            try:
                stamps.append(Decimal(value) if not isinstance(value, datetime)
                              else _since_1970(value))
            except (InvalidOperation, TypeError, ValueError):
                try:
                    stamps.append(_since_1970(datetime.fromisoformat(str(value))))
                except ValueError:
                    raise ToolError(f'{self.path}: a stamp in column {columns[0]!r} is '
                                    f'{value!r}; allowed: a number or an ISO date') from None
        if not all(stamp.is_finite() for stamp in stamps):
            raise ToolError(f'{self.path}: a stamp in column {columns[0]!r} is not finite')
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
            if kind != 'continuous' and (size > limit).any():
                at = int(np.argmax(size > limit))
                raise ToolError(
                    f'{self.path}: joint {name} ({kind}) is at {position[at, i]:g} in row '
                    f'{row + at + 1}; what unit is that? state it by --units {other}')


def stamp_columns(there: Sequence[str]) -> tuple[str, ...] | None:
    """
    Return the column of stamps, or those of seconds and nanoseconds.

    Examples
    --------
    >>> stamp_columns(['q1', 'Time']), stamp_columns(['sec', 'nanosec', 'q1'])
    (('Time',), ('sec', 'nanosec'))

    """
    lower = {re.sub(r'\s*[\[(].*', '', name.lower()): name for name in reversed(there)}
    for seconds, rest in _SECONDS:
        for ending in ('', *(name.removesuffix(seconds) for name in lower
                             if name.endswith((f'.{seconds}', f'/{seconds}')))):
            if ending + seconds in lower and ending + rest in lower:
                return lower[ending + seconds], lower[ending + rest]
    return next(((lower[name],) for name in _STAMPS if name in lower), None)


def by_number(there: Sequence[str], joints: Sequence[str]) -> dict[str, str]:
    """
    Return columns that number the joints, by joint.

    Examples
    --------
    >>> by_number(['t', 'q0', 'q1', 'v0', 'v1'], ['shoulder', 'elbow'])
    {'shoulder': 'q0', 'elbow': 'q1', 'shoulder.velocity': 'v0', 'elbow.velocity': 'v1'}

    """
    stems: dict[str, dict[int, str]] = {}
    for column in there:
        parts = re.fullmatch(r'(.*?)(\d+)(\D*)', column.lower())
        if parts:
            stems.setdefault(f'{parts[1]}#{parts[3]}', {})[int(parts[2])] = column
    found: dict[str, list[dict[int, str]]] = {'': [], VELOCITY: []}
    for stem, columns in stems.items():
        words, first = set(re.findall('[a-z]+', stem)), min(columns)
        if words & _OTHER or first > 1 or (
                set(columns) != set(range(first, first + len(joints)))):
            continue
        if words & _VELOCITY:
            found[VELOCITY].append(columns)
        elif words & _POSITION:
            found[''].append(columns)
    # Two that could be meant are none: the user is asked.
    return {joint + ending: columns[0][min(columns[0]) + i] for ending, columns in found.items()
            if len(columns) == 1 for i, joint in enumerate(joints)}


def _echoed(batch: Any) -> dict[str, str]:
    """Return columns by joint where a row tells the names, as ``rostopic echo -p`` writes it."""
    found: dict[str, str] = {}
    for column in batch.schema.names:
        number = re.fullmatch(r'field\.name(\d+)', column)
        if number:
            joint = str(batch.column(column)[0].as_py())
            for ending, part in (('', 'position'), (VELOCITY, 'velocity')):
                if f'field.{part}{number[1]}' in batch.schema.names:
                    found[joint + ending] = f'field.{part}{number[1]}'
    return found


def _since_1970(time: datetime) -> Decimal:
    aware = time if time.tzinfo else time.replace(tzinfo=timezone.utc)
    since = aware - datetime(1970, 1, 1, tzinfo=timezone.utc)
    return Decimal((since.days * 86_400 + since.seconds) * 10**9 + since.microseconds * 1000)


def _listed(names: Sequence[str]) -> str:
    more = len(names) - _SHOWN
    return ', '.join(names[:_SHOWN]) + (f' and {more} more' if more > 0 else '')
