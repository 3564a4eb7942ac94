# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""One joint of a chain: its screw at q = 0 and where its value comes from."""
from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np

from ..errors import InvalidValueError, UnknownNameError
from ..screws.vectors import Array, checked_array, finite_array

__all__ = ['Joint', 'KINDS', 'Mimic']

KINDS = ('revolute', 'continuous', 'prismatic', 'helical')


@dataclass(frozen=True)
class Mimic:
    """
    A joint that follows another one: ``q = multiplier * q_source + offset``.

    Parameters
    ----------
    joint : str
        Name of the measured joint that is followed; it need not be in the chain.
    multiplier : float
        Ratio of SI values.
    offset : float
        In rad or m, as the following joint.
    kind : {'revolute', 'continuous', 'prismatic', 'helical'}, optional
        Of the measured joint; needed where it is not in the chain. Default: as the
        following joint.
    velocity_limit : float
        Of a measured joint that is not in the chain [rad/s, m/s].

    """

    joint: str
    multiplier: Any = 1
    offset: Any = 0
    kind: str | None = None
    velocity_limit: float = inf


@dataclass(frozen=True, eq=False)
class Joint:
    """
    A joint as a unit screw in the base frame at q = 0.

    Parameters
    ----------
    name : str
        What joint states call it.
    kind : {'revolute', 'continuous', 'prismatic', 'helical'}
        'continuous' is a revolute joint whose measured angle may wrap at 2 pi.
    axis : array, shape (3,)
        Direction in base axes; normalised here.
    point : array, shape (3,)
        Any point of the axis in the base frame [m]; without meaning if prismatic.
    pitch : float
        Pitch [m/rad], which helical joints need; of all others 0.
    mimic : Mimic, optional
        Where the value comes from, if it is not measured itself.
    velocity_limit : float
        Largest speed the robot's maker states [rad/s, m/s]; infinite if none is known.

    Raises
    ------
    UnknownNameError
        The kind is none of the allowed ones.
    ShapeError, InvalidValueError
        Axis, point, pitch or limit are not usable; the message names the joint.

    Examples
    --------
    >>> Joint('lift', 'prismatic', axis=(0, 0, 2)).axis
    array([0., 0., 1.])

    """

    name: str
    kind: str
    axis: Array
    point: Array = (0, 0, 0)    # type: ignore[assignment]
    pitch: Any = None
    mimic: Mimic | None = None
    velocity_limit: float = inf

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise UnknownNameError(f'kind of joint {self.name!r}:', self.kind, KINDS)
        for key in ('axis', 'point'):
            object.__setattr__(self, key, self._vector(key))
        if self.axis.dtype != object:
            largest = float(np.max(np.abs(self.axis)))
            if not largest > 0:
                raise InvalidValueError(f'joint {self.name!r}: axis must not be zero')
            # An exact power of two first, or the squares would leave the floats' range.
            unit = np.ldexp(self.axis, -np.frexp(largest)[1])
            unit = unit / np.linalg.norm(unit)
            unit.setflags(write=False)
            object.__setattr__(self, 'axis', unit)
        if self.pitch is None:
            if self.kind == 'helical':
                raise InvalidValueError(f"joint {self.name!r}: the kind 'helical' needs a pitch "
                                        '[m/rad]')
            object.__setattr__(self, 'pitch', 0)
        if checked_array(f'joint {self.name!r}: pitch', self.pitch, ()).dtype != object:
            if not np.isfinite(self.pitch):
                raise InvalidValueError(
                    f'joint {self.name!r}: pitch must be finite, got {self.pitch!r}; '
                    "for infinite pitch use the kind 'prismatic'")
            if self.pitch != 0 and self.kind != 'helical':
                raise InvalidValueError(
                    f'joint {self.name!r}: pitch {self.pitch!r} needs the kind '
                    f"'helical', got {self.kind!r}")
        limit = checked_array(f'joint {self.name!r}: velocity_limit', self.velocity_limit, ())
        if not limit > 0:
            raise InvalidValueError(
                f'joint {self.name!r}: velocity_limit must be positive, '
                f'got {self.velocity_limit!r}')

    def _vector(self, key: str) -> Array:
        name = f'joint {self.name!r}: {key}'
        vector = np.array(checked_array(name, getattr(self, key), (3,)))
        if vector.dtype != object:
            vector = finite_array(name, vector, (3,))
        vector.setflags(write=False)
        return vector

    @property
    def source(self) -> str:
        """Name of the measured joint that gives the value."""
        return self.mimic.joint if self.mimic is not None else self.name
