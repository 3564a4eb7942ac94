# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Chains that tests share."""
from pathlib import Path

import numpy as np

from screw_kinematics import Joint, models, SerialChain
from screw_kinematics.screws import se3

ROBOTS = Path(__file__).parents[2] / 'config' / 'robots'
KINDS = ('revolute', 'prismatic', 'helical')


def random_chain(seed, kinds=None, joints=6):
    """Return a chain with random geometry; kinds drawn at random unless given."""
    rng = np.random.default_rng(seed)
    kinds = rng.choice(KINDS, size=joints) if kinds is None else kinds
    return SerialChain(
        [Joint(f'q{i + 1}', str(kind), axis=rng.normal(size=3), point=rng.normal(size=3),
               pitch=rng.normal() if kind == 'helical' else 0)
         for i, kind in enumerate(kinds)],
        se3.exp(rng.normal(size=6)))


def random_motion(seed, dof, order=4, shape=()):
    """Return joint positions and their derivatives up to an order."""
    return np.random.default_rng(seed + 1000).normal(size=(order + 1, *shape, dof))


def robot(name):
    """Return one of the package's robots."""
    return models.load(str(ROBOTS / f'{name}.yaml'))
