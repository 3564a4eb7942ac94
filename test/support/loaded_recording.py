# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Bags of the loaded arm's joint states and wrenches."""
from functools import cache

import numpy as np

from . import loaded_arm as arm, recordings as rec

WRENCH = 'geometry_msgs/msg/WrenchStamped'
ZERO = rec.START


def wrench(stamp, values, frame=arm.FRAME):
    """Return a serialized WrenchStamped."""
    types = rec.TYPES.types
    vector = types['geometry_msgs/msg/Vector3']
    message = types[WRENCH](rec.header(stamp, frame), types['geometry_msgs/msg/Wrench'](
        vector(*map(float, values[:3])), vector(*map(float, values[3:]))))
    return bytes(rec.TYPES.serialize_cdr(message, WRENCH))


def write(path, **options):
    """Write a bag of such messages; return its path."""
    return rec.write_bag(path, messages(**options))


@cache
def messages(seconds=8.0, begin=0.0, speed=1.8, offset=0.0, sign=1.0, frame=arm.FRAME,
             shift=0.0, contact=None, still=False, seed=0):
    """
    Return joint states and wrenches in order.

    Wrenches have stamps that are early by `offset` [s], are of the opposite sign, or of another
    time (`shift`); `contact` adds a wrench to those at some times.
    """
    t = begin + np.arange(0, seconds, 0.002)
    q, qd = arm.readings(t, speed)
    at = begin + np.arange(0.0007, seconds, 0.0025)
    shown = arm.wrenches(at + offset, speed)
    if still:
        q, qd, shown = q[:1].repeat(len(q), 0), 0 * qd, shown[:1].repeat(len(shown), 0)
    shown = sign * (shown - arm.BIAS) + arm.BIAS
    if contact is not None:
        shown[contact(at)] += [20.0, 5.0, -10.0, 1.0, 2.0, 0.5]
    shown = shown + arm.NOISE * np.random.default_rng(seed).normal(size=shown.shape)
    found = []
    for stamp, position, velocity in zip(np.rint(t * 1e9).astype(np.int64).tolist(), q, qd):
        found.append(('/joint_states', rec.JOINT_STATE, ZERO + stamp,
                      rec.joint_state(ZERO + stamp, arm.NAMES, position, velocity)))
    for stamp, values in zip(np.rint((at + shift) * 1e9).astype(np.int64).tolist(), shown):
        found.append(('/ft', WRENCH, ZERO + stamp, wrench(ZERO + stamp, values, frame)))
    return sorted(found, key=lambda m: m[2])
