# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Differentiators that no package has, written from their papers; each knows the past only.

References
----------
F. Janabi-Sharifi, V. Hayward, C.-S. J. Chen, "Discrete-time adaptive windowing for velocity
estimation", IEEE Transactions on Control Systems Technology 8(6), 2000, pp. 1003-1009.
A. Levant, "Higher-order sliding modes, differentiation and output-feedback control",
International Journal of Control 76(9-10), 2003, pp. 924-941; as a discrete system: M. Livne,
A. Levant, "Proper discretization of homogeneous differentiators", Automatica 50(8), 2014,
pp. 2007-2014.

"""

from __future__ import annotations

from math import pi
from time import perf_counter

from benchmark.estimation.samples import Result, Samples
import numpy as np

from screw_kinematics.motion.divided_differences import roughness

LONGEST_WINDOW = 0.2
"""Of the adaptive window, s."""

GAINS = (1.1, 1.5, 2.0, 3.0)
"""Of the exact differentiator, from the highest derivative down (Levant 2003, section 6)."""


def adaptive_window(samples: Samples, bound: float) -> Result:
    """
    Fit a parabola to the longest window in which it stays within a bound of all positions.

    FOAW of Janabi-Sharifi, Hayward and Chen, best fit, with parabolas for lines, so that there
    is an acceleration; `bound` is in steps of the encoder or, if that is more, in its noise.
    """
    begin = perf_counter()
    rows = samples.increasing()
    q, period = samples.positions[rows], samples.period()
    limit = bound * np.maximum(_steps(q), roughness(samples.stamps[rows], q))
    longest = int(np.clip(LONGEST_WINDOW / period, 6, len(q)))
    fits = {n: np.linalg.qr(np.vander(np.arange(1.0 - n, 1.0), 3, increasing=True))
            for n in range(4, longest + 1)}
    v, a = np.zeros_like(q), np.zeros_like(q)
    reach = np.full(q.shape[1], 4)
    for k in range(3, len(q)):
        for j in range(q.shape[1]):
            # Windows change by little from sample to sample: go on from the last one.
            n = min(reach[j] + 1, k + 1, longest)
            while True:
                basis, triangle = fits[n]
                y = q[k + 1 - n:k + 1, j] - q[k, j]
                projected = basis.T @ y
                if n == 4 or np.abs(y - basis @ projected).max() <= limit[j]:
                    break
                n = max(4, n - max(1, n // 8))
            reach[j] = n
            c = np.linalg.solve(triangle, projected)
            v[k, j], a[k, j] = c[1] / period, 2 * c[2] / period**2
    return _result(samples, rows, v, a, begin)


def exact_differentiator(samples: Samples, lipschitz: float) -> Result:
    """
    Run Levant's robust exact differentiator of third order.

    `lipschitz` is the bound on the fourth derivative, rad/s^4; Euler steps with the terms of
    Taylor that Livne and Levant add.
    """
    begin = perf_counter()
    rows = samples.increasing()
    t, q = samples.stamps[rows], samples.positions[rows]
    z = np.zeros((4, q.shape[1]))
    z[0] = q[0]
    v, a = np.zeros_like(q), np.zeros_like(q)
    for k in range(1, len(q)):
        dt = t[k] - t[k - 1]
        # The correction of each derivative is driven by that of the one before.
        rate, error = np.zeros_like(z), z[0] - q[k - 1]
        for i, gain in enumerate(reversed(GAINS)):
            error = gain * lipschitz**(1 / (4 - i)) * np.abs(error)**((3 - i) / (4 - i)) * np.sign(
                error)
            rate[i] = (z[i + 1] if i < 3 else 0.0) - error
        z = z + dt * rate
        z[0] += dt**2 / 2 * z[2] + dt**3 / 6 * z[3]
        z[1] += dt**2 / 2 * z[3]
        v[k], a[k] = z[1], z[2]
    return _result(samples, rows, v, a, begin)


def exponential_smoothing(samples: Samples, cutoff: float) -> Result:
    """
    Difference, smooth exponentially, and once more, as the filters of ros2_control do.

    The smoothing factor is that of a first-order low-pass with this cutoff, Hz, at the median
    period.
    """
    begin = perf_counter()
    rows = samples.increasing()
    t, q = samples.stamps[rows], samples.positions[rows]
    alpha = 1 - np.exp(-2 * pi * cutoff * samples.period())
    v, a = np.zeros_like(q), np.zeros_like(q)
    for k in range(1, len(q)):
        dt = t[k] - t[k - 1]
        v[k] = v[k - 1] + alpha * ((q[k] - q[k - 1]) / dt - v[k - 1])
        a[k] = a[k - 1] + alpha * ((v[k] - v[k - 1]) / dt - a[k - 1])
    return _result(samples, rows, v, a, begin)


def _steps(q: np.ndarray) -> np.ndarray:
    """Return the step of each encoder: the smallest change of its positions, shape (n,)."""
    steps = []
    for column in q.T:
        changes = np.abs(np.diff(column))
        changes = changes[changes > 1e-9]
        steps.append(np.quantile(changes, 0.01) if len(changes) else 1e-9)
    return np.array(steps)


def _result(samples: Samples, rows: np.ndarray, v: np.ndarray, a: np.ndarray,
            begin: float) -> Result:
    cost = 1e6 * (perf_counter() - begin) / len(rows)
    return Result(rows, samples.stamps[rows], v, a, 0.0, cost)
