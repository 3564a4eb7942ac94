# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Smoothing with a fixed lag: what the samples since then say about an instant ago."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence

import numpy as np

from .filter_step import Innovation, SteadyGains, Step
from .joint_motion import Array
from .wiener_process import transition


class Taps:
    """
    The smoother of converged filters: fixed weights on the innovations since the instant.

    Parameters
    ----------
    steady:
        The gains.
    length:
        Number of samples from the instant to the latest.

    References
    ----------
    B. D. O. Anderson, J. B. Moore, "Optimal Filtering", Prentice-Hall 1979, section 7.3
    (fixed-lag smoothing as a weighted sum of innovations).

    """

    def __init__(self, steady: SteadyGains, length: int) -> None:
        back = transition(steady.reference).T
        _, _, carried, (gain, precision, _), velocity = steady.step
        shape = carried.shape
        self.length = length
        self._covariance = carried
        self.position = np.empty((4, length, *shape[2:]))
        self.velocity = None if velocity is None else np.empty_like(self.position)
        self.reduction = np.zeros((length, *shape))
        for j in range(length):
            tap = carried[:, 0] * precision
            self.position[:, j] = tap
            self.reduction[j] = carried[:, 0, None] * tap
            onward = carried - carried[:, :1] * gain
            if velocity is not None and self.velocity is not None:
                tap = onward[:, 1] * velocity.precision
                self.velocity[:, j] = tap
                self.reduction[j] += onward[:, 1, None] * tap
                onward = onward - onward[:, 1:2] * velocity.gain
            carried = np.einsum('ijmn,jk->ikmn', onward, back)
        self.reduction = self.reduction.cumsum(axis=0)

    def covariance(self, length: int) -> Array:
        """Return the covariances of the filters at the instant, `length` samples up to now."""
        return self._covariance - self.reduction[length - 1]  # type: ignore[no-any-return]

    def correction(self, weights: Array, errors: Array) -> Array:
        """
        Return what the innovations add to the weighted mean of the filters' states.

        Parameters
        ----------
        weights: shape (M, n)
            Weights of the filters.
        errors: shape (2, length, M, n)
            Innovations of position and velocity, oldest first.

        Returns
        -------
        Shape (4, n), scaled.

        """
        length = errors.shape[1]
        taps = self.position[:, :length]
        if taps.shape[3] == 1:
            result = taps.reshape(4, -1).dot((errors[0] * weights).reshape(-1, weights.shape[1]))
        else:
            result = np.einsum('kjmn,jmn->kn', taps, errors[0] * weights)
        if self.velocity is not None:
            result += np.einsum('kjmn,jmn->kn', self.velocity[:, :length], errors[1] * weights)
        return result  # type: ignore[no-any-return]


Parts = Callable[[], 'tuple[Array, Array]']


class FixedLag:
    """
    The filters' states at an instant `delay` ago, given all samples since.

    In general the weighted innovations are carried back by the adjoint recursion; with converged
    gains the same sum has fixed weights (`Taps`).

    References
    ----------
    G. J. Bierman, "Fixed interval smoothing with discrete measurements", Int. J. Control 18
    (1973) 65-75 (the modified Bryson-Frazier form, which inverts no covariance).

    """

    def __init__(self, delay: float) -> None:
        self.delay = delay
        self._steps: deque[tuple[float, Step]] = deque()
        self._taps: Taps | None = None
        self._steady: SteadyGains | None = None
        self._run = 0
        self._place = -1

    def start(self) -> None:
        """Forget the run."""
        self._steps.clear()
        self._run = 0

    @property
    def taps(self) -> Taps | None:
        """Return what smooths the present steps, if all have been made with converged gains."""
        taps = self._taps
        count = len(self._steps)
        if taps is None or not 0 < count <= taps.length or self._run < count:
            return None
        return taps

    @property
    def steps(self) -> list[tuple[float, Step]]:
        """Stamps and steps from the delayed instant to the latest, oldest first."""
        return list(self._steps)

    def resume(self, steps: Sequence[tuple[float, Step]], steady: SteadyGains) -> None:
        """Go on after these steps, which have been made with converged gains."""
        self.start()
        for stamp, step in steps:
            self.push(stamp, step, steady)

    def push(self, stamp: float, step: Step, steady: SteadyGains | None) -> None:
        """Remember one step of the bank, and the gains it was made with if they are converged."""
        self._steps.append((stamp, step))
        if steady is None:
            self._run = 0
            return
        if steady is not self._steady:
            self._prepare(steady, step.position.error.shape)
        self._run += 1
        self._place += 1
        errors = self._errors
        if self._place == errors.shape[1]:
            errors[:, :self._length] = errors[:, -self._length:]
            self._place = self._length
        errors[0, self._place] = step.position.error
        if step.velocity is not None:
            errors[1, self._place] = step.velocity.error

    def _prepare(self, steady: SteadyGains, shape: tuple[int, ...]) -> None:
        self._steady = steady
        self._length = length = int(np.ceil(self.delay / steady.reference)) + 3
        self._taps = Taps(steady, length)
        self._errors = np.zeros((2, 4 * length + 16, *shape))
        self._place = -1
        self._run = 0

    def smooth(
        self, stamp: float, weights: Array, mean_of: Callable[[Array], Array]
    ) -> tuple[float, Array, Parts] | None:
        """
        Return the weighted mean of the filters at the last sample up to `stamp`.

        Parameters
        ----------
        stamp:
            The instant that is wanted, s.
        weights: shape (M, n)
            Weights of the filters.
        mean_of:
            Returns the mean of states (4, M, n) with these weights, shape (4, n).

        Returns
        -------
        The time of that sample, the scaled mean state (4, n), and a function that returns the
        states (4, M, n) and covariances (4, 4, M, g) it is the mean of; None if the run does not
        reach back so far.

        """
        steps = self._steps
        while len(steps) > 1 and steps[1][0] <= stamp + 1e-9:
            steps.popleft()
        if not steps or steps[0][0] > stamp + 1e-9:
            return None
        time, step = steps[0]
        count = len(steps)
        taps, since = self.taps, tuple(steps)
        if taps is None:
            state, _ = carry_back(since, covariance=False)
            return time, mean_of(state), lambda: carry_back(since)
        begin = self._place - count + 1
        mean = mean_of(step.state)
        mean += taps.correction(weights, self._errors[:, begin:self._place + 1])
        return time, mean, lambda: (
            carry_back(since, covariance=False)[0], taps.covariance(count))


def carry_back(
    steps: Sequence[tuple[float, Step]], covariance: bool = True
) -> tuple[Array, Array]:
    """
    Return states and covariances at the first of some steps, given all of them.

    Parameters
    ----------
    steps:
        Stamps and steps of the bank, oldest first.
    covariance:
        Whether to compute the covariances too; else those before the first sample are returned.

    """
    adjoint = np.zeros_like(steps[0][1].state)
    information = np.zeros_like(steps[-1][1].covariance) if covariance else None
    back = np.eye(4)
    for _, step in reversed(steps):
        adjoint = _apply(back, adjoint)
        if information is not None:
            information = _apply(back, _apply(back, information).swapaxes(0, 1))
        if step.velocity is not None:
            _observe(1, step.velocity, adjoint, information)
        _observe(0, step.position, adjoint, information)
        back = transition(step.dt).T
    first = steps[0][1]
    state = first.state + (first.covariance * adjoint).sum(axis=1)
    if information is None:
        return state, first.covariance
    known = np.einsum(
        'ijmn,jkmn,klmn->ilmn', first.covariance, information, first.covariance, optimize=True)
    return state, first.covariance - known


def _apply(matrix: Array, x: Array) -> Array:
    """Multiply the first axis of `x` by a (4, 4) matrix."""
    return matrix.dot(x.reshape(4, -1)).reshape(x.shape)


def _observe(i: int, update: Innovation, adjoint: Array, information: Array | None) -> None:
    """Carry adjoint and information back through the update with a measurement of component i."""
    gain, precision, error = update
    adjoint[i] += error * precision - (gain * adjoint).sum(axis=0)
    if information is not None:
        information[i] -= (gain[:, None] * information).sum(axis=0)
        information[:, i] -= (gain * information).sum(axis=1)
        information[i, i] += precision
