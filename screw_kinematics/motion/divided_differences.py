# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Divided differences of high order: what is left of a smooth motion is its noise."""

from __future__ import annotations

import numpy as np

from .joint_motion import Array


def divided_difference(t: Array) -> Array:
    """
    Return the coefficients of the divided difference of order n on n + 1 stamps, s.

    It vanishes on polynomials of lower degree for any stamps, so that of a smooth motion it leaves
    the noise. Stamps and coefficients have shape (..., n + 1); the latter are divided by their
    norm: white noise keeps its variance.

    Examples
    --------
    >>> t = np.array([0.0, 0.1, 0.25, 0.3, 0.4])
    >>> bool(abs(divided_difference(t) @ t**3) < 1e-12)
    True

    """
    coefficients = 1.0 / (t[..., :, None] - t[..., None, :] + np.eye(t.shape[-1])).prod(axis=-1)
    return coefficients / np.sqrt((coefficients**2).sum(axis=-1, keepdims=True))


def roughness(t: Array, q: Array, order: int = 4) -> Array:
    """
    Return what divided differences of some order leave of some signals, most of the time.

    Of signals, shape (N, n), at increasing times, s, shape (N,): the square root of the mean of
    squares, shape (n,), without the largest tenth.
    """
    rows = np.arange(order + 1) + np.arange(len(t) - order)[:, None]
    left = np.einsum('ik,ikj->ij', divided_difference(t[rows] - t[rows[:, :1]]), q[rows])
    squares = np.sort(left**2, axis=0)[:max(1, int(0.9 * len(left)))]
    return np.sqrt(squares.mean(axis=0))  # type: ignore[no-any-return]
