# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Joint rates from the motion of the tip, and how well a posture can move.

A six-vector mixes radians and metres, and so do the joints of a mixed chain; a norm of
either means something only with a characteristic length L [m/rad]: the linear part and
the prismatic rates are divided by it. Exact solutions of square chains do not depend on L;
minimum norms, damping, singular values and manipulability do. The default of 1 m suits
arms about as long as a person's; a sensible choice is the reach of the arm.

References
----------
The paper, equations 78 and 80. Nakamura, Hanafusa, "Inverse kinematic solutions with
singularity robustness", J. Dyn. Sys., Meas., Control 108(3), 1986. Yoshikawa,
"Manipulability of robotic mechanisms", Int. J. Robotics Research 4(2), 1985.

"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import InvalidValueError, ShapeError, SingularityError
from ..screws.screw import screw_of_twist
from ..screws.se3 import Array, matvec
from ..screws.vectors import finite_array

__all__ = ['InverseSolution', 'InverseSolver', 'Manipulability', 'manipulability']

# Singular values below this fraction of the largest are zero in floating point.
_RANK = 1e-9


@dataclass(frozen=True, eq=False)
class InverseSolution:
    """
    Joint rates (or accelerations) for a wanted motion of the tip.

    Parameters
    ----------
    rates : array, shape (..., dof)
        Solution of smallest norm, plus the null-space part of the secondary motion.
    residual : array, shape (..., 6)
        Wanted minus achieved six-vector; zero where the solution is exact.
    null_space : array, shape (..., dof, dof)
        ``null_space @ anything`` are rates that leave the tip's motion as it is.
    damping : array, shape (...)
        Largest damping factor that acted on this motion (dimensionless); 0 where none did.
    singular_values : array, shape (..., min(6, dof))
        Of the dimensionless Jacobian, largest first.

    """

    rates: Array
    residual: Array
    null_space: Array
    damping: Array
    singular_values: Array


@dataclass(frozen=True)
class InverseSolver:
    """
    How to invert a Jacobian: exactly or damped, and by which length.

    Parameters
    ----------
    exact : bool
        True: no damping; raise if the motion is impossible at this posture. Near a
        singularity the rates are then as large as they must be.
    length : float
        Characteristic length [m/rad].
    threshold : float
        Without ``exact``: directions whose singular value s is below this threshold e are
        damped by sqrt(e^2 - s^2), so that no rate exceeds 1/e times the wanted motion, and
        the solution is continuous at the threshold.

    Raises
    ------
    InvalidValueError
        Length or threshold is not positive and finite.

    """

    exact: bool = False
    length: float = 1.0
    threshold: float = 0.02

    def __post_init__(self) -> None:
        for name in ('length', 'threshold'):
            value = getattr(self, name)
            if not 0 < value < np.inf:
                raise InvalidValueError(
                    f'InverseSolver: {name} must be positive and finite, got {value!r}')

    def solve(self, jacobian: Array, wanted: Array, prismatic: Array | None = None,
              secondary: Array | None = None) -> InverseSolution:
        """
        Return the rates for a wanted six-vector.

        Parameters
        ----------
        jacobian : array, shape (..., 6, dof)
            Columns: six-vectors of unit rates.
        wanted : array, shape (..., 6)
            Wanted six-vector, about the pole and in the axes of the Jacobian.
        prismatic : array of bool, shape (dof,), optional
            Which rates are in m/s rather than rad/s; default none.
        secondary : array, shape (..., dof), optional
            Rates wished for as far as the tip's motion allows.

        Returns
        -------
        InverseSolution
            The rates, and what they miss.

        Raises
        ------
        ShapeError, InvalidValueError
            Shapes do not fit, or a value is not finite.
        SingularityError
            ``exact``, and some component of the wanted motion is impossible.

        Examples
        --------
        >>> jacobian = np.array([[0, 0, 1, 0, 1, 0], [0, 0, 0, 1, 0, 0]]).T
        >>> InverseSolver().solve(jacobian, np.array([0, 0, 2, 3, 2, 0])).rates.round(12)
        array([2., 3.])

        """
        jacobian = _checked_jacobian(jacobian)
        wanted = finite_array('wanted six-vector', wanted, (..., 6))
        dof = jacobian.shape[-1]
        rows, columns = _scales(self.length, dof, prismatic)
        left, sizes, right = _svd(jacobian, rows, columns)
        goal = rows * wanted
        regular = sizes > _RANK * sizes.max(axis=-1, keepdims=True, initial=0)
        along = matvec(np.swapaxes(left, -1, -2), goal)
        if self.exact:
            damping = np.zeros(np.broadcast(sizes, along).shape)
            gain = np.where(regular, 1 / np.where(regular, sizes, 1), 0)
        else:
            damping = np.sqrt(np.maximum(self.threshold ** 2 - sizes ** 2, 0))
            gain = sizes / np.maximum(sizes, self.threshold) ** 2
            touched = np.abs(along) > _RANK * np.linalg.norm(goal, axis=-1, keepdims=True)
            damping = np.where(touched, damping, 0)
        rates = columns * matvec(np.swapaxes(right, -1, -2), gain * along)
        kept = right * regular[..., None]
        null_space = np.eye(dof) - np.swapaxes(right, -1, -2) @ kept
        null_space = columns[:, None] * null_space / columns
        residual = wanted - matvec(jacobian, rates)
        if self.exact:
            # Not the residual, which rounding makes large as well where the rates are large.
            out_of_reach: Array = goal - matvec(left, regular * along)
            self._refuse_impossible(out_of_reach, goal, regular)
        if secondary is not None:
            wished = finite_array('secondary rates', secondary, (..., dof))
            rates = rates + matvec(null_space, wished)
        return InverseSolution(rates, residual, null_space,
                               damping.max(axis=-1, initial=0), sizes)

    def _refuse_impossible(self, residual: Array, goal: Array, regular: Array) -> None:
        size = np.linalg.norm(goal, axis=-1)
        failed = np.linalg.norm(residual, axis=-1) > _RANK * np.maximum(size, 1e-300)
        if not np.any(failed):
            return
        index = tuple(int(k) for k in np.argwhere(failed)[0])
        rows, _ = _scales(self.length, 0, None)
        # What is left over lies outside the span of the joint screws; read as a wrench, with
        # primal and dual part exchanged, it is the screw reciprocal to all of them.
        wrench = np.roll(np.broadcast_to(residual, failed.shape + (6,))[index] * rows, 3)
        screw = screw_of_twist(wrench)
        rank = np.broadcast_to(regular, failed.shape + regular.shape[-1:])[index].sum()
        where = f' (sample {index})' if index else ''
        place = ('a pure couple' if np.isinf(screw.pitch) else
                 f'through the point {_text(screw.point)} from the pole, '
                 f'pitch {float(screw.pitch):.6g} m/rad')
        raise SingularityError(
            f'the Jacobian has rank {rank} at this posture{where}, and the wanted motion '
            'works against a reciprocal screw, along which no joint can move the tip: axis '
            f'{_text(screw.axis)}, {place}', wrench / screw.amplitude)


@dataclass(frozen=True, eq=False)
class Manipulability:
    """
    How well the tip can move: the image of all joint rates of norm 1.

    Parameters
    ----------
    singular_values : array, shape (..., min(6, dof))
        Of the dimensionless Jacobian, largest first.
    ellipsoid : array, shape (..., 6, min(6, dof))
        Columns: the twists that are the ellipsoid's semi-axes [rad/s, m/s].

    """

    singular_values: Array
    ellipsoid: Array

    @property
    def measure(self) -> Array:
        """Yoshikawa's measure, the product of the singular values, shape (...)."""
        return np.prod(self.singular_values, axis=-1)

    @property
    def condition_number(self) -> Array:
        """Largest over smallest singular value, shape (...); inf if singular."""
        smallest, largest = self.singular_values[..., -1], self.singular_values[..., 0]
        singular = smallest <= _RANK * largest
        return np.where(singular, np.inf, largest / np.where(singular, 1, smallest))[()]


def manipulability(jacobian: Array, prismatic: Array | None = None,
                   length: float = 1.0) -> Manipulability:
    """
    Return the manipulability of a posture.

    Parameters
    ----------
    jacobian : array, shape (..., 6, dof)
        Columns: six-vectors of unit rates.
    prismatic : array of bool, shape (dof,), optional
        Which rates are in m/s rather than rad/s; default none.
    length : float
        Characteristic length [m/rad].

    Returns
    -------
    Manipulability
        Of this Jacobian.

    Raises
    ------
    ShapeError, InvalidValueError
        Shapes do not fit, a value is not finite, or the length not positive.

    Examples
    --------
    >>> jacobian = np.array([[0, 0, 1, 0, 0, 0], [0, 0, 0, 1, 0, 0]]).T
    >>> float(manipulability(jacobian, prismatic=np.array([False, True])).measure)
    1.0

    """
    jacobian = _checked_jacobian(jacobian)
    if not 0 < length < np.inf:
        raise InvalidValueError(f'length must be positive and finite, got {length!r}')
    rows, columns = _scales(length, jacobian.shape[-1], prismatic)
    left, sizes, _ = _svd(jacobian, rows, columns)
    return Manipulability(sizes, left * sizes[..., None, :] / rows[:, None])


def _scales(length: float, dof: int, prismatic: Array | None) -> tuple[Array, Array]:
    """Return the factors that make rows and columns of a Jacobian dimensionless."""
    sliding = np.zeros(dof, dtype=bool) if prismatic is None else np.asarray(prismatic)
    if sliding.shape != (dof,):
        raise ShapeError('prismatic', f'({dof},)', sliding.shape)
    return np.repeat([1, 1 / length], 3), np.where(sliding, length, 1.0)


def _checked_jacobian(jacobian: Any) -> Array:
    shape = np.shape(jacobian)
    if len(shape) < 2 or shape[-2] != 6:
        raise ShapeError('jacobian', '(..., 6, dof)', shape)
    return finite_array('jacobian', jacobian, (..., 6, None))


def _svd(jacobian: Array, rows: Array, columns: Array) -> Any:
    return np.linalg.svd(rows[:, None] * jacobian * columns, full_matrices=False)


def _text(vector: Array) -> str:
    # Rounded, and without negative zeros.
    return '(' + ', '.join(f'{x:.6g}' for x in np.round(vector, 9) + 0.0) + ')'
