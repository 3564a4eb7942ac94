# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Differentiators of other packages, each joint by itself.

None of them knows irregular steps but kalmangrad and scipy's spline: the others are given the
median one. Where a method is to be tuned, several tunings run and the best counts, chosen with
knowledge of the truth.
"""

from __future__ import annotations

from contextlib import redirect_stderr, redirect_stdout
from importlib.util import find_spec
import io
from math import pi
from time import perf_counter
from typing import Any
import warnings

from benchmark.estimation.samples import Result, Samples
import numpy as np

from screw_kinematics.motion.divided_differences import roughness

PACKAGES = {'pynumdiff': 'pynumdiff', 'AlgDiff': 'AlgDiff', 'kalmangrad': 'kalmangrad',
            'scipy': 'scipy'}
"""What pip calls the packages, by the module."""


def missing(module: str) -> str:
    """Return how a package is installed that is not there, else nothing."""
    return '' if find_spec(module) else f'pip install {PACKAGES[module]}'


def pynumdiff_filter(samples: Samples, bandwidth: float) -> Result:
    """Run pynumdiff's Kalman filter with white noise integrated four times."""
    return _pynumdiff(samples, bandwidth, False)


def pynumdiff_rts(samples: Samples, bandwidth: float) -> Result:
    """Run pynumdiff's Rauch-Tung-Striebel smoother on the same model."""
    return _pynumdiff(samples, bandwidth, True)


def _pynumdiff(samples: Samples, bandwidth: float, both_sides: bool) -> Result:
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')         # of methods that need cvxpy
        from pynumdiff.kalman_smooth import kalman_filter, rts_smooth
    from screw_kinematics.motion.wiener_process import process_noise, SCALE, transition
    rows, begin, period = samples.increasing(), perf_counter(), samples.period()
    a, noise = transition(period), (2 * pi * bandwidth)**8 * period * process_noise(4, period)
    v, acceleration = [], []
    for y in samples.positions[rows].T:
        start = np.zeros(4)
        start[0] = y[0]
        passed = kalman_filter(y, start, np.diag([1.0, 1e9, 1e9, 1e9]), a, noise,
                               np.eye(1, 4), np.eye(1))
        state = rts_smooth(a, *passed, compute_P_smooth=False) if both_sides else passed[1]
        v.append(state[:, 1] / SCALE[1])
        acceleration.append(state[:, 2] / SCALE[2])
    return _result(samples, rows, v, acceleration, float('inf') if both_sides else 0.0, begin)


def algebraic(samples: Samples, window: float) -> Result:
    """Run AlgDiff's algebraic differentiator; it describes the middle of its window (s)."""
    from AlgDiff import AlgebraicDifferentiator
    rows, begin, period = samples.increasing(), perf_counter(), samples.period()
    with redirect_stdout(io.StringIO()):
        differentiator = AlgebraicDifferentiator(
            ts=period, alpha=4.0, beta=4.0, N=0, T=max(window, 6 * period), display=False)
        v, a = ([differentiator.estimateDer(order, y - y[0], 'analytic', 'valid')
                 for y in samples.positions[rows].T] for order in (1, 2))
    delay = float(differentiator.get_delayDiscrete()['analytic'])
    full = slice(int(np.ceil(max(window, 6 * period) / period)) + 1, None)
    result = _result(samples, rows, v, a, delay, begin)
    return result._replace(rows=rows[full], t=result.t[full] - delay,
                           velocity=result.velocity[full], acceleration=result.acceleration[full])


def kalmangrad(samples: Samples, bandwidth: float) -> Result:
    """Run kalmangrad's smoother; the noise is what fourth differences leave of positions."""
    from kalmangrad import grad
    rows, begin, period = samples.increasing(), perf_counter(), samples.period()
    t, q = samples.stamps[rows], samples.positions[rows]
    v, a = [], []
    for y, noise in zip(q.T, np.maximum(roughness(t, q), 1e-9)):
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            states, times = grad(y / noise, t, 3, period, 1.0, False,
                                 (2 * pi * bandwidth)**8 * period**2)
        mean = noise * np.array([np.ravel(state.mean()) for state in states])
        v.append(np.interp(t, times, mean[:, 1]))
        a.append(np.interp(t, times, mean[:, 2]))
    return _result(samples, rows, v, a, float('inf'), begin)


def savitzky_golay(samples: Samples, window: float) -> Result:
    """Run scipy.signal.savgol_filter, cubic, centred in a window (s)."""
    from scipy.signal import savgol_filter
    rows, begin, period = samples.increasing(), perf_counter(), samples.period()
    length = max(5, 2 * round(window / period / 2) + 1)
    v, a = (savgol_filter(samples.positions[rows], length, 3, order, period, axis=0)
            for order in (1, 2))
    return _result(samples, rows, v.T, a.T, float('inf'), begin)


def smoothing_spline(samples: Samples, _: Any) -> Result:
    """Run scipy.interpolate.make_smoothing_spline, tuned by its cross-validation."""
    from scipy.interpolate import make_smoothing_spline
    rows, begin = samples.increasing(), perf_counter()
    t = samples.stamps[rows]
    v, a = [], []
    for y in samples.positions[rows].T:
        spline = make_smoothing_spline(t, y)
        v.append(spline.derivative(1)(t))
        a.append(spline.derivative(2)(t))
    return _result(samples, rows, v, a, float('inf'), begin)


def _result(samples: Samples, rows: np.ndarray, v: Any, a: Any, behind: float,
            begin: float) -> Result:
    cost = 1e6 * (perf_counter() - begin) / len(rows)
    return Result(rows, samples.stamps[rows], np.transpose(v), np.transpose(a), behind, cost)
