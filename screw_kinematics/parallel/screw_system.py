# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The linear system of a parallel manipulator's limbs at one posture.

For every order n of time derivative, and for a displacement to first order, each limb k
says the same thing: the platform's state X is the state of that limb's tip,

    X = P_k p + A_k a + b_k

with the screws P_k and rates p of its passive joints, A_k and a of its actuated ones, and
a bias b_k of lower orders only. Wrenches reciprocal to all P_k (Klein form zero) eliminate
the passive joints, limb by limb; what remains is one small system for the platform, the
same for all orders.
"""
from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..screws.se3 import Array

__all__ = ['Conditioning', 'LimbScrews', 'Ranks', 'ScrewSystem', 'SINGULAR']

RANK_TOLERANCE = 1e-6
"""Relative size below which a singular value counts as zero where ranks are decided."""
SINGULAR = 1e-6
"""Value of a :class:`Conditioning` from which on a posture counts as singular."""
_TINY = 1e-300


class LimbScrews(NamedTuple):
    """
    Unit screws of the joints about the platform point, in base axes; zero where absent.

    Parameters
    ----------
    passive : array, shape (limbs, 6, most passive joints of a limb)
        Of the passive joints, limb by limb.
    actuated : array, shape (limbs, 6, actuated joints)
        Of the actuated joints, in each limb.

    """

    passive: Array
    actuated: Array


@dataclass(frozen=True)
class Conditioning:
    """
    Distances to singular postures; 0 is singular.

    Parameters
    ----------
    direct : float
        Smallest singular value of the platform's reciprocal wrenches, each of unit size,
        with the characteristic length: at 0 the platform moves with the actuators locked.
    inverse : float
        Smallest singular value of the actuators' work on these wrenches, each actuator's
        screw scaled to unit size: at 0 an actuator moves with the platform at rest.
    limbs : float
        Smallest over the limbs, of the ratio of smallest to largest singular value of the
        limb's passive screws: at 0 passive joints move with the platform at rest.

    """

    direct: float
    inverse: float
    limbs: float


class Ranks(NamedTuple):
    """
    Ranks of the limbs' passive screws in general posture.

    A limb of rank r has its r largest singular values, and 6 - r reciprocal wrenches, in
    singular postures too: nothing jumps when a singularity is passed.

    Parameters
    ----------
    kept : array of bool, shape (limbs, singular values)
        Which singular values count.
    limb_of_row, row : array of int, shape (wrenches,)
        Limb of each reciprocal wrench, and its place among the left singular vectors.

    """

    kept: Array
    limb_of_row: Array
    row: Array

    @classmethod
    def of(cls, sizes: Array) -> Ranks:
        """
        Return the ranks that singular values show.

        Parameters
        ----------
        sizes : array, shape (limbs, n)
            Singular values of the passive screws, largest first.

        Returns
        -------
        Ranks
            In a posture that is not singular those in general.

        """
        ranks = np.sum(sizes > RANK_TOLERANCE * sizes[:, :1], axis=1)[:, None]
        return cls(np.arange(sizes.shape[1]) < ranks, *np.nonzero(np.arange(6) >= ranks))


class ScrewSystem:
    """
    The limbs' screws at one posture, and what follows from them.

    Parameters
    ----------
    screws : LimbScrews
        About the platform point, in base axes.
    length : float
        Characteristic length [m]: linear parts are divided by it, so that angles and
        lengths are comparable in all least squares and singular values.
    ranks : Ranks, optional
        Of the limbs' passive screws in general posture. Default: as found here.

    Attributes
    ----------
    rows : array, shape (wrenches, 6)
        Reciprocal to the passive screws of a limb each, limb after limb: :attr:`wrenches`
        in the order of a row, of unit size with the characteristic length.

    """

    def __init__(self, screws: LimbScrews, length: float, ranks: Ranks | None = None) -> None:
        inverse = 1 / length
        self._scale = np.array([1.0, 1.0, 1.0, inverse, inverse, inverse])
        self.length = length
        self._passive = screws.passive * self._scale[:, None]
        self._actuated = screws.actuated * self._scale[:, None]
        left, self._sizes, right = np.linalg.svd(self._passive)
        self.ranks = ranks = Ranks.of(self._sizes) if ranks is None else ranks
        n = self._sizes.shape[1]
        # Moore-Penrose inverse of the passive screws, of the given rank.
        self._from_tip = (right[:, :n].swapaxes(1, 2) * (
            ranks.kept / np.maximum(self._sizes, _TINY))[:, None]) @ left[:, :, :n].swapaxes(1, 2)
        # Rows reciprocal to the passive screws: unit wrenches, limb after limb.
        self._limb_of_row = ranks.limb_of_row
        self.rows = left[ranks.limb_of_row, :, ranks.row]
        u, self._platform_sizes, vt = np.linalg.svd(self.rows, full_matrices=False)
        self._platform = (vt.T / np.maximum(self._platform_sizes, _TINY)) @ u.T

    def solve_platform(self, bias: Array) -> tuple[Array, Array]:
        """
        Return the platform's state and the passive joints' rates, actuators given.

        Parameters
        ----------
        bias : array, shape (limbs, 6)
            ``A_k a + b_k``: what each limb's tip does with its passive joints at rest.

        Returns
        -------
        state : array, shape (6,)
            Least squares over the limbs, where they disagree.
        rates : array, shape (limbs, slots)
            Of the passive joints.

        """
        bias = bias * self._scale
        onto = (self.rows * bias[self._limb_of_row]).sum(axis=1)
        state = self._platform @ onto
        rates = self._from_tip @ (state - bias)[..., None]
        return state / self._scale, rates[..., 0]

    def solve_joints(self, demand: Array) -> tuple[Array, Array]:
        """
        Return the rates of all joints, platform given.

        Parameters
        ----------
        demand : array, shape (limbs, 6)
            ``X - b_k``: what each limb's joints have to bring about.

        Returns
        -------
        actuated : array, shape (actuated joints,)
            Rates [rad/s, m/s].
        passive : array, shape (limbs, slots)
            Rates [rad/s, m/s].

        """
        demand = demand * self._scale
        onto = (self.rows * demand[self._limb_of_row]).sum(axis=1)
        actuated = self._actuators @ onto
        rest = demand - self._actuated @ actuated
        return actuated, (self._from_tip @ rest[..., None])[..., 0]

    def actuated_motion(self, actuated: Array) -> Array:
        """
        Return ``A_k a``: the motion of the limbs' tips with the passive joints at rest.

        Parameters
        ----------
        actuated : array, shape (actuated joints,)
            Rates [rad/s, m/s].

        Returns
        -------
        array, shape (limbs, 6)
            Twists about the platform point.

        """
        return (self._actuated @ actuated) / self._scale

    def passive_motion(self, passive: Array) -> Array:
        """
        Return ``P_k p``: the motion of the limbs' tips with the actuated joints at rest.

        Parameters
        ----------
        passive : array, shape (limbs, slots)
            Rates [rad/s, m/s].

        Returns
        -------
        array, shape (limbs, 6)
            Twists about the platform point.

        """
        return (self._passive @ passive[..., None])[..., 0] / self._scale

    def size(self, six_vectors: Array) -> Array:
        """
        Return the norm with the characteristic length.

        Parameters
        ----------
        six_vectors : array, shape (..., 6)
            Twists, or displacements.

        Returns
        -------
        array, shape (...)
            In rad or rad/s.

        """
        return np.linalg.norm(six_vectors * self._scale, axis=-1)

    @cached_property
    def work(self) -> Array:
        """
        Return the Klein form of each reciprocal wrench with each actuated screw.

        Shape (wrenches, actuated joints); both scaled by the characteristic length.
        """
        return np.einsum('ri,rij->rj', self.rows, self._actuated[self._limb_of_row])

    def mobility(self) -> int:
        """
        Return the number of freedoms of the platform and the actuated joints together.

        Returns
        -------
        int
            Of the loops that are closed at this posture.

        """
        both = np.linalg.svd(np.hstack([self.rows, -self.work]), compute_uv=False)
        return 6 + self.work.shape[1] - int(np.sum(both > RANK_TOLERANCE * both[0]))

    def limb_wrenches(self) -> tuple[list[Array], list[Array]]:
        """
        Return the reciprocal wrenches of each limb, those held by actuators apart.

        Returns
        -------
        actuation, constraint : list of array, shape (n, 6)
            Unit screws ``(force; moment)``, couples of unit moment. The former do positive
            work in their actuators' positive sense; the latter are reciprocal to all joints
            of the limb.

        """
        actuation, constraint = [], []
        for limb in range(len(self._passive)):
            rows = self._limb_of_row == limb
            u, sizes, vt = np.linalg.svd(self.work[rows])
            held = int(np.sum(sizes > RANK_TOLERANCE))
            strongest = np.argmax(np.abs(vt), axis=1)
            sign = np.ones(len(u))
            sign[:held] = np.sign(vt[np.arange(held), strongest[:held]])
            basis = sign[:, None] * (u.T @ self.wrenches[rows])
            force = np.linalg.norm(basis[:, :3], axis=1)
            couple = force <= RANK_TOLERANCE * np.linalg.norm(basis, axis=1)
            basis /= np.where(couple, np.linalg.norm(basis[:, 3:], axis=1), force)[:, None]
            actuation.append(basis[:held])
            constraint.append(basis[held:])
        return actuation, constraint

    @cached_property
    def _actuators(self) -> Array:
        """Pseudo-inverse of :attr:`work`."""
        return np.linalg.pinv(self.work)

    @cached_property
    def jacobian(self) -> Array:
        """Platform twist by actuated rates, shape (6, actuated joints)."""
        return (self._platform @ self.work) / self._scale[:, None]

    @property
    def wrenches(self) -> Array:
        """
        Screws ``(force; moment)`` reciprocal to the passive joints of a limb each.

        Shape (wrenches, 6), about the platform point, in base axes. They carry the
        platform when the actuators are locked.
        """
        return np.roll(self.rows * self._scale, 3, axis=-1)

    @cached_property
    def conditioning(self) -> Conditioning:
        """Distances to singular postures."""
        sizes = np.linalg.norm(self._actuated, axis=(0, 1))
        inverse = np.linalg.svd(self.work / sizes, compute_uv=False)
        used = np.where(self.ranks.kept, self._sizes, np.inf)
        ratios = used / np.maximum(self._sizes[:, :1], _TINY)
        return Conditioning(self.direct_conditioning, float(inverse[-1]), float(ratios.min()))

    @property
    def direct_conditioning(self) -> float:
        """Smallest singular value of the reciprocal wrenches, of unit size each."""
        return float(self._platform_sizes[-1]) if len(self.rows) >= 6 else 0.0

    def assembly_sign(self, before: ScrewSystem) -> float:
        """
        Return a number whose sign tells whether the assembly mode is the same.

        It is the determinant of the platform's system times that of a posture nearby,
        each limb's wrenches matched with those before: negative if there is a direct
        singularity in between.

        Parameters
        ----------
        before : ScrewSystem
            Of the posture nearby.

        Returns
        -------
        float
            Only its sign means something.

        """
        same = self._blocking @ before._blocking
        return float(np.linalg.det(same.sum(axis=0)))

    def working_signs(self, before: ScrewSystem) -> Array:
        """
        Return -1 for each actuator that passed an inverse singularity, else 1.

        Parameters
        ----------
        before : ScrewSystem
            Of a posture nearby.

        Returns
        -------
        array, shape (actuated joints,)
            Relative to that posture.

        """
        now, then = (s._blocking @ s._actuated for s in (self, before))
        return np.where(np.einsum('kij,kij->j', now, then) < 0, -1, 1)

    @cached_property
    def _blocking(self) -> Array:
        """Projectors onto the limbs' reciprocal wrenches, shape (limbs, 6, 6)."""
        rows = self.rows
        out = np.zeros((len(self._passive), 6, 6))
        np.add.at(out, self._limb_of_row, rows[:, :, None] * rows[:, None, :])
        return out
