# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How the demo shows a measured state beside the exact one: tables and plain lines."""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from rich import box
from rich.console import Console, ConsoleOptions, RenderResult
from rich.table import Table
from rich.text import Text

from ...screws.se3 import Array

WIDE = 80
"""Columns from which on quantities are called by their names."""


@dataclass(frozen=True)
class Row:
    """One vector or number of the state: as the node published it, and the truth at its stamp."""

    quantity: str
    symbol: str
    unit: str
    measured: Array
    exact: Array

    @property
    def error(self) -> float:
        """Return the norm of measured minus exact."""
        return float(np.linalg.norm(self.measured - self.exact))


@dataclass(frozen=True)
class View:
    """All that is shown at one instant."""

    title: str                    # robot and motion
    frames: str                   # whose motion, in which axes, of which point
    elapsed: float                # since the motion began, at the stamp of the state [s]
    rows: tuple[Row, ...]
    rates: Mapping[str, float]    # messages per second, by topic
    age: float                    # from the stamp to now [s]
    delay: float                  # that the estimator was asked for [s]


@dataclass(frozen=True)
class LiveTable:
    """The view as a table for 80 columns; in narrower windows by symbols, with fewer digits."""

    view: View

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Give the table and what is to be said below it."""
        view, wide = self.view, options.max_width >= WIDE
        table = Table(box=box.SIMPLE_HEAD, title=f'{view.title}, t = {view.elapsed:.2f} s',
                      title_justify='left', pad_edge=False)
        for heading in ('', 'x', 'y', 'z', '', '|error|'):
            table.add_column(heading, no_wrap=True, justify='right' if heading else 'left',
                             min_width=9 if wide and heading else None)
        for row in view.rows:
            table.add_row(row.quantity if wide else row.symbol,
                          *_numbers(row.measured, '.5f' if wide else '.3f'), row.unit,
                          f'{row.error:.1e}')
        yield table
        yield Text(f'{view.frames}\n{_rates(view)}\n'
                   f'age of the state {view.age * 1e3:.1f} ms, of which estimator delay '
                   f'{view.delay * 1e3:.0f} ms\nCtrl-C ends the demo and both its processes')


def line(view: View) -> str:
    """Return the view as one plain line, for logs and pipes."""
    values = '  '.join(
        f'{row.symbol} = ({", ".join(text for text in _numbers(row.measured, ".4f") if text)}) '
        f'{row.unit}' for row in view.rows)
    return f't = {view.elapsed:.2f} s  {values}  |  {_rates(view)}, age {view.age * 1e3:.1f} ms'


def comparison(view: View) -> str:
    """Return measured, exact and error, digit under digit."""
    lines = [f'{view.title}, t = {view.elapsed:.6f} s', view.frames]
    for row in view.rows:
        lines.append(f'{row.quantity} {row.symbol}' + (f' [{row.unit}]' if row.unit else ''))
        for name, values, digits in (('measured', row.measured, '.6f'),
                                     ('exact', row.exact, '.6f'),
                                     ('error', row.measured - row.exact, '.1e')):
            numbers = ''.join(f'{text:>14}' for text in _numbers(values, digits))
            lines.append(f'    {name:<8}{numbers}'.rstrip())
    return '\n'.join(lines)


def _rates(view: View) -> str:
    return 'Hz: ' + ', '.join(f'{topic} {rate:.0f}' for topic, rate in view.rates.items())


def _numbers(values: Array, digits: str) -> list[str]:
    texts = [format(float(value) + 0.0, digits) for value in values]
    return texts + [''] * (3 - len(texts))
