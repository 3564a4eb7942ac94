# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Mass, centre, inertia of a payload and the bias of a force sensor, from motion and wrenches.

The wrench is linear in ten inertial parameters and six biases; they are found by least squares,
each channel weighted by what is left of it. Standard deviations come from the scores of half a
second each, so that noise may be coloured.

References
----------
Atkeson, An, Hollerbach, "Estimation of Inertial Parameters of Manipulator Loads and Links",
International Journal of Robotics Research 5(3), 1986.

"""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .clock_offset import BLOCK
from .interpolation import interpolate
from .link_motion import LinkMotion
from ..errors import ToolError
from ..pipeline.payload import felt_wrench, inertia_matrix, INERTIAL, Payload
from ..screws.se3 import Array

_BODY = len(INERTIAL)
_MOST = 40_000      # wrenches that are looked at
_FEWEST = 100
_PASSES = 6
_OUTLIER = 6.0      # times the scale of what is left: contact
_STILL = 1e-3       # of the specific force that does not change: nothing moves


@dataclass(frozen=True)
class PayloadFit:
    """A payload and the sensor that carries it, and what told of them."""

    payload: Payload     # as found; its inertia need not be that of a body
    bias: Array          # (6,), of the sensor [N, N m]
    sign: float          # 1: the load exerts the measured wrench; -1: the sensor does
    deviations: Array    # (16,), of mass, centre, inertia about it, bias
    stamps: Array        # (N,), of the wrenches that were looked at [ns]
    used: Array          # (N,), which of them were not taken for contact
    measured: Array      # (N, 6), wrenches less bias
    unloaded: Array      # less the weight, too
    left: Array          # less the inertia, too
    force: Array         # (3, 3), covariance of the specific force, in the sensor's axes
    turning: Array       # (3, 3), mean square of the angular acceleration, likewise

    def rms(self, wrenches: Array) -> tuple[float, float]:
        """Return the RMS of force and torque without contact [N, N m]."""
        squares = (wrenches[self.used].reshape(-1, 2, 3)**2).sum(axis=2)
        force, torque = np.sqrt(squares.mean(axis=0))
        return float(force), float(torque)


def fit_payload(link: LinkMotion, stamps: Array, wrenches: Array, gravity: Sequence[float],
                ) -> PayloadFit:
    """
    Return the payload that explains the wrenches of a sensor, fixed to a link, best.

    Stamps increase [ns], wrenches are of shape (N, 6) [N, N m], gravity is the acceleration of
    free fall in base axes [m/s^2].

    Raises
    ------
    ToolError
        Motion and wrenches do not overlap, or nothing moves.

    """
    inside = (stamps >= link.stamps[0]) & (stamps <= link.stamps[-1])
    if inside.sum() < _FEWEST:
        raise ToolError(f'{int(inside.sum())} of {len(stamps)} wrenches were measured while joint '
                        f'states came; allowed: at least {_FEWEST} (do they overlap in time?)')
    thin = max(int(inside.sum()) // _MOST, 1)
    at, measured = stamps[inside][::thin], wrenches[inside][::thin]
    force, omega, alpha = np.split(interpolate(link.stamps, np.concatenate([
        link.in_link(link.acceleration - np.asarray(gravity)), link.in_link(link.angular_velocity),
        link.in_link(link.angular_acceleration)], axis=1), at), 3, axis=1)
    spread = np.cov(force.T)
    if np.sqrt(np.trace(spread)) < _STILL * np.linalg.norm(gravity):
        raise ToolError('nothing moves while wrenches are measured: a payload cannot be told from '
                        "the sensor's bias")
    still = np.zeros_like(force)
    design, weight = (_design(*motion) for motion in ((force, omega, alpha),
                                                      (_free(link, gravity, at), still, still)))
    block = ((at - at[0]) // round(BLOCK * 1e9)).astype(int)
    found, covariance, used, rest = _solve(design, measured, block)
    sign = -1.0 if found[0] < 0 else 1.0
    body = sign * found[:_BODY]
    if not abs(body[0]) > 1e-12:
        raise ToolError('the wrenches do not depend on the motion: is it this robot and sensor?')
    return PayloadFit(
        Payload.of(body), found[_BODY:], sign,
        _deviations(sign * found[:_BODY], covariance),
        at, used, measured - found[_BODY:], measured - weight @ found, rest, spread,
        alpha.T @ alpha / len(alpha))


def nearest_body(inertia: Sequence[float]) -> tuple[float, ...]:
    """
    Return the inertia of a body that is nearest to six numbers.

    Examples
    --------
    >>> [round(x, 6) + 0.0 for x in nearest_body((1.0, 0.0, 0.0, 1.0, 0.0, 3.0))]
    [1.5, 0.0, 0.0, 1.5, 0.0, 3.0]
    >>> nearest_body((2.0, 0.0, 0.0, 2.0, 0.0, 3.0))
    (2.0, 0.0, 0.0, 2.0, 0.0, 3.0)

    """
    matrix = inertia_matrix(inertia)
    # How the mass is spread, which is no less than zero in any direction.
    sizes, axes = np.linalg.eigh(np.trace(matrix) / 2 * np.eye(3) - matrix)
    if sizes[0] >= 0:
        return tuple(inertia)
    spread = (axes * np.maximum(sizes, 1e-9 * sizes[2])) @ axes.T
    body = np.trace(spread) * np.eye(3) - spread
    return tuple((body[np.triu_indices(3)] + 0.0).tolist())


def _design(force: Array, omega: Array, alpha: Array) -> Array:
    """Return what the wrench is linear in, shape (N, 6, 16)."""
    design = np.zeros((len(force), 6, _BODY + 6))
    for k, unit in enumerate(np.eye(_BODY)):
        design[:, :, k] = np.stack(np.broadcast_arrays(
            *felt_wrench(unit.tolist(), force.T, omega.T, alpha.T)), axis=1)
    design[:, :, _BODY:] = np.eye(6)
    return design


def _free(link: LinkMotion, gravity: Sequence[float], at: Array) -> Array:
    """Return the specific force at rest at instants, shape (N, 3)."""
    resting = -link.in_link(np.broadcast_to(np.asarray(gravity), link.position.shape))
    return interpolate(link.stamps, resting, at)


def _solve(design: Array, measured: Array, block: Array) -> tuple[Array, Array, Array, Array]:
    """Return the parameters, their covariance, which samples were used, and what is left."""
    weights, used = np.ones(6), np.ones(len(measured), bool)
    for _ in range(_PASSES):
        x, y = design[used], measured[used]
        scaled = x * np.sqrt(weights)[:, None]
        flat = scaled.reshape(-1, x.shape[2])
        inverse = np.linalg.pinv(flat.T @ flat, rcond=1e-12, hermitian=True)
        found = inverse @ np.einsum('nck,nc->k', x * weights[:, None], y)
        rest = measured - design @ found
        scale = 1.4826 * np.median(np.abs(rest), axis=0)
        used = (np.abs(rest) <= _OUTLIER * np.maximum(scale, 1e-12)).all(axis=1)
        weights = 1 / np.maximum((rest[used]**2).mean(axis=0), 1e-24)
    scores = np.zeros((int(block[-1]) + 1, design.shape[2]))
    np.add.at(scores, block[used],
              np.einsum('nck,nc->nk', design[used] * weights[:, None], rest[used]))
    coloured = inverse @ (scores.T @ scores) @ inverse
    larger = np.sqrt(np.maximum(np.diag(coloured) / np.maximum(np.diag(inverse), 1e-300), 1.0))
    return found, inverse * np.outer(larger, larger), used, rest


def _deviations(body: Array, covariance: Array) -> Array:
    """Return standard deviations of mass, centre, inertia about it, and bias."""
    def parts(parameters: Array) -> Array:
        payload = Payload.of(parameters.tolist())
        return np.array([payload.mass, *payload.center, *payload.inertia])

    steps = 1e-6 * np.maximum(np.abs(body), 1e-3 * abs(body[0]))
    slopes = np.stack([(parts(body + step) - parts(body - step)) / (2 * step.sum())
                       for step in np.diag(steps)], axis=1)
    own = slopes @ covariance[:_BODY, :_BODY] @ slopes.T
    return np.sqrt(np.maximum(np.concatenate([np.diag(own), np.diag(covariance)[_BODY:]]), 0.0))
