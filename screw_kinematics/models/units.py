# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Units a model file may declare, converted to m and rad on reading."""
from __future__ import annotations

from dataclasses import dataclass
import math

from .fields import Fields

# Quotients, so that 431.8 mm becomes the number nearest to 0.4318.
_LENGTHS = {'m': (1, 1), 'cm': (1, 100), 'mm': (1, 1000), 'in': (127, 5000)}
_ANGLES = ('rad', 'deg')


@dataclass(frozen=True)
class Units:
    """
    The length and angle unit of a file.

    Parameters
    ----------
    length_unit : {'m', 'cm', 'mm', 'in'}
    angle_unit : {'rad', 'deg'}

    Examples
    --------
    >>> units = Units('mm', 'deg')
    >>> units.length(431.8), units.angle(180.0)
    (0.4318, 3.141592653589793)

    """

    length_unit: str = 'm'
    angle_unit: str = 'rad'

    @classmethod
    def from_fields(cls, fields: Fields) -> Units:
        """Return the units declared by the keys ``length`` and ``angle``."""
        return cls(fields.choice('length', _LENGTHS, 'm'),
                   fields.choice('angle', _ANGLES, 'rad'))

    def length(self, value: float) -> float:
        """Return a length in m."""
        numerator, denominator = _LENGTHS[self.length_unit]
        return value * numerator / denominator

    def angle(self, value: float) -> float:
        """Return an angle in rad."""
        return math.radians(value) if self.angle_unit == 'deg' else value

    def pitch(self, value: float) -> float:
        """Return a pitch, length per angle of the file, in m/rad."""
        return self.length(value) / self.angle(1.0)
