# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Two screws span a pencil: the cylindroid, and the theorem of the three axes.

If body 2 moves about one screw relative to body 1, and body 3 about another relative to body
2, then body 3 moves relative to body 1 about a third one. Its axis cuts the common
perpendicular of the other two at a right angle (Aronhold, Kennedy); whatever the ratio of
the two amplitudes, it lies on one ruled surface, the cylindroid.

References
----------
R. S. Ball, "A treatise on the theory of screws", 1900, chapter II. K. H. Hunt, "Kinematic
geometry of mechanisms", 1978, sections 11.3 and 12.3.

"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .lines import nearest_point
from .screw import Screw, screw_of_twist
from .se3 import killing_form, klein_form
from .vectors import Array, cross, finite_array
from ..errors import InvalidValueError

__all__ = ['Cylindroid', 'cylindroid', 'third_axis']

# Sine of the angle below which two axes count as parallel.
_PARALLEL = 1e-8


@dataclass(frozen=True, eq=False)
class Cylindroid:
    """
    The screws that are sums of multiples of two given ones.

    Parameters
    ----------
    principal : array, shape (2, 6)
        The unit screws of least and of greatest pitch; they meet at a right angle.
    pitches : array, shape (2,)
        Their pitches [m/rad].
    centre : array, shape (3,)
        Where they meet, from the pole [m].
    axis : array, shape (3,)
        Unit direction of the line that the axes of all screws cut at right angles.

    """

    principal: Array
    pitches: Array
    centre: Array
    axis: Array

    @property
    def length(self) -> float:
        """Distance between the outermost axes [m]: the difference of the pitches."""
        return float(self.pitches[1] - self.pitches[0])

    def screw_at(self, angle: Any) -> Array:
        """
        Return the unit screw of a direction.

        Parameters
        ----------
        angle : array, shape (...)
            From the first to the second principal screw [rad].

        Returns
        -------
        array, shape (..., 6)
            Its pitch is ``h1 cos^2 + h2 sin^2``, and its axis is ``(h2 - h1) sin cos`` from
            the centre.

        """
        angle = finite_array('angle', angle, (...,))[..., None]
        return np.asarray(
            np.cos(angle) * self.principal[0] + np.sin(angle) * self.principal[1])


def cylindroid(x: Array, y: Array) -> Cylindroid:
    """
    Return the cylindroid of two screws.

    Parameters
    ----------
    x, y : array, shape (6,)
        Screws or twists of finite pitch about one pole, in one set of axes; any multiples.

    Returns
    -------
    Cylindroid
        About the pole of x and y, in their axes.

    Raises
    ------
    ShapeError, InvalidValueError
        These are no two screws of finite pitch whose axes are not parallel.

    Examples
    --------
    Two rotations about axes at right angles, 0.2 m apart: pitches from -0.1 to 0.1 m/rad.

    >>> from screw_kinematics.screws import unit_screw
    >>> x = unit_screw(np.array([1, 0, 0]), np.array([0, 0, 0]))
    >>> found = cylindroid(x, unit_screw(np.array([0, 1, 0]), np.array([0, 0, 0.2])))
    >>> found.pitches.round(12), found.centre.round(12) + 0.0
    (array([-0.1,  0.1]), array([0. , 0. , 0.1]))

    """
    pair = np.stack([finite_array('x', x, (6,)), finite_array('y', y, (6,))])
    sizes = np.linalg.norm(pair[:, :3], axis=1)
    unit = pair / np.where(sizes > 0, sizes, 1)[:, None]
    normal = cross(unit[0, :3], unit[1, :3])
    if not np.all(sizes > 0) or np.linalg.norm(normal) < _PARALLEL:
        raise InvalidValueError(
            'a cylindroid needs two screws of finite pitch whose axes are not parallel, got '
            f'{pair.tolist()}')
    # Pitch of a x + b y: half its Klein form with itself over its Killing form. The principal
    # screws are where that ratio is stationary.
    klein = klein_form(unit[:, None], unit[None, :]) / 2
    root = np.linalg.inv(np.linalg.cholesky(killing_form(unit[:, None], unit[None, :])))
    pitches, vectors = np.linalg.eigh(root @ klein @ root.T)
    principal = (vectors.T @ root) @ unit
    axis = cross(principal[0, :3], principal[1, :3])
    line = principal[0] - np.concatenate([np.zeros(3), pitches[0] * principal[0, :3]])
    other = principal[1] - np.concatenate([np.zeros(3), pitches[1] * principal[1, :3]])
    # The axes meet: the foot on one of any point of the other, moved along it, is the centre.
    p, q = nearest_point(line), nearest_point(other)
    centre = p + principal[0, :3] * (principal[0, :3] @ (q - p))
    return Cylindroid(principal, pitches, centre, axis)


def third_axis(twist_1_2: Array, twist_2_3: Array) -> Screw:
    """
    Return the screw about which the third of three bodies moves relative to the first.

    Its axis cuts the common perpendicular of the other two axes at a right angle; in a plane,
    the three centres of rotation are on one line.

    Parameters
    ----------
    twist_1_2 : array, shape (..., 6)
        Twist of body 2 relative to body 1.
    twist_2_3 : array, shape (..., 6)
        Twist of body 3 relative to body 2; about the same pole, in the same axes.

    Returns
    -------
    Screw
        About the pole of the twists, in their axes.

    Raises
    ------
    ShapeError, InvalidValueError
        These are no twists.

    Examples
    --------
    Equal and opposite turns about parallel axes are a translation.

    >>> found = third_axis(np.array([0, 0, 1, 0, 0, 0]), np.array([0, 0, -1, 0, 2, 0]))
    >>> str(found.kind), found.axis
    ('translation', array([0., 1., 0.]))

    """
    return screw_of_twist(finite_array('twist_1_2', twist_1_2, (..., 6))
                          + finite_array('twist_2_3', twist_2_3, (..., 6)))
