# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Settings of estimators that must be numbers, checked where they come in."""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Integral, Real
from typing import Any

import numpy as np

from ..errors import InvalidValueError

Row = tuple[float, ...]
"""A number for each joint."""


def positive(name: str, value: Any, unit: str = '') -> float:
    """Return a setting that must be a number above 0; raise InvalidValueError if it is none."""
    if not _is_number(value) or not value > 0:
        raise InvalidValueError(f'{name} is {value!r}{unit}; allowed: more than 0')
    return float(value)


def whole(name: str, value: Any, least: int = 1) -> int:
    """
    Return a setting that must be a whole number, of at least some size.

    Examples
    --------
    >>> whole('n_joints', '7')
    Traceback (most recent call last):
    ...
    screw_kinematics.errors.InvalidValueError: n_joints is '7'; allowed: 1 or more

    """
    if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
        raise InvalidValueError(f'{name} is {value!r}; allowed: {least} or more')
    return int(value)


def delay_of(value: Any) -> float:
    """Return a delay, 0 to 1 s; raise InvalidValueError if it is none."""
    if not _is_number(value) or not 0.0 <= value <= 1.0:
        raise InvalidValueError(f'delay is {value!r} s; allowed: 0 to 1 s')
    return float(value)


def for_joints(name: str, values: Any, n_joints: int, otherwise: str = '') -> list[Any]:
    """
    Return what is given for each joint; ``otherwise`` is what may be given instead.

    Raise InvalidValueError if it is no sequence, or of another length.
    """
    if isinstance(values, str) or not isinstance(values, (Sequence, np.ndarray)):
        raise InvalidValueError(f'{name} is {values!r}; allowed: '
                                f'{otherwise}{n_joints} values')
    values = list(values)
    if len(values) != n_joints:
        raise InvalidValueError(f'{name} has {len(values)} values; allowed: '
                                f'{otherwise}{n_joints}')
    return values


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)
