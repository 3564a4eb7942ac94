# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Chains and motions on which programs are compared with the recursion."""
import numpy as np

from screw_kinematics import Joint, Mimic, SerialChain
from screw_kinematics.screws.se3 import rotation_about

OUTPUTS = ('pose', 'twist', 'accel', 'reduced_accel', 'jerk', 'reduced_jerk', 'snap',
           'reduced_snap', 'jacobian')


def displacement(axis, angle, position):
    T = np.eye(4)
    T[:3, :3] = rotation_about(np.array(axis) / np.linalg.norm(axis), angle)
    T[:3, 3] = position
    return T


def from_dh(d, a, alpha):
    T, joints = np.eye(4), []
    for k in range(len(d)):
        joints.append(Joint(f'q{k + 1}', 'revolute', axis=T[:3, 2], point=T[:3, 3]))
        T = T @ displacement([0, 0, 1], 0.0, [0, 0, d[k]])
        T = T @ displacement([1, 0, 0], alpha[k], [a[k], 0, 0])
    return SerialChain(joints, T)


def panda():
    z, y = np.array([0, 0, 1]), np.array([0, 1, 0])
    axes = [z, y, z, -y, z, -y, -z]
    points = [(0, 0, 0.333), (0, 0, 0.333), (0, 0, 0.649), (0.0825, 0, 0.649),
              (0, 0, 1.033), (0, 0, 1.033), (0.088, 0, 1.033)]
    flange = displacement([1, 0, 0], np.pi, [0.088, 0, 1.033])
    hand = displacement([0, 0, 1], -np.pi / 4, [0, 0, 0.2104])
    return SerialChain([Joint(f'q{k}', 'revolute', axis, point)
                        for k, (axis, point) in enumerate(zip(axes, points))], flange @ hand)


def puma():
    return from_dh(np.array([0, 144.09, 0, 433.07, 0, 56.25]) / 1e3,
                   np.array([0, 431.8, -20.32, 0, 0, 0]) / 1e3,
                   np.array([-1, 0, 1, -1, 1, 0]) * np.pi / 2)


def rpr():
    return SerialChain([Joint('q1', 'revolute', (0, 0, 1)),
                        Joint('q2', 'prismatic', (1, 0, 0)),
                        Joint('q3', 'revolute', (0, 0, 1))],
                       displacement([0, 0, 1], 0.0, [0.3, 0, 0]))


def skew_axes(seed, n):
    """Return a chain of all kinds of joints with axes in no special position."""
    rng = np.random.default_rng(seed)
    kinds = ['helical', 'prismatic', 'revolute', 'continuous']
    joints = [Joint(f'q{k}', kinds[k % 4], rng.normal(size=3), rng.normal(size=3),
                    pitch=rng.normal() if k % 4 == 0 else 0) for k in range(n)]
    return SerialChain(joints, displacement(rng.normal(size=3), 2.0, rng.normal(size=3)))


def mimicking():
    rng = np.random.default_rng(5)
    kinds = ['revolute', 'prismatic', 'helical', 'revolute', 'revolute']
    mimics = [None, Mimic('a', 0.3, 0.1), Mimic('a', -2.0), None, Mimic('elsewhere', 1, -1)]
    return SerialChain(
        [Joint(name, kind, rng.normal(size=3), rng.normal(size=3),
               pitch=0.2 if kind == 'helical' else 0, mimic=mimic)
         for name, kind, mimic in zip('abcde', kinds, mimics)],
        displacement(rng.normal(size=3), 1.0, rng.normal(size=3)))


def scara():
    """Return a chain with parallel axes of all kinds, along and against each other."""
    return SerialChain(
        [Joint('a', 'revolute', (0, 0, 1)), Joint('b', 'revolute', (0, 0, -1), (0.4, 0.1, 0)),
         Joint('c', 'prismatic', (0.6, 0, 0.8)), Joint('d', 'prismatic', (0, 0, -1)),
         Joint('e', 'helical', (0, 0, 1), (0.7, 0, 0.2), pitch=0.1),
         Joint('f', 'revolute', (0, 1, 1), (0.7, 0.2, 0))],
        displacement([0, 0, 1], 0.5, [0.8, 0.1, -0.3]))


CHAINS = {'panda': panda(), 'puma': puma(), 'rpr': rpr(), 'skew4': skew_axes(1, 4),
          'skew6': skew_axes(2, 6), 'mimic': mimicking(),
          'slide': SerialChain([Joint('q', 'prismatic', (0, 1, 0))]),
          'fixed': SerialChain([], displacement([1, 2, 3], 1.0, [1, 2, 3])),
          'scara': scara()}


def motion(chain, n, order=4, seed=0):
    rng = np.random.default_rng(seed)
    return [rng.normal(size=(n, chain.dof)) * (3.0 if k == 0 else 1.0)
            for k in range(order + 1)]


def reference(chain, motion, axes='base', pole='tip'):
    """Return the outputs as the recursion itself gives them."""
    state = chain.state(*motion).about(pole).expressed_in(axes)
    rows = len(motion[0])
    columns = np.zeros((rows, 6, chain.dof))
    for joint, screw in zip(chain.joints, np.moveaxis(chain.screws(motion[0], pole), 1, 0)):
        if axes == 'tip':
            turned = np.swapaxes(state.pose[:, :3, :3], 1, 2)
            screw = (turned[:, None] @ screw.reshape(-1, 2, 3, 1)).reshape(-1, 6)
        factor = joint.mimic.multiplier if joint.mimic else 1
        columns[:, :, chain.joint_names.index(joint.source)] += factor * screw
    names = ('twist', 'accel', 'jerk', 'snap')
    return {
        'pose': np.hstack([state.pose[:, :3, 3], state.pose[:, :3, :3].reshape(-1, 9)]),
        'jacobian': columns.reshape(rows, -1),
        **{name: state.classical(n) for n, name in enumerate(names, start=1)},
        **{f'reduced_{name}': state.reduced[n] for n, name in enumerate(names[1:], start=1)}}


def assert_close(actual, expected, tolerance=1e-13):
    """Compare relative to the largest value of each sample, 1 at least."""
    scale = np.maximum(1.0, np.abs(expected).max(axis=-1, keepdims=True, initial=0.0))
    assert actual.shape == expected.shape
    assert np.all(np.abs(actual - expected) <= tolerance * scale)
