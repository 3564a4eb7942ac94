# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Motions with exact derivatives, and how an encoder would report them."""

import numpy as np


def sines(seed, n_joints, highest=4.0):
    """Return a function of time: position and three derivatives of sums of sines, (4, N, n)."""
    rng = np.random.default_rng(seed)
    omega = 2 * np.pi * rng.uniform(0.2, highest, (6, n_joints))
    amplitude = rng.uniform(1.0, 3.0, (6, n_joints)) / omega**2
    phase = rng.uniform(0, 2 * np.pi, (6, n_joints))
    factors = [(-1)**(k // 2) * amplitude * omega**k for k in range(4)]

    def motion(t):
        angle = np.asarray(t)[..., None, None] * omega + phase
        waves = np.sin(angle), np.cos(angle)
        return np.stack([np.einsum('...wj,wj->...j', waves[k % 2], factor)
                         for k, factor in enumerate(factors)])

    return motion


def jumps(seed, n_joints, seconds=5.0):
    """Return a motion whose accelerations jump, twice a second or so, and whose jerk is zero."""
    rng = np.random.default_rng(seed)
    begins = np.cumsum(rng.uniform(0.2, 0.8, (int(5 * seconds), n_joints)), axis=0) - 0.2
    steps = np.diff(rng.uniform(-3.0, 3.0, (len(begins) + 1, n_joints)), axis=0)

    def motion(t):
        since = np.maximum(np.asarray(t)[..., None, None] - begins, 0.0)
        return np.stack([(steps * along).sum(axis=-2)
                         for along in (since**2 / 2.0, since, since > 0.0, 0.0 * since)])

    return motion


def samples(motion, rate, seconds, seed, resolution=1e-5, jitter=0.0):
    """Return stamps, quantised positions (with a little noise before quantisation)."""
    rng = np.random.default_rng(seed)
    count = int(rate * seconds)
    stamps = (np.arange(count) + jitter * rng.uniform(-0.5, 0.5, count)) / rate
    exact = motion(stamps)[0]
    noisy = exact + 0.3 * resolution * rng.normal(size=exact.shape)
    return stamps, np.round(noisy / resolution) * resolution


def run(estimator, stamps, positions, velocities=None):
    """Return the claimed stamps (N,), states (N, 4, n) and covariances' diagonals (N, 4, n)."""
    claimed, states, variances = [], [], []
    for k, (stamp, position) in enumerate(zip(stamps, positions)):
        motion = estimator.update(stamp, position, None if velocities is None else velocities[k])
        if motion is not None:
            claimed.append(motion.stamp)
            states.append(motion.values)
            variances.append(motion.variances if k % 5 == 0 else [np.nan] * len(motion.values))
    shape = len(claimed), 4, -1
    return np.array(claimed), np.array(states).reshape(shape), np.array(variances).reshape(shape)


def acceleration_error(motion, claimed, states, settled=0.8):
    """Return the RMS error of the acceleration at the claimed stamps."""
    late = claimed > settled
    truth = motion(claimed[late])[2]
    return np.sqrt(np.mean((states[late, 2] - truth) ** 2))
