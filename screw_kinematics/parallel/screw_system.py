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

RANK_TOLERANCE = 1e-6
"""Relative size below which a singular value counts as zero where ranks are decided."""
SINGULAR = 1e-6
"""Value of a :class:`Conditioning` from which on a posture counts as singular."""
_TINY = 1e-300


class LimbScrews(NamedTuple):
    """Unit screws of the joints about the platform point, in base axes; zero where absent."""

    passive: Array     # (limbs, 6, most passive joints of a limb)
    actuated: Array    # (limbs, 6, actuated joints)


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

    A limb of rank r has its r largest singular values, and 6 - r reciprocal wrenches, in singular
    postures too: nothing jumps when a singularity is passed.
    """

    kept: Array           # (limbs, singular values), which of them count
    limb_of_row: Array    # limb of each reciprocal wrench
    row: Array            # and its place among the left singular vectors

    @classmethod
    def of(cls, sizes: Array) -> Ranks:
        """Return the ranks that singular values show, of shape (limbs, n), largest first."""
        ranks = np.sum(sizes > RANK_TOLERANCE * sizes[:, :1], axis=1)[:, None]
        return cls(np.arange(sizes.shape[1]) < ranks, *np.nonzero(np.arange(6) >= ranks))


class ScrewSystem:
    """
    The limbs' screws at one posture, about the platform point, and what follows from them.

    Linear parts are divided by the characteristic length [m], so that angles and lengths are
    comparable in all least squares and singular values. Rows, of shape (wrenches, 6), are
    reciprocal to the passive screws of a limb each, limb after limb: :attr:`wrenches` in the order
    of a row, of unit size with that length.
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

        The bias ``A_k a + b_k``, of shape (limbs, 6), is what each limb's tip does with its
        passive joints at rest. The state is of least squares, where limbs disagree; rates are of
        shape (limbs, slots).
        """
        bias = bias * self._scale
        onto = (self.rows * bias[self._limb_of_row]).sum(axis=1)
        state = self._platform @ onto
        rates = self._from_tip @ (state - bias)[..., None]
        return state / self._scale, rates[..., 0]

    def solve_joints(self, demand: Array) -> tuple[Array, Array]:
        """
        Return the rates of the actuated joints, and of the passive ones by limb, platform given.

        The demand ``X - b_k``, of shape (limbs, 6), is what each limb's joints have to bring
        about.
        """
        demand = demand * self._scale
        onto = (self.rows * demand[self._limb_of_row]).sum(axis=1)
        actuated = self._actuators @ onto
        rest = demand - self._actuated @ actuated
        return actuated, (self._from_tip @ rest[..., None])[..., 0]

    def actuated_motion(self, actuated: Array) -> Array:
        """Return ``A_k a``, (limbs, 6): the motion of the tips with the passive joints at rest."""
        return (self._actuated @ actuated) / self._scale

    def passive_motion(self, passive: Array) -> Array:
        """Return ``P_k p``, (limbs, 6): the motion of the tips with the actuators at rest."""
        return (self._passive @ passive[..., None])[..., 0] / self._scale

    def size(self, six_vectors: Array) -> Array:
        """Return the norm of six-vectors with the characteristic length [rad, rad/s]."""
        return np.linalg.norm(six_vectors * self._scale, axis=-1)

    @cached_property
    def work(self) -> Array:
        """
        Return the Klein form of each reciprocal wrench with each actuated screw.

        Shape (wrenches, actuated joints); both scaled by the characteristic length.
        """
        return np.einsum('ri,rij->rj', self.rows, self._actuated[self._limb_of_row])

    def mobility(self) -> int:
        """Return the number of freedoms of the platform and the actuated joints together."""
        both = np.linalg.svd(np.hstack([self.rows, -self.work]), compute_uv=False)
        return 6 + self.work.shape[1] - int(np.sum(both > RANK_TOLERANCE * both[0]))

    def limb_wrenches(self) -> tuple[list[Array], list[Array]]:
        """
        Return the reciprocal wrenches of each limb: those held by actuators, and constraints.

        Unit screws ``(force; moment)``, couples of unit moment. The former do positive work in
        their actuators' positive sense; the latter are reciprocal to all joints of the limb.
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

        It is the determinant of the platform's system times that of a posture nearby, each limb's
        wrenches matched with those before: negative if there is a direct singularity in between.
        """
        same = self._blocking @ before._blocking
        return float(np.linalg.det(same.sum(axis=0)))

    def working_signs(self, before: ScrewSystem) -> Array:
        """Return -1 for each actuator that passed an inverse singularity since then, else 1."""
        now, then = (s._blocking @ s._actuated for s in (self, before))
        return np.where(np.einsum('kij,kij->j', now, then) < 0, -1, 1)

    @cached_property
    def _blocking(self) -> Array:
        """Projectors onto the limbs' reciprocal wrenches, shape (limbs, 6, 6)."""
        rows = self.rows
        out = np.zeros((len(self._passive), 6, 6))
        np.add.at(out, self._limb_of_row, rows[:, :, None] * rows[:, None, :])
        return out
