# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Reference motions: joint motions known exactly, with all their derivatives.

They feed the demo, the figures and the comparison of measured with exact states.

References
----------
The paper, section 4.2, for the motion of the PUMA robot.

"""
from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ..errors import ParameterError
from ..screws.se3 import Array

MOTIONS = ('paper', 'minjerk', 'multisine')
PAPER_CENTRE = np.radians(10.0)
PAPER_AMPLITUDES = (0.2, 0.15, 0.25, 0.25, 0.15, 0.3)
# A prismatic joint moves as many metres as a revolute one moves radians, times this.
METRES_PER_RADIAN = 0.25


class ReferenceMotion(Protocol):
    """A joint motion that is known exactly."""

    def derivatives(self, t: Array | float, order: int) -> list[Array]:
        """
        Return positions and their time derivatives up to an order.

        At times of any shape (...) [s]; each is an array of shape (..., dof).
        """


class Sinusoids:
    """
    A sum of sinusoids per joint: ``q = centre + sum_k A_k sin(w_k t + phase_k)``.

    Amplitudes [rad, m], angular frequencies [rad/s] and phases [rad] have a row for each joint.

    Examples
    --------
    >>> q, qd = Sinusoids([0.5], [[2.0]], [[3.0]], [[0.0]]).derivatives(0.0, 1)
    >>> float(q[0]), float(qd[0])
    (0.5, 6.0)

    """

    def __init__(self, centre: Array, amplitudes: Array, frequencies: Array,
                 phases: Array) -> None:
        self._centre = np.asarray(centre, dtype=float)
        self._amplitudes = np.asarray(amplitudes, dtype=float)
        self._frequencies = np.asarray(frequencies, dtype=float)
        self._phases = np.asarray(phases, dtype=float)

    def derivatives(self, t: Array | float, order: int) -> list[Array]:
        """Return positions and their derivatives; see :class:`ReferenceMotion`."""
        angle = np.asarray(t, dtype=float)[..., None, None] * self._frequencies + self._phases
        out = []
        for n in range(order + 1):
            terms = self._amplitudes * self._frequencies**n * np.sin(angle + n * np.pi / 2)
            out.append(terms.sum(axis=-1) + (self._centre if n == 0 else 0.0))
        return out


class MinimumJerk:
    """
    Minimum-jerk moves to and fro between two postures, with a rest after each.

    ``q = start + (goal - start) (10 s^3 - 15 s^4 + 6 s^5)``, s = t / duration.

    Examples
    --------
    >>> q, qd, qdd = MinimumJerk([0.0], [1.0], duration=2.0).derivatives(1.0, 2)
    >>> float(q[0]), float(qd[0]), float(qdd[0])
    (0.5, 0.9375, 0.0)

    """

    _SHARE = np.polynomial.Polynomial([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])

    def __init__(self, start: Array, goal: Array, duration: float = 2.0,
                 rest: float = 0.5) -> None:
        self._start = np.asarray(start, dtype=float)
        self._step = np.asarray(goal, dtype=float) - self._start
        self._duration, self._rest = duration, rest

    def derivatives(self, t: Array | float, order: int) -> list[Array]:
        """Return positions and their derivatives; see :class:`ReferenceMotion`."""
        period = self._duration + self._rest
        move, within = np.divmod(np.asarray(t, dtype=float), period)
        s = np.minimum(within / self._duration, 1.0)
        moving = within < self._duration
        back = np.mod(move, 2) == 1
        out = []
        for n in range(order + 1):
            value = self._SHARE.deriv(n)(s) / self._duration**n
            if n == 0:
                value = np.where(back, 1.0 - value, value)
            else:
                value = np.where(moving, np.where(back, -value, value), 0.0)
            out.append(value[..., None] * self._step + (self._start if n == 0 else 0.0))
        return out


def reference_motion(name: str, kinds: Sequence[str],
                     centre: Array | None = None, size: float = 1.0) -> ReferenceMotion:
    """
    Return one of the named motions for a robot's measured joints.

    The paper's sinusoids (its amplitudes repeat on arms of more than 6 joints), minimum-jerk moves
    to and fro, or a sum of five sinusoids of 0.1 to 2 Hz; about 10 degrees everywhere, as in the
    paper, if no centre is given. Prismatic joints move a quarter as many metres as the others move
    radians.
    """
    if name not in MOTIONS:
        raise ParameterError('motion', name, ', '.join(MOTIONS))
    dof = len(kinds)
    scale = np.array([METRES_PER_RADIAN if kind == 'prismatic' else 1.0
                      for kind in kinds])
    mean = PAPER_CENTRE * scale if centre is None else np.asarray(centre, dtype=float)
    amplitude = size * scale * np.resize(PAPER_AMPLITUDES, dof)
    if name == 'paper':
        return Sinusoids(mean, amplitude[:, None], np.ones((dof, 1)), np.zeros((dof, 1)))
    if name == 'minjerk':
        return MinimumJerk(mean - amplitude, mean + amplitude)
    hertz = np.array([0.1, 0.3, 0.7, 1.3, 2.0])
    # Amplitudes fall as 1/f, so that every sinusoid brings the same speed.
    amplitudes = amplitude[:, None] * (0.1 / hertz)
    # Golden-angle phases: spread evenly, and no two joints alike.
    phases = np.mod(np.arange(dof * hertz.size) * np.pi * (3.0 - np.sqrt(5.0)), 2 * np.pi)
    return Sinusoids(mean, amplitudes, np.tile(2 * np.pi * hertz, (dof, 1)),
                     phases.reshape(dof, hertz.size))
