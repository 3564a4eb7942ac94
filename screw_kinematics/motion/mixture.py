# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Covariance of a weighted mean of filters."""

from __future__ import annotations

import numpy as np

from .joint_motion import Array
from .wiener_process import SCALE


def mixture_covariance(
    weights: Array, noise: Array, x: Array, p: Array, onward: Array | None = None
) -> Array:
    """
    Return the covariance within and between the filters, in physical units.

    Parameters
    ----------
    weights: shape (M, n)
        Weights of the M filters for each of n joints.
    noise: shape (M, n)
        Each filter's estimate of the variance that the unit of its covariance stands for.
    x: shape (4, M, n)
        Scaled states.
    p: shape (4, 4, M, n) or (4, 4, M, 1)
        Scaled covariances.
    onward: shape (4, 4)
        Transition still to apply.

    Returns
    -------
    Shape (n, 4, 4).

    """
    apart = x - np.einsum('mn,kmn->kn', weights, x)[:, None]
    full = np.broadcast_to(p, (4, 4, *x.shape[1:]))
    within = np.einsum('mn,ijmn->nij', weights * noise, full)
    between = np.einsum('imn,jmn->nij', weights * apart, apart)
    total = within + between
    if onward is not None:
        total = onward @ total @ onward.T
    total = 0.5 * (total + total.swapaxes(1, 2))
    return total / np.outer(SCALE, SCALE)  # type: ignore[no-any-return]
