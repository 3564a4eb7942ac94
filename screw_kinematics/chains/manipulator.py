# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
What serial chains and parallel manipulators answer alike, from what each of them brings.

The inverse problem of every order, the Coriolis-Lie term, joint efforts, and how well a
posture can move.
"""
from __future__ import annotations

from typing import Any

import numpy as np

from .inverse import InverseSolution, InverseSolver, Manipulability, manipulability
from .mechanism import Mechanism
from ..errors import UnknownNameError
from ..screws.body_state import BodyState
from ..screws.se3 import Array
from ..screws.vectors import checked_array, finite_array

__all__ = ['Manipulator']

_KINDS = ('classical', 'reduced')
_DAMPED = InverseSolver()


class Manipulator(Mechanism):
    """What follows from the forward problem, the states and the Jacobian of a mechanism."""

    def coriolis_lie(self, q: Any, qd: Any, pole: str | Array = 'tip',
                     axes: str = 'base') -> Array:
        """
        Return the Coriolis-Lie term: the reduced acceleration at zero joint accelerations.

        Of an open chain it is the sum of the Lie products ``[$_i, $_j] q_i' q_j'`` over the
        joints i before j.

        Parameters
        ----------
        q, qd : array, shape (..., dof)
            Positions and rates of the measured joints.
        pole, axes : as of :meth:`jacobian`
            Of the term.

        Returns
        -------
        array, shape (..., 6)
            ``reduced acceleration - jacobian @ qdd`` [rad/s^2, m/s^2].

        Raises
        ------
        ShapeError, InvalidValueError, UnknownNameError
            As :meth:`jacobian`.

        References
        ----------
        The paper, Theorem 4: its term $_a.

        """
        return self._coasting(q, (qd,)).about(pole).expressed_in(axes).reduced_acceleration

    def joint_efforts(self, q: Any, wrench: Any, pole: str | Array = 'tip',
                      axes: str = 'base') -> Array:
        """
        Return the joint efforts whose virtual power equals that of a wrench on the tip.

        The Klein form of the wrench with the screw of each measured joint: the torques
        [N m] and forces [N] with which the joints would move the tip against the opposite
        wrench, friction, weight and inertia aside.

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions of the measured joints [rad, m].
        wrench : array, shape (..., 6)
            ``(force; moment)`` [N, N m]: a wrench as a screw has its force first.
        pole, axes : as of :meth:`jacobian`
            Of the wrench.

        Returns
        -------
        array, shape (..., dof)
            Of the measured joints [N m, N].

        Raises
        ------
        ShapeError, InvalidValueError, UnknownNameError
            Joint values or wrench of a wrong shape, or no such pole or axes.

        References
        ----------
        The paper, section 2.3 (Klein form).

        """
        wrench = checked_array('wrench', wrench, (..., 6))
        screws = np.swapaxes(self.jacobian(q, pole, axes), -1, -2)
        swapped = np.concatenate([wrench[..., 3:], wrench[..., :3]], axis=-1)
        return np.asarray((screws @ swapped[..., None])[..., 0])

    def inverse_velocity(self, q: Any, twist: Any, pole: str | Array = 'tip',
                         axes: str = 'base', secondary: Any = None,
                         solver: InverseSolver = _DAMPED) -> InverseSolution:
        """
        Return the rates of the measured joints that give the tip a twist.

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions of the measured joints [rad, m].
        twist : array, shape (..., 6)
            Wanted twist of the tip [rad/s, m/s] about ``pole`` in ``axes``.
        pole, axes : as of :meth:`jacobian`
            Of the twist.
        secondary : array, shape (..., dof), optional
            Rates wished for as far as the twist allows (null-space motion).
        solver : InverseSolver
            Exact or damped, and the characteristic length. Default: damped near
            singularities.

        Returns
        -------
        InverseSolution
            Its ``rates`` are in rad/s and m/s.

        Raises
        ------
        ShapeError, InvalidValueError, UnknownNameError
            Arguments of a wrong shape, or no such pole or axes.
        SingularityError
            The solver is exact and the twist impossible; the reciprocal screw is named.

        References
        ----------
        The paper, equation 78.

        """
        return self._inverse(q, (), twist, 'reduced', pole, axes, secondary, solver)

    def inverse_acceleration(self, q: Any, qd: Any, acceleration: Any,
                             kind: str = 'classical', pole: str | Array = 'tip',
                             axes: str = 'base', secondary: Any = None,
                             solver: InverseSolver = _DAMPED) -> InverseSolution:
        """
        Return the joint accelerations that give the tip an acceleration.

        Parameters
        ----------
        q, qd : array, shape (..., dof)
            Positions and rates of the measured joints.
        acceleration : array, shape (..., 6)
            Wanted acceleration of the tip [rad/s^2, m/s^2] about ``pole`` in ``axes``.
        kind : {'classical', 'reduced'}
            ``[alpha; a]`` of the point at the pole, or ``(alpha ; a - w x v)``.
        pole, axes, secondary, solver : as of :meth:`inverse_velocity`
            The secondary motion is of joint accelerations.

        Returns
        -------
        InverseSolution
            Its ``rates`` are the joint accelerations.

        Raises
        ------
        ShapeError, InvalidValueError, UnknownNameError
            Arguments of a wrong shape, or no such kind, pole or axes.
        SingularityError
            The solver is exact and the acceleration impossible.

        References
        ----------
        The paper, equation 80: what the joint rates contribute (the Coriolis-Lie term) is
        taken off first.

        """
        return self._inverse(q, (qd,), acceleration, kind, pole, axes, secondary, solver)

    def inverse_jerk(self, q: Any, qd: Any, qdd: Any, jerk: Any, kind: str = 'classical',
                     pole: str | Array = 'tip', axes: str = 'base', secondary: Any = None,
                     solver: InverseSolver = _DAMPED) -> InverseSolution:
        """
        Return the joint jerks that give the tip a jerk.

        Parameters
        ----------
        q, qd, qdd : array, shape (..., dof)
            Positions, rates and accelerations of the measured joints.
        jerk : array, shape (..., 6)
            Wanted jerk of the tip [rad/s^3, m/s^3] about ``pole`` in ``axes``.
        kind, pole, axes, secondary, solver : as of :meth:`inverse_acceleration`
            Of the jerk.

        Returns
        -------
        InverseSolution
            Its ``rates`` are the joint jerks.

        Raises
        ------
        ShapeError, InvalidValueError, UnknownNameError, SingularityError
            As :meth:`inverse_acceleration`.

        """
        return self._inverse(q, (qd, qdd), jerk, kind, pole, axes, secondary, solver)

    def inverse_snap(self, q: Any, qd: Any, qdd: Any, qddd: Any, snap: Any,
                     kind: str = 'classical', pole: str | Array = 'tip', axes: str = 'base',
                     secondary: Any = None, solver: InverseSolver = _DAMPED) -> InverseSolution:
        """
        Return the joint snaps (jounces) that give the tip a snap.

        Parameters
        ----------
        q, qd, qdd, qddd : array, shape (..., dof)
            Positions, rates, accelerations and jerks of the measured joints.
        snap : array, shape (..., 6)
            Wanted snap of the tip [rad/s^4, m/s^4] about ``pole`` in ``axes``.
        kind, pole, axes, secondary, solver : as of :meth:`inverse_acceleration`
            Of the snap.

        Returns
        -------
        InverseSolution
            Its ``rates`` are the joint snaps.

        Raises
        ------
        ShapeError, InvalidValueError, UnknownNameError, SingularityError
            As :meth:`inverse_acceleration`.

        """
        return self._inverse(q, (qd, qdd, qddd), snap, kind, pole, axes, secondary, solver)

    def manipulability(self, q: Any, length: float = 1.0) -> Manipulability:
        """
        Return how well the tip can move at a posture, pole at the tip, axes of the base.

        Parameters
        ----------
        q : array, shape (..., dof)
            Positions of the measured joints [rad, m].
        length : float
            Characteristic length [m/rad].

        Returns
        -------
        Manipulability
            Measure, condition number, ellipsoid.

        Raises
        ------
        ShapeError, InvalidValueError
            Joint values of a wrong shape, or a length that is not positive.

        """
        return manipulability(self.jacobian(q), self.prismatic, length)

    def _inverse(self, q: Any, rates: tuple[Any, ...], wanted: Any, kind: str,
                 pole: str | Array, axes: str, secondary: Any,
                 solver: InverseSolver) -> InverseSolution:
        """Return the highest derivative of the joints, the lower ones and the tip's given."""
        if kind not in _KINDS:
            raise UnknownNameError('kind', kind, _KINDS)
        wanted = finite_array('wanted six-vector', wanted, (..., 6))
        if rates:
            order = len(rates) + 1
            known = self._coasting(q, rates).about(pole).expressed_in(axes)
            wanted = wanted - (known.classical(order) if kind == 'classical'
                               else known.reduced[order - 1])
        return solver.solve(self.jacobian(q, pole, axes), wanted, self.prismatic, secondary)

    def _coasting(self, q: Any, rates: tuple[Any, ...]) -> BodyState:
        """Return the state with the next derivative of the joints zero."""
        return self.state(q, *rates, 0 * checked_array(
            f'derivative {len(rates)} of q of {self!r}', rates[-1], (..., self.dof)))
