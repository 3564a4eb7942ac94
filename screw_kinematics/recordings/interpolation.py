# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Values between samples."""
from __future__ import annotations

import numpy as np

from ..screws.se3 import Array

NODES = 4
"""Samples that a value depends on."""


def interpolate(instants: Array, values: Array, at: Array) -> Array:
    """
    Return values between samples, by the cubic through the four nearest ones.

    Instants increase [ns], and are at least four; samples themselves are returned as they are.

    Examples
    --------
    >>> t = np.array([0, 1, 3, 4, 6])
    >>> interpolate(t, t[:, None] ** 3.0, np.array([2, 3])).ravel()
    array([ 8., 27.])

    """
    before = np.searchsorted(instants, at, side='right') - 1
    first = np.clip(before - 1, 0, len(instants) - NODES)
    nodes = [(instants[first + i] - at).astype(float) for i in range(NODES)]
    out = np.zeros((len(at), values.shape[1]))
    for i, node in enumerate(nodes):
        weight = np.ones(len(at))
        for j, other in enumerate(nodes):
            if j != i:
                weight *= other / (other - node)
        out += weight[:, None] * values[first + i]
    return out
