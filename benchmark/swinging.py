# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joints that swing smoothly, with exact derivatives."""
from collections.abc import Iterable

import numpy as np


def swing(t: np.ndarray, n: int, random: np.random.Generator,
          sines: Iterable[tuple[float, float]]) -> list[np.ndarray]:
    """
    Return positions, velocities and accelerations of n joints at times [s], shape (N, n) each.

    Sines are frequencies [Hz] and amplitudes [rad]; their phases are random.
    """
    out = [np.zeros((len(t), n)) for _ in range(3)]
    out[0] += np.linspace(0.3, 1.0, n)
    for frequency, amplitude in sines:
        w = 2 * np.pi * frequency
        phase = w * t[:, None] + random.uniform(0, 2 * np.pi, n)
        out[0] += amplitude * np.sin(phase)
        out[1] += amplitude * w * np.cos(phase)
        out[2] -= amplitude * w**2 * np.sin(phase)
    return out
