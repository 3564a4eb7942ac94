# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Compiled and interpreted, the estimators give the same bits."""

import os
from pathlib import Path
import subprocess
import sys

import numpy as np
import pytest
from screw_kinematics.core import build, INTERPRETED
from screw_kinematics.motion import MotionEstimator, smooth
from support.motions import samples, sines

ROOT = Path(__file__).parents[2]


def outputs():
    """Return what estimators and smoother make of a reader with faults, as a row of numbers."""
    motion = sines(3, 2)
    stamps, positions = samples(motion, 500, 0.9, 3, jitter=0.2)
    rng = np.random.default_rng(3)
    velocities = motion(stamps - 1e-3)[1] + 1e-3 * rng.normal(size=positions.shape)
    positions[200] = positions[199]
    positions[300, 1] += 0.01
    stamps[250:255] += 7e-3
    values = []
    for delay in (0.0, 0.02):
        estimator = MotionEstimator(2, delay)
        for k in range(len(stamps)):
            found = estimator.update(stamps[k], positions[k], velocities[k] if k > 100 else None)
            if found is not None and k % 7 == 0:
                values += [*found.values, *found.covariance.ravel()]
    smoothed = smooth(stamps[:150], positions[:150], velocities[:150])
    return np.array([*values, *smoothed.acceleration.ravel(), *smoothed.variance.ravel()])


@pytest.mark.skipif(not build().compiled, reason='the core is not compiled')
def test_interpreted_gives_the_same_bits():
    code = ('import sys; from screw_kinematics.core import bank;'
            'assert bank.__file__.endswith(".py");'
            'from motion.test_interpreted import outputs;'
            'sys.stdout.buffer.write(outputs().tobytes())')
    interpreted = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, check=True, cwd=ROOT,
        env=os.environ | {INTERPRETED: '1', 'PYTHONPATH': f'{ROOT}:{ROOT / "test"}'}).stdout
    compiled = outputs()
    np.testing.assert_array_equal(np.frombuffer(interpreted), compiled)
    assert np.isfinite(compiled).all() and len(compiled) > 5000
