# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What is stated about tables of joint samples: options of the tools that read them."""
from __future__ import annotations

import argparse
from datetime import datetime, timezone
import math

from ..errors import ParameterError
from ..recordings.joint_table import LENGTHS, TableFormat, TIME_UNITS, UNITS


def add_options(options: argparse.ArgumentParser) -> None:
    """Add the options, in a group of their own."""
    table = options.add_argument_group('tables', 'needed where the tool cannot tell by itself')
    table.add_argument('--columns', metavar='JOINT=COLUMN,...', default='',
                       help='columns of the positions; JOINT.velocity=COLUMN, stamp=COLUMN')
    table.add_argument('--units', metavar='U,U', default='',
                       help='units of the positions: rad or deg, m or mm')
    table.add_argument('--time-unit', choices=TIME_UNITS, default='', help='unit of the stamps')
    table.add_argument('--epoch', metavar='TIME', default='0',
                       help='what to add to the stamps: seconds since 1970, or an ISO date')


def table_format(arguments: argparse.Namespace) -> TableFormat:
    """Return what the options say of tables."""
    columns = dict(_pair(entry) for entry in arguments.columns.split(',') if entry)
    units = [unit for unit in arguments.units.split(',') if unit]
    for unit in units:
        if unit not in UNITS and unit not in LENGTHS:
            raise ParameterError('units', arguments.units,
                                 f'{", ".join((*UNITS, *LENGTHS))}, two of them by a comma')
    return TableFormat(columns, next((u for u in units if u in UNITS), ''),
                       next((u for u in units if u in LENGTHS), ''), arguments.time_unit,
                       _epoch(arguments.epoch))


def _pair(entry: str) -> tuple[str, str]:
    joint, found, column = entry.partition('=')
    if not found:
        raise ParameterError('columns', entry, 'JOINT=COLUMN, several separated by commas')
    return joint, column


def _epoch(text: str) -> int:
    try:
        seconds = float(text)
        if math.isfinite(seconds):
            return round(seconds * 1e9)
    except ValueError:
        try:
            time = datetime.fromisoformat(text)
            return round((time if time.tzinfo else time.replace(tzinfo=timezone.utc)
                          ).timestamp()) * 10**9
        except ValueError:
            pass
    raise ParameterError('epoch', text, 'seconds since 1970, or a date such as '
                         '2026-05-01T08:00:00+00:00')
