# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Fourth divided differences: what is left of a smooth motion is its noise."""

from __future__ import annotations

import numpy as np

from .joint_motion import Array

_DIAGONAL = np.eye(5)


def divided_difference(t: Array) -> Array:
    """
    Return the coefficients of the fourth divided difference on five stamps.

    It vanishes on cubics for any stamps, so that of a smooth motion it leaves the noise.

    Parameters
    ----------
    t: shape (..., 5)
        Stamps, s.

    Returns
    -------
    Coefficients, shape (..., 5), divided by their norm: white noise keeps its variance.

    Examples
    --------
    >>> t = np.array([0.0, 0.1, 0.25, 0.3, 0.4])
    >>> bool(abs(divided_difference(t) @ t**3) < 1e-12)
    True

    """
    coefficients = 1.0 / (t[..., :, None] - t[..., None, :] + _DIAGONAL).prod(axis=-1)
    return coefficients / np.sqrt((coefficients**2).sum(axis=-1, keepdims=True))
